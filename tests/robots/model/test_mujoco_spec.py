"""Back to MuJoCo: the text is whole, radians, and errors are one sentence."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.mujoco_spec import MESH_CACHE, compile_spec, robot_spec, spec_text


def test_robot_is_self_contained_and_in_radians(tiny):
    robot = load_robot_file(tiny)
    for file in tiny.parent.rglob("*.*"):
        file.unlink()
    spec = robot_spec(robot)
    assert not spec.compiler.degree
    model = compile_spec(spec, source=robot.source)
    assert model.jnt_range[0] == pytest.approx((robot.joints[0].lower, robot.joints[0].upper))
    assert model.nbody == len(robot.links) + 1


def test_each_spec_is_a_new_one(tiny):
    robot = load_robot_file(tiny)
    robot_spec(robot).worldbody.add_body(name="extra")
    assert robot_spec(robot).body("extra") is None


def test_errors_of_mujoco_are_one_line(tiny):
    robot = load_robot_file(tiny)
    with pytest.raises(RobotError, match="cannot read") as caught:
        robot_spec(replace(robot, mjcf="<mujoco><nonsense/></mujoco>"))
    assert "\n" not in str(caught.value)
    with pytest.raises(RobotError, match="cannot build"):
        compile_spec(robot_spec(replace(robot, assets={})), source=robot.source)


def test_written_text_is_in_radians(tiny):
    spec = robot_spec(load_robot_file(tiny))
    compile_spec(spec, source="tiny")
    assert 'angle="radian"' in spec_text(spec, source="tiny")


def test_meshes_of_closed_robots_fill_no_more_than_the_cache():
    assert mujoco.mj_getCacheCapacity(mujoco.mj_getCache()) == MESH_CACHE
