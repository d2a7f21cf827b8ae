"""Cutting down: what is not the robot goes, what couples its joints stays, everything has a name."""

from __future__ import annotations

import mujoco

from app.robots.strip import home_of_keyframe, name_everything, strip_scene

GRIPPER = """<mujoco><worldbody><camera name="c"/><site name="w"/><body name="palm"><geom size="0.1"/><site name="s"/>
<body><joint name="a"/><geom size="0.1"/></body><body name="link_3"><joint name="b"/><geom size="0.1"/></body>
<body name="q" pos="1 0 0"><joint type="ball"/><geom size="0.1"/><body name="r"><joint name="d"/><geom size="0.1"/>
</body></body></body></worldbody>
<equality><joint joint1="a" joint2="b"/><connect site1="s" site2="w"/></equality>
<keyframe><key name="first" qpos="1 2 1 0 0 0 3"/><key name="home" qpos="4 5 1 0 0 0 6"/></keyframe></mujoco>"""


def test_home_is_read_past_joints_of_any_width() -> None:
    spec = mujoco.MjSpec.from_string(GRIPPER)
    assert {name: value for name, value in home_of_keyframe(spec).items() if name} == {"a": 4, "b": 5, "d": 6}
    assert home_of_keyframe(mujoco.MjSpec.from_string(GRIPPER.replace('name="home"', 'name="x"')))["a"] == 1
    assert home_of_keyframe(mujoco.MjSpec.from_string(GRIPPER.replace('"4 5 1 0 0 0 6"', '"4 5"'))) == {}
    assert home_of_keyframe(mujoco.MjSpec()) == {}


def test_couplings_of_joints_stay_and_those_of_sites_go() -> None:
    spec = mujoco.MjSpec.from_string(GRIPPER.replace('<joint type="ball"/>', ""))
    strip_scene(spec, "gripper")
    assert [equality.name1 for equality in spec.equalities] == ["a"]
    assert (list(spec.sites), list(spec.cameras), list(spec.keys)) == ([], [], [])


def test_names_are_given_without_taking_one_that_exists() -> None:
    spec = mujoco.MjSpec.from_string(GRIPPER.replace("<body><joint", "<body><joint/><joint"))
    findings = name_everything(spec)
    names = [body.name for body in spec.bodies]
    assert len(set(names)) == len(names)
    assert all(names)
    assert all(joint.name for joint in spec.joints)
    assert findings[0].kind == "unnamed"
    assert name_everything(spec) == []
