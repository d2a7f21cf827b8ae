"""The same taxels in every taxel format, and a robot with a rod that has these taxels."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.robots.load import load_robot_file
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.formats.taxel_files import write_taxels
from tactile_maps.skin.model.skin_file import save_skin
from tactile_maps.skin.model.taxel_set import TaxelSet

LINK = "rod"
RADIUS = 0.03
FORMATS = (
    "icub.txt",
    "table.csv",
    "table.tsv",
    "genoa.json",
    "table.npz",
    "sensors.urdf",
    "skin.npz",
    "map.npz",
    "robot_in_its_skin.urdf",
)
_ROBOT = f"""<robot name="rods"><link name="base"/>
  <link name="{LINK}"><visual><geometry><cylinder radius="{RADIUS}" length="0.2"/></geometry></visual>
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="{LINK}"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
"""


def cylinder_taxels(*, link: str | None = LINK) -> TaxelSet:
    """Return 30 taxels on a quarter of the rod, 9 mm apart, in modules of twelve rows."""
    turn, up = np.meshgrid(0.3 * np.arange(5), 0.009 * np.arange(6) - 0.02)
    normals = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1).reshape(-1, 3)
    positions = RADIUS * normals + np.array([0, 0, 1]) * up.reshape(-1, 1)
    ids = np.array([n for n in range(40) if n % 12 not in (6, 10)][:30])
    return TaxelSet("rod", link, ids, positions, normals, ids=ids, modules=ids // 12, channels=ids % 12)


def write_formats(folder: Path) -> dict[str, Path]:
    """Write the robot as ``robot.urdf``, and the taxels in all ``FORMATS``."""
    files = {name: folder / name for name in (*FORMATS, "robot.urdf")}
    files["robot.urdf"].write_text(_ROBOT + "</robot>")
    taxels = cylinder_taxels()
    for name in ("icub.txt", "table.csv", "genoa.json", "table.npz", "sensors.urdf"):
        write_taxels(taxels, files[name])
    files["table.tsv"].write_text(files["table.csv"].read_text().replace(",", "\t"))
    sensors = files["sensors.urdf"].read_text()
    sensors = sensors[sensors.index("<sensor") : sensors.index("</robot>")]
    files["robot_in_its_skin.urdf"].write_text(f"{_ROBOT}{sensors}</robot>")
    robot = load_robot_file(files["robot.urdf"])
    skin = place_taxels(robot, LINK, taxels, file="rod")
    save_skin(skin, files["skin.npz"])
    save_map(build_map(skin), files["map.npz"])
    return files
