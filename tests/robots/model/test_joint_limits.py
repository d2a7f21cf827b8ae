"""Speed and effort limits of joints from URDF and MJCF files."""

from __future__ import annotations

import math

import pytest

from tactile_maps.robots.load import load_robot_file
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Robot
from tests.support.generated_robots import arm, load


def limits_of(robot: Robot) -> list[tuple[float, float]]:
    return [(joint.max_speed, joint.max_effort) for joint in robot.joints]


def test_urdf_states_speed_and_effort(urdf):
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('effort="1" velocity="1"', 'effort="12.5" velocity="0.07"'))
    assert limits_of(load_robot_file(path)) == [(0.07, 12.5)]


@pytest.mark.parametrize("text", ["0", "-1", "nan", "fast"])
def test_speed_that_is_not_positive_is_reported_and_not_used(text, urdf):
    path = urdf("rod.stl")
    path.write_text(path.read_text().replace('effort="1" velocity="1"', f'effort="1" velocity="{text}"'))
    robot = load_robot_file(path)
    assert limits_of(robot) == [(math.inf, 1.0)]
    (finding,) = [finding for finding in robot.findings if finding.kind == "velocity-limit"]
    assert finding.where == f"hinge: {text}"


NONE = (math.inf, math.inf)


@pytest.mark.parametrize(
    ("actuators", "limit"),
    [
        ('<motor joint="joint1" gear="50" ctrlrange="-2 2"/>', (math.inf, 100.0)),
        ('<motor joint="joint1" gear="-50" ctrlrange="-1 2"/>', (math.inf, 50.0)),
        ('<motor joint="joint1" gear="50" ctrlrange="-2 2" forcerange="-1 1"/>', (math.inf, 50.0)),
        ('<motor joint="joint1" ctrlrange="-2 2" ctrllimited="false"/>', NONE),
        ('<motor joint="joint1"/>', NONE),
        ('<general joint="joint1" gainprm="3" ctrlrange="0 4"/>', (math.inf, 12.0)),
        ('<position joint="joint1" kp="9" ctrlrange="-2 2"/>', NONE),
        ('<position joint="joint1" kp="9" ctrlrange="-2 2" forcerange="-7 7"/>', (math.inf, 7.0)),
        ('<velocity joint="joint1" kv="9" gear="2" ctrlrange="-3 3"/>', (1.5, math.inf)),
        ('<position joint="joint1" forcerange="-7 7"/><velocity joint="joint1" forcerange="-2 2"/>', (math.inf, 9.0)),
        ('<position joint="joint1" forcerange="-7 7"/><motor joint="joint1"/>', NONE),
        ('<motor joint="joint1" name="twice" ctrlrange="-1 1"/><motor joint="joint2" name="twice"/>', (math.inf, 1.0)),
        ('<position class="weak" joint="joint1"/>', (math.inf, 4.0)),
        ('<motor joint="elsewhere" ctrlrange="-1 1"/>', NONE),
        ('<motor site="tool" ctrlrange="-1 1"/>', NONE),
    ],
)
def test_actuators_limit_the_effort_and_speed_of_their_joint(actuators, limit, tmp_path):
    default = '<default><default class="weak"><position forcerange="-4 4"/></default></default>'
    robot = load(arm(1.0, extra=f"{default}<actuator>{actuators}</actuator>"), tmp_path)
    assert limits_of(robot) == [limit, *[NONE] * 5]
    model = compile_spec(robot_spec(robot), source="generated.xml")
    assert model.nu == 0
    assert bool(model.jnt_actfrclimited[0]) == math.isfinite(limit[1])


def test_joint_and_actuator_together_allow_the_smaller_effort(tmp_path):
    text = arm(1.0, extra='<actuator><motor joint="joint1" ctrlrange="-5 5"/></actuator>')
    for own, expected in (("-3 8", 3.0), ("-8 9", 5.0)):
        robot = load(text.replace('name="joint1"', f'name="joint1" actuatorfrcrange="{own}"'), tmp_path)
        assert robot.joints[0].max_effort == expected
        model = compile_spec(robot_spec(robot), source="generated.xml")
        assert model.jnt_actfrcrange[0].tolist() == [-expected, expected]


def test_actuators_that_mujoco_cannot_read_are_reported(tmp_path):
    robot = load(arm(1.0, extra='<actuator><motor joint="joint1" gear="fast"/></actuator>'), tmp_path)
    (finding,) = [finding for finding in robot.findings if finding.kind == "actuators"]
    assert "gear" in finding.action
    assert limits_of(robot) == [NONE] * 6
