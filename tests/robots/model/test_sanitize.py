"""A spec stripped to the robot, meshes without volume, links that may never collide."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import RobotError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.formats.mjcf import load_mjcf
from tactile_maps.robots.model import sanitize
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.sanitize import collision_exclusions, keyframe_home, name_unnamed_elements, strip_scene

GRIPPER = """<mujoco><worldbody><camera name="c"/><site name="w"/><body name="palm"><geom size="0.1"/><site name="s"/>
<body><joint name="a"/><geom size="0.1"/></body><body name="link_3"><joint name="b"/><geom size="0.1"/></body>
<body name="q" pos="1 0 0"><joint type="ball"/><geom size="0.1"/><body name="r"><joint name="d"/><geom size="0.1"/>
</body></body></body></worldbody>
<equality><joint joint1="a" joint2="b"/><connect site1="s" site2="w"/></equality>
<keyframe><key name="first" qpos="1 2 1 0 0 0 3"/><key name="home" qpos="4 5 1 0 0 0 6"/></keyframe></mujoco>"""


def test_keyframe_is_read_with_joints_of_any_kind():
    spec = mujoco.MjSpec.from_string(GRIPPER)
    assert {name: value for name, value in keyframe_home(spec).items() if name} == {"a": 4, "b": 5, "d": 6}
    assert keyframe_home(mujoco.MjSpec.from_string(GRIPPER.replace('name="home"', 'name="x"')))["a"] == 1
    assert keyframe_home(mujoco.MjSpec.from_string(GRIPPER.replace('"4 5 1 0 0 0 6"', '"4 5"'))) == {}
    assert keyframe_home(mujoco.MjSpec()) == {}


def test_couplings_of_joints_are_kept_and_those_of_sites_deleted():
    spec = mujoco.MjSpec.from_string(GRIPPER.replace('<joint type="ball"/>', ""))
    strip_scene(spec, "gripper")
    assert [equality.name1 for equality in spec.equalities] == ["a"]
    assert (list(spec.sites), list(spec.cameras), list(spec.keys)) == ([], [], [])


def test_unnamed_elements_get_unique_names():
    spec = mujoco.MjSpec.from_string(GRIPPER.replace("<body><joint", "<body><joint/><joint"))
    findings = name_unnamed_elements(spec)
    names = [body.name for body in spec.bodies]
    assert len(set(names)) == len(names)
    assert all(names)
    assert all(joint.name for joint in spec.joints)
    assert findings[0].kind == "unnamed"
    assert name_unnamed_elements(spec) == []


SQUARE = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), np.array([[0, 1, 2], [1, 3, 2]]))


def export(path: Path, vertices: object, faces: object) -> None:
    trimesh.Trimesh(vertices, faces, process=False).export(path)


def test_flat_mesh_is_visible_without_collision(tiny):
    export(tiny.parent / "meshes" / "rod.stl", SQUARE.vertices, SQUARE.faces)
    robot = load_mjcf(tiny)
    mesh = robot.link("rod").mesh
    assert mesh is not None
    assert mesh.area == pytest.approx(1.0)
    assert {finding.kind: finding.where for finding in robot.findings}["flat-mesh"] == "rod"


@pytest.mark.sampled(4)
@pytest.mark.parametrize("cut", [20, 100, 200, 320])
@pytest.mark.parametrize("turn", [1, -1])
def test_open_and_inside_out_meshes_load(tiny, cut, turn):
    ball = trimesh.creation.icosphere(2)
    export(tiny.parent / "meshes" / "rod.stl", ball.vertices, ball.faces[:cut, ::turn])
    mesh = load_mjcf(tiny).link("rod").mesh
    assert mesh is not None
    assert len(mesh.faces) == cut


def test_mesh_whose_volumes_cancel_loads(tiny):
    ball = trimesh.creation.icosphere(1)
    other = ball.vertices + np.array([3.0, 0, 0])
    faces = np.vstack([ball.faces, ball.faces[:, ::-1] + len(ball.vertices)])
    export(tiny.parent / "meshes" / "rod.stl", np.vstack([ball.vertices, other]), faces)
    assert load_mjcf(tiny).link("rod").mesh is not None


def test_hull_of_many_vertices_is_limited_and_reported(tiny, monkeypatch):
    export(tiny.parent / "meshes" / "rod.stl", *_ball(3))
    assert "hull-limited" not in {finding.kind for finding in load_mjcf(tiny).findings}
    monkeypatch.setattr(sanitize, "MAX_HULL_VERTICES", 200)
    robot = load_mjcf(tiny)
    assert {finding.kind: finding.where for finding in robot.findings}["hull-limited"] == "rod"
    model = compile_spec(robot_spec(robot), source="tiny")
    assert model.mesh_graph[model.mesh_graphadr[0]] == 200, "the robot's own text states the limit"
    mesh = robot.link("rod").mesh
    assert mesh is not None
    assert len(mesh.vertices) == 642, "the shape that is drawn and covered stays"


def _ball(subdivisions: int) -> tuple[object, object]:
    ball = trimesh.creation.icosphere(subdivisions)
    return ball.vertices, ball.faces


def test_too_many_deletions_are_rejected(monkeypatch):
    monkeypatch.setattr(sanitize, "MOST_DELETED", 2)
    equality = '<equality><tendon tendon1="a"/><tendon tendon1="a"/></equality>'
    text = GRIPPER.replace("</mujoco>", f"{equality}</mujoco>")
    with pytest.raises(RobotError, match="elements of kind equality.*found: 3.*The maximum is 2"):
        strip_scene(mujoco.MjSpec.from_string(text), "gripper.xml")


CHAIN = """<mujoco><worldbody><body name="base"><geom size="0.1"/>
<body name="near" pos="0 0 0.1"><joint axis="0 1 0" limited="true" range="-90 90"/><geom size="0.1"/>
<body name="mid" pos="0 0 0.1"><joint axis="0 1 0" limited="true" range="-90 90"/><geom size="0.1"/>
<body name="far" pos="0 0 1"><joint type="slide" axis="0 0 1" limited="true" range="-1.2 5"/><geom size="0.1"/>
</body></body></body></body></worldbody></mujoco>"""


def test_exclusions_of_the_robots_own_links_are_kept():
    own = '<exclude name="own" body1="palm" body2="link_3"/><exclude name="crate" body1="palm" body2="crate"/>'
    crate = '<body name="crate" pos="3 0 0"><freejoint/><geom size="0.1"/></body>'
    text = GRIPPER.replace("</worldbody>", f"{crate}</worldbody><contact>{own}</contact>")
    spec = mujoco.MjSpec.from_string(text)
    strip_scene(spec, "gripper.xml")
    assert [exclude.name for exclude in spec.excludes] == ["own"]


def test_only_permanent_overlaps_are_excluded_from_collision():
    model = mujoco.MjModel.from_xml_string(CHAIN)
    assert collision_exclusions(model, np.zeros(3)) == [("base", "mid"), ("base", "near")]


def test_pair_that_touches_at_home_is_excluded():
    model = mujoco.MjModel.from_xml_string(CHAIN)
    assert ("near", "far") in collision_exclusions(model, np.array([0.0, 0.0, -1.1]))


def test_child_of_a_fixed_link_is_excluded_also_without_overlap():
    model = mujoco.MjModel.from_xml_string(CHAIN.replace('name="near" pos="0 0 0.1"', 'name="near" pos="0 0 3"'))
    assert collision_exclusions(model, np.zeros(3)) == [("base", "near")]


def test_only_shapes_that_collide_count_as_crowded(monkeypatch):
    monkeypatch.setattr(sanitize, "MAX_NEAR_PAIRS", 1)
    with pytest.raises(RobotError, match="too many.*inside each other.*more than 1 pairs"):
        collision_exclusions(mujoco.MjModel.from_xml_string(CHAIN), np.zeros(3))
    shown = CHAIN.replace('<geom size="0.1"/>', '<geom size="0.1" contype="0" conaffinity="0"/>')
    assert collision_exclusions(mujoco.MjModel.from_xml_string(shown), np.zeros(3)) == [("base", "near")]
