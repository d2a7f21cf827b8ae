"""Small robots and meshes written to a folder, for the tests of the readers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

MJCF = """<mujoco model="tiny">
  <compiler angle="degree" meshdir="meshes"/>
  <asset><mesh name="rod" file="rod.stl"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="1 1 1"/>
    <body name="base" pos="0 0 0.5">
      <geom type="box" size="0.1 0.1 0.1" mass="1"/>
      <body name="rod" pos="0 0 0.3">
        <joint name="hinge" axis="0 1 0" range="-90 45" damping="0.1"/>
        <geom type="mesh" mesh="rod" mass="1"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor joint="hinge"/></actuator>
  <sensor><jointpos joint="hinge"/></sensor>
  <keyframe><key name="home" qpos="0.25" ctrl="1"/></keyframe>
</mujoco>
"""

URDF = """<robot name="two">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.2"/></geometry></visual></link>
  <link name="rod">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><mesh filename="FILE"/></geometry></visual>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="rod"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="0.5" effort="1" velocity="1"/>
  </joint>
</robot>
"""


@pytest.fixture
def rod() -> bytes:
    """A binary STL of a rod 0.4 m long."""
    return trimesh.creation.box((0.05, 0.05, 0.4)).export(file_type="stl")


@pytest.fixture
def tiny(tmp_path: Path, rod: bytes) -> Path:
    """An MJCF robot of two links in a folder with its mesh, and a scene around it."""
    folder = tmp_path / "tiny"
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "rod.stl").write_bytes(rod)
    (folder / "tiny.xml").write_text(MJCF)
    return folder / "tiny.xml"


@pytest.fixture
def urdf(tmp_path: Path, rod: bytes) -> Callable[[str], Path]:
    """Writes a URDF robot whose mesh is at the given address; ``rod.stl`` is in its folder."""

    def write(address: str) -> Path:
        folder = tmp_path / "two" / "urdf"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "rod.stl").write_bytes(rod)
        (folder / "two.urdf").write_text(URDF.replace("FILE", address))
        return folder / "two.urdf"

    return write
