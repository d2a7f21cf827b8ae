"""Files of every kind that can be identified, written by this program or by the libraries that others use."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path

import trimesh
from mcap.writer import Writer

from tactile_maps.core.assets import asset
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.recording.recorder import Recorder
from tactile_maps.robots.files.mesh_files import box_mesh, to_msh
from tactile_maps.session.session import Session
from tests.support.taxel_formats import write_formats
from tests.support.touch import prepared_bar

KINDS: Mapping[str, FileKind] = {
    "own.toml": FileKind.SCENE,
    "robot.urdf": FileKind.ROBOT,
    "robot.xacro": FileKind.ROBOT,
    "arm.xml": FileKind.ROBOT,
    "arm.mjcf": FileKind.ROBOT,
    "robot_in_its_skin.urdf": FileKind.ROBOT_WITH_TAXELS,
    **{f"box{suffix}": FileKind.MESH for suffix in (".obj", ".stl", ".ply", ".off", ".gltf", ".glb", ".dae", ".msh")},
    "icub.txt": FileKind.TAXELS,
    "table.csv": FileKind.TAXELS,
    "table.tsv": FileKind.TAXELS,
    "table.npz": FileKind.TAXELS,
    "genoa.json": FileKind.TAXELS,
    "sensors.urdf": FileKind.TAXELS,
    "positions": FileKind.TAXELS,
    "skin.npz": FileKind.SKIN,
    "map.npz": FileKind.MAP,
    "LAYOUT.INI": FileKind.LAYOUT,
    "own.mcap": FileKind.RECORDING,
    "ros.mcap": FileKind.ROS_RECORDING,
    "study.csv": FileKind.STUDY_TABLE,
    "readings.csv": FileKind.READINGS,
    "readings_of_modules.csv": FileKind.READINGS,
}


def write_every_kind(folder: Path) -> dict[str, Path]:
    """Write a file for each name in ``KINDS``; return their paths by name."""
    files = write_formats(folder) | {name: folder / name for name in KINDS}
    files["own.toml"].write_text("robot = 'arm'\n[cover]\nlinks = ['hand']\ntaxels = 60\n")
    shutil.copy(files["robot.urdf"], files["robot.xacro"])
    shutil.copytree(asset("robots", "arm"), folder, dirs_exist_ok=True)
    shutil.copy(files["arm.xml"], files["arm.mjcf"])
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    for name, kind in KINDS.items():
        if kind is FileKind.MESH and name not in ("box.msh", "box.gltf"):
            box.export(files[name])
    gltf = trimesh.exchange.gltf.export_gltf(box, embed_buffers=True)
    files["box.gltf"].write_bytes(gltf["model.gltf"])
    files["box.msh"].write_bytes(to_msh(box_mesh(0.1)))
    files["positions"].mkdir()
    shutil.copy(files["icub.txt"], files["positions"])
    files["LAYOUT.INI"].write_text("[SENSORS]\ntriangle 0 0 0 0 1 0 0\n")
    session = Session(prepared_bar())
    with Recorder(session.prepared, files["own.mcap"]) as recorder:
        recorder.write(session.tick(), session.inputs)
    with files["ros.mcap"].open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="libmcap 1.0")
        writer.finish()
    files["readings.csv"].write_text("time,100,101\n0,1,2\n")
    files["readings_of_modules.csv"].write_text("# component: z\nt [ms];l_hand:3.1_x;joint:elbow\n0;1;2\n")
    shutil.copy(min(asset("findings").glob("*.csv")), files["study.csv"])
    return files
