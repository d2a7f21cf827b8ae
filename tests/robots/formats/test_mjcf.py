"""MJCF files: the robot alone comes in; what is hostile, absurd or broken is refused by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree.ElementTree import fromstring

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.files import mesh_files
from tactile_maps.robots.formats import mjcf
from tactile_maps.robots.formats.mjcf import load_mjcf, strip_mjcf
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.robot import Robot

FILE = Path("robot.xml")


@pytest.mark.parametrize(
    ("element", "problem"),
    [
        ('<replicate count="1000000000"/>', "too many copies"),
        ('<replicate count="100"><replicate count="100"/></replicate>', "too many copies"),
        ('<replicate count="inf"/>', "too many copies"),
        ('<replicate count="many"/>', "not a number"),
        ('<mesh builtin="supersphere" params="2000 1 1"/>', "too fine"),
        ('<mesh builtin="supersphere" params="nan 1 1"/>', "too fine"),
        ('<composite type="cable"/>', "not supported"),
        ('<flexcomp file="x"/>', "not supported"),
        ('<model file="x"/>', "not supported"),
    ],
)
def test_implausible_amounts_and_soft_bodies_are_rejected(element, problem):
    with pytest.raises(RobotError, match=problem):
        strip_mjcf(fromstring(f"<mujoco><worldbody><body>{element}</body></worldbody></mujoco>"), FILE)


def test_decoration_is_removed_without_its_files():
    root = fromstring(
        '<mujoco><asset><texture file="a.png"/><hfield file="b.png"/><mesh file="c.stl"/>'
        '<material name="m" texture="t"><layer texture="t"/></material></asset>'
        '<worldbody><geom type="hfield"/><geom hfield="h"/><geom size="1"><plugin/></geom></worldbody>'
        "<option/><actuator/><keyframe/></mujoco>"
    )
    strip_mjcf(root, FILE)
    assert [element.tag for element in root.iter()] == [
        "mujoco",
        "asset",
        "mesh",
        "material",
        "worldbody",
        "geom",
        "keyframe",
    ]
    assert root.find(".//material").attrib == {"name": "m"}


def edit(path: Path, old: str, new: str) -> Path:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    return path


def test_only_the_robot_is_loaded(tiny):
    robot = load_mjcf(tiny)
    assert [link.name for link in robot.links] == ["base", "rod"]
    for gone in ("floor", "motor", "jointpos", "keyframe", "light"):
        assert gone not in robot.mjcf
    assert robot.name == "tiny"


def test_degrees_become_radians_and_the_keyframe_is_home(tiny):
    robot = load_mjcf(tiny)
    joint = robot.joints[0]
    assert (joint.lower, joint.upper) == pytest.approx((-np.pi / 2, np.pi / 4), rel=1e-5)
    assert robot.home == pytest.approx([0.25])


FREE = ('pos="0 0 0.5">', 'pos="0 0 0.5"><freejoint/>')
LOOSE = '<body name="ball"><freejoint/><geom size="0.1"/></body><body name="hand" mocap="true"/></worldbody>'


@pytest.mark.parametrize(
    ("changes", "home", "kind", "where", "count"),
    [
        ([('qpos="0.25"', 'qpos="2.0"')], np.pi / 4, "home-outside-limits", "hinge", 1),
        ([('qpos="0.25"', 'qpos="inf"')], 0.0, "home-outside-limits", "hinge", 1),
        ([FREE, ('qpos="0.25"', 'qpos="0 0 1 1 0 0 0 0.25"')], 0.25, "free-base", "base", 1),
        ([("</worldbody>", LOOSE)], 0.0, "scene-objects", "ball, hand", 2),
        ([('<geom type="box"', '<geom material="steel" type="box"')], 0.25, "material", "steel", 1),
    ],
)
def test_repaired_model_contains_only_the_robot_with_a_finding(tiny, changes, home, kind, where, count):
    for old, new in changes:
        edit(tiny, old, new)
    robot = load_mjcf(tiny)
    assert ([link.name for link in robot.links], len(robot.joints)) == (["base", "rod"], 1)
    assert robot.home == pytest.approx([home], rel=1e-5)
    (finding,) = [finding for finding in robot.findings if finding.kind == kind]
    assert (finding.where, finding.count) == (where, count)


PASSWD = ("../../../../../../etc/passwd", "/etc/passwd")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ([("<worldbody>", '<include file="tiny.xml"/><worldbody>')], "files are included"),
        (
            [
                ('<joint name="hinge"', '<joint name="b" type="ball"/><joint name="hinge"'),
                ('qpos="0.25"', 'qpos="1 0 0 0 0"'),
            ],
            "joint b: a ball joint must be the last of its body",
        ),
        *(([('file="rod.stl"', f'file="{path}"')], f"leaves the robot.*{path}") for path in PASSWD),
        *(([("<worldbody>", f'<include file="{path}"/><worldbody>')], f"leaves the robot.*{path}") for path in PASSWD),
        ([('<mujoco model="tiny">', "<svg>"), ("</mujoco>", "</svg>")], "not MJCF"),
        ([("<body", "<frame"), ("</body>", "</frame>")], "contains no robot"),
        (
            [("<joint", '<geom type="box" size="1 1"/><joint')],
            r"body .*, geom .*, size: a box needs 3 positive sizes \(found: 1 1 0\)\. Write half its lengths",
        ),
    ],
)
def test_invalid_model_is_rejected(tiny, changes, words):
    for old, new in changes:
        edit(tiny, old, new)
    with pytest.raises(RobotError, match=words):
        load_mjcf(tiny)


def test_home_without_keyframe_is_zero_or_the_middle_of_limits_without_zero(tiny):
    text = tiny.read_text()
    start = text.index("<keyframe>")
    end = text.index("</mujoco>")
    tiny.write_text(text[:start] + text[end:])
    assert load_mjcf(tiny).home == pytest.approx([0.0])
    edit(tiny, 'range="-90 45"', 'range="20 40"')
    assert load_mjcf(tiny).home == pytest.approx([np.radians(30)], rel=1e-5)


HAND = """<mujoco model="hand"><worldbody>
  <geom name="floor" type="plane" size="0 0 1"/>
  <body name="crate" pos="1 0 .2"><geom type="box" size=".1 .1 .1"/></body>
  <body name="cup" pos="0 1 .2"><freejoint/><geom name="cup" size=".1"/><site name="rim"/></body>
  <body name="torso" pos="0 0 .5" {torso}>{free}<geom type="box" size=".1 .1 .1"/>
    <body name="arm" pos="0 0 .15">{joint}<geom type="capsule" size=".04 .1" pos="0 0 .15"/>
      <site name="pad" pos=".04 0 .15" size=".01"/></body></body>
  </worldbody><sensor>{sensors}</sensor></mujoco>"""
LIFT = '<joint name="lift" axis="0 1 0" range="-60 60" limited="true"/>'
TOUCH = '<touch name="arm_pad" site="pad"/>'


def hand(folder: Path, *, torso: str = "", free: str = "", joint: str = LIFT, sensors: str = TOUCH) -> Robot:
    path = folder / "hand.xml"
    path.write_text(HAND.format(torso=torso, free=free, joint=joint, sensors=sensors))
    return load_mjcf(path)


@pytest.mark.sampled(4)
@pytest.mark.parametrize("root", [{"torso": 'mocap="true"'}, {"free": "<freejoint/>"}])
@pytest.mark.parametrize(
    "carried", [{}, {"joint": ""}, {"joint": "", "sensors": '<accelerometer site="pad"/>'}, {"sensors": ""}]
)
def test_mocap_or_free_body_with_joints_or_sensors_is_the_robot(tmp_path, root, carried):
    robot = hand(tmp_path, **root, **carried)
    assert [link.name for link in robot.links] == ["torso", "arm"]
    findings = {finding.kind: finding for finding in robot.findings}
    assert findings["scene-objects"].where == "crate, cup"
    assert findings["free-base"].where == "torso"


@pytest.mark.parametrize(
    "sensor",
    [
        '<touch name="cup" site="rim"/>',
        '<tactile name="cup" geom="cup" mesh="none"/>',
        '<plugin name="g" plugin="mujoco.sensor.touch_grid" objtype="site" objname="rim"/>',
    ],
)
def test_free_body_with_a_touch_sensor_is_part_of_the_robot(tmp_path, sensor):
    robot = hand(tmp_path, sensors=sensor)
    assert [link.name for link in robot.links] == ["crate", "cup", "torso", "arm"]


def test_fixed_bodies_belong_to_a_fixed_robot_and_tracked_objects_do_not(tmp_path):
    tracked = '<framepos objtype="body" objname="cup"/><framepos objtype="site" objname="rim"/>'
    robot = hand(tmp_path, sensors=tracked)
    assert [link.name for link in robot.links] == ["crate", "torso", "arm"]


def test_ball_joint_is_replaced_by_three_hinges_of_the_same_motion(tiny):
    ball = '<joint name="b" type="ball" pos="0 0 0.1" range="0 60" limited="true" damping="0.5"/>'
    edit(tiny, '<joint name="hinge" axis="0 1 0" range="-90 45" damping="0.1"/>', ball)
    edit(tiny, '<motor joint="hinge"/>', "")
    edit(tiny, '<jointpos joint="hinge"/>', "")
    edit(tiny, 'qpos="0.25"', 'qpos="1 0 0 0"')
    robot = load_mjcf(tiny)
    assert [joint.name for joint in robot.joints] == ["b_x", "b_y", "b_z"]
    assert [joint.upper for joint in robot.joints] == pytest.approx([np.pi / 3] * 3, rel=1e-5)
    configuration = Configuration(robot)
    angles = np.array([0.3, -0.5, 0.7])
    configuration.update(angles)
    assert configuration.pose("rod").rotation == pytest.approx(Rotation.from_euler("XYZ", angles).as_matrix())
    assert configuration.pose("rod").points(np.array([0, 0, 0.1])) == pytest.approx([0, 0, 0.9]), "about its own place"


def test_deprecated_features_are_reported_and_the_robot_loads(tiny):
    robot = load_mjcf(edit(tiny, 'angle="degree"', 'angle="degree" settotalmass="3"'))
    reported = [finding.action for finding in robot.findings if finding.kind == "deprecated"]
    assert len(reported) == (mujoco.mj_version() >= 3_017_000), "older versions do not report it"
    assert all("settotalmass" in action for action in reported)
    assert 'mass="1.5"' in robot.mjcf, "two equal masses of 3 kg together"


def test_data_of_other_programs_are_removed(tiny):
    edit(tiny, '<joint name="hinge"', '<joint name="hinge" user="1 2 3"')
    assert "user" not in load_mjcf(edit(tiny, "<worldbody>", '<size nuser_jnt="3"/><worldbody>')).mjcf


def test_include_may_be_relative_to_the_including_file(tiny):
    folder = tiny.parent / "parts"
    folder.mkdir()
    (folder / "a.xml").write_text('<mujocoinclude><include file="b.xml"/></mujocoinclude>')
    (folder / "b.xml").write_text('<mujocoinclude><body name="extra"><geom size="0.1"/></body></mujocoinclude>')
    robot = load_mjcf(edit(tiny, "</worldbody>", '<include file="parts/a.xml"/></worldbody>'))
    assert "extra" in [link.name for link in robot.links]


def test_package_root_allows_meshes_outside_the_folder(tiny, tmp_path, rod):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "rod.stl").write_bytes(rod)
    edit(tiny, 'file="rod.stl"', 'file="../../shared/rod.stl"')
    with pytest.raises(RobotError, match="leaves the robot"):
        load_mjcf(tiny)
    assert load_mjcf(tiny, package_roots=[tmp_path / "shared"]).links[1].mesh is not None


def test_places_of_missing_meshes_of_links_with_other_shapes_are_known(tmp_path):
    """The places are those of the geoms, which frames around them move and turn, in the model's unit of angles."""
    model = tmp_path / "lost.xml"
    model.write_text("""<mujoco><compiler angle="radian"/>
      <asset><mesh name="shell" file="shell.stl"/></asset><worldbody>
      <body name="arm" pos="0 0 1"><joint axis="0 1 0"/><geom size=".01"/><geom type="mesh" mesh="shell" pos=".5 0 0"/>
        <frame pos="0 0 .1" euler="0 0 1.5707963268"><frame pos=".2 0 0">
          <geom type="mesh" mesh="shell" pos=".03 0 0" euler="0 0 .7853981634"/></frame></frame>
        <body name="hand" pos="0 0 1"><joint axis="0 1 0"/><geom size=".01"/></body></body></worldbody></mujoco>""")
    robot = load_mjcf(model)
    first, second = robot.link("arm").left_out
    assert np.ptp(first.vertices, axis=0) == pytest.approx([0.02] * 3)
    assert first.vertices.mean(axis=0) == pytest.approx([0.5, 0, 0])
    assert second.vertices.mean(axis=0) == pytest.approx([0, 0.23, 0.1], abs=1e-9)
    assert np.ptp(second.vertices, axis=0) == pytest.approx([0.02 * 2**0.5, 0.02 * 2**0.5, 0.02])
    assert robot.link("hand").left_out == ()


