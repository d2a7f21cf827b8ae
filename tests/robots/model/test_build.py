"""Building a robot from a spec: links become triangles, and the model can be simulated."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model import build
from tactile_maps.robots.model.build import build_robot, check_magnitudes, link_mesh


def mesh_of(geoms: str) -> Mesh | None:
    text = f'<mujoco><worldbody><body name="b"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>{geoms}</body></worldbody></mujoco>'  # noqa: E501
    return link_mesh(mujoco.MjModel.from_xml_string(text), 1)


@pytest.mark.parametrize(
    ("geom", "area", "half"),
    [
        ('type="box" size=".1 .2 .3"', 0.88, (0.1, 0.2, 0.3)),
        ('type="sphere" size=".2"', 4 * np.pi * 0.04, (0.2, 0.2, 0.2)),
        ('type="cylinder" size=".1 .3"', 2 * np.pi * 0.1 * 0.6 + 2 * np.pi * 0.01, (0.1, 0.1, 0.3)),
        ('type="capsule" size=".1 .3"', 2 * np.pi * 0.1 * 0.6 + 4 * np.pi * 0.01, (0.1, 0.1, 0.4)),
        ('type="ellipsoid" size=".1 .1 .3"', 0.3084, (0.1, 0.1, 0.3)),
    ],
)
def test_meshes_of_primitives_are_centred_closed_and_of_the_right_size(geom, area, half):
    mesh = mesh_of(f"<geom {geom}/>")
    assert mesh is not None
    assert mesh.area == pytest.approx(area, rel=0.02)
    assert mesh.bounds == pytest.approx(np.array([half, half]) * [[-1], [1]], abs=2e-3)
    assert np.abs((mesh.face_normals * mesh.face_areas[:, None]).sum(axis=0)).max() < 1e-9
    centroids = mesh.vertices[mesh.faces].mean(axis=1)
    assert ((centroids * mesh.face_normals).sum(axis=1) > -1e-9).all()


def test_geoms_are_placed_in_the_body_frame():
    mesh = mesh_of('<geom type="box" size=".1 .2 .3" pos="1 2 3" euler="0 0 90"/>')
    assert mesh is not None
    assert mesh.bounds == pytest.approx(np.array([[0.8, 1.9, 2.7], [1.2, 2.1, 3.3]]))


def test_mesh_of_a_link_prefers_visual_geoms():
    collision = '<geom size=".3" group="3"/>'
    visual = '<geom size=".1" contype="0" conaffinity="0"/>'
    for geoms, size in ((collision + visual, 0.1), (collision, 0.3), ('<geom size=".2"/>' + collision, 0.2)):
        mesh = mesh_of(geoms)
        assert mesh is not None
        assert mesh.bounds[1, 2] == pytest.approx(size, rel=0.01)


def test_body_without_shape_has_no_mesh():
    assert mesh_of("") is None


PENDULUM = """<mujoco><worldbody><body name="bob" pos="{pos}"><joint axis="1 0 0" {joint}/>
<geom type="sphere" size="{size}" mass="1" pos="0 0 1"/></body></worldbody></mujoco>"""


def model_of(pos: str = "0 0 0", joint: str = "", size: str = "0.1") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(PENDULUM.format(pos=pos, joint=joint, size=size))


@pytest.mark.parametrize("numbers", [{"pos": "0 0 1e300"}, {"size": "1e9"}, {"pos": "0 -inf 0"}])
def test_implausible_numbers_are_rejected_with_the_body(numbers):
    with pytest.raises(RobotError, match=r"bob\.xml, body bob: .*implausibly large"):
        check_magnitudes(model_of(**numbers), "bob.xml")


TWO = """<mujoco><compiler angle="radian"/><worldbody><body name="base"><geom size="0.1"/><body name="arm" pos="0 0 1">
<joint name="slide" type="slide" range="-1 1"/><joint name="free" axis="1 0 0"/>
<geom size="0.1" mass="MASS"/></body></body></worldbody></mujoco>"""


def robot_of(text: str, **options: object) -> build.Robot:
    return build_robot(mujoco.MjSpec.from_string(text), name="two", source="two.xml", assets={}, **options)


def test_joints_keep_kind_and_limits():
    robot = robot_of(TWO.replace("MASS", "1"))
    slide, free = robot.joints
    assert (slide.slide, slide.lower, slide.upper) == (True, -1, 1)
    assert (free.slide, free.lower, free.upper) == (False, -float("inf"), float("inf"))


def test_masses_are_stated_so_that_later_shapes_do_not_change_them():
    robot = robot_of(TWO.replace("MASS", "3"))
    assert robot.mjcf.count("<inertial") >= 1
    assert 'mass="3"' in robot.mjcf


def test_requested_home_is_used():
    assert robot_of(TWO.replace("MASS", "1"), home={"slide": 0.5}).home == pytest.approx([0.5, 0])


def test_too_many_bodies_are_rejected(monkeypatch):
    monkeypatch.setattr(build, "MAX_BODIES", 2)
    with pytest.raises(RobotError, match="more than 2 bodies"):
        robot_of(TWO.replace("MASS", "1"))


def test_each_use_of_a_mesh_counts_for_the_limit_of_triangles(monkeypatch):
    use = '<geom type="mesh" mesh="m" mass="1"/>'
    text = (
        '<mujoco><asset><mesh name="m" builtin="sphere" params="2"/></asset><worldbody><body name="few">'
        f'{use}<body name="many"><joint/>{use * 3}<geom size="0.1"/></body></body></worldbody></mujoco>'
    )
    monkeypatch.setattr(build, "MAX_FACES", 4 * 320)
    assert len(robot_of(text).links) == 2
    monkeypatch.setattr(build, "MAX_FACES", 4 * 320 - 1)
    with pytest.raises(RobotError, match=r"two\.xml, link many: .*each use of a mesh counted \(found: 1280\)"):
        robot_of(text)


def test_moving_body_without_mass_gets_a_small_mass():
    robot = robot_of(TWO.replace("MASS", "0"))
    assert [finding.kind for finding in robot.findings if finding.kind == "massless"] == ["massless"]
    assert 'mass="1e-06"' in robot.mjcf


def test_repeated_name_of_a_joint_is_reported(tmp_path):
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    link = f'<link name="{{}}"><inertial><mass value="1"/>{inertia}</inertial></link>'
    joint = '<joint name="j" type="continuous"><parent link="a"/><child link="{}"/></joint>'
    text = "".join(link.format(name) for name in "abc") + "".join(joint.format(name) for name in "bc")
    path = tmp_path / "twice.urdf"
    path.write_text(f'<robot name="r">{text}</robot>')
    with pytest.raises(RobotError, match=r"twice\.urdf, joint j: 2 joints have the same name.*Rename all but one"):
        load_robot_file(path)