def test_meshes_of_the_same_name_in_two_folders_are_both_kept(tiny, rod):
    (tiny.parent / "meshes" / "other").mkdir()
    (tiny.parent / "meshes" / "other" / "rod.stl").write_bytes(rod)
    edit(tiny, "</asset>", '<mesh name="second" file="other/rod.stl"/></asset>')
    edit(tiny, '<geom type="box"', '<geom type="mesh" mesh="second" mass="1"/><geom type="box"')
    assert sorted(load_mjcf(tiny).assets) == ["rod.msh", "rod_2.msh"]


MANY = """<mujoco><worldbody><geom name="ground" size="1"/><frame><geom size="1"/><site/></frame>
  <light/><camera name="c"/>
  <body name="hand" mocap="true"><site name="a"/><site name="b"/><frame><site name="c"/><site/></frame><light/>
    <geom size="0.1"/></body>
  <body name="box" pos="1 0 0"><freejoint/><geom size="0.1"/><site name="loose"/></body>
  </worldbody>
  <equality><connect site1="a" site2="b"/></equality>
  <sensor><touch site="a"/><touch site="b"/><touch site="c"/></sensor>
  <keyframe><key name="first"/><key/><key name="home"/></keyframe></mujoco>"""


def test_unneeded_elements_are_removed_before_mujoco_reads_them(tmp_path, monkeypatch):
    path = tmp_path / "many.xml"
    path.write_text(MANY)
    read: list[str] = []

    def parse(text: str, *given: Any, **options: Any) -> mujoco.MjSpec:
        read.append(text)
        return parse_spec(text, *given, **options)

    monkeypatch.setattr(mjcf, "parse_spec", parse)
    robot = load_mjcf(path)
    assert [link.name for link in robot.links] == ["hand"], "a site with a sensor marks a link of the robot"
    counts = {tag: read[0].count(f"<{tag} ") for tag in ("site", "geom", "key")}
    assert counts == {"site": 2, "geom": 2, "key": 2}, "one site for each element that carries sensors"
    assert "<light" not in read[0]
    assert "<camera" not in read[0]


def test_each_mesh_of_one_file_counts_for_the_limit(tiny, monkeypatch):
    monkeypatch.setattr(mesh_files, "MAX_REPEATED_FACES", 0)
    text = tiny.read_text()
    again = '<mesh name="again{}" file="rod.stl"/>'
    tiny.write_text(text.replace("</asset>", again.format(1) + "</asset>"))
    load_mjcf(tiny)
    tiny.write_text(text.replace("</asset>", again.format(1) + again.format(2) + "</asset>"))
    with pytest.raises(RobotError, match=r"rod\.stl: mesh files are used under too many names"):
        load_mjcf(tiny)
