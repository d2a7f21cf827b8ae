"""Joint impedance, and the wanted posture it holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controllers import ImpedanceController
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings, JointCommand
from tactile_maps.control.motion.joint_impedance import (
    HOME_SPEED,
    MAX_JOINT_SPEED,
    MAX_LEAD,
    MAX_SLIDE_SPEED,
    MIN_INERTIA,
    STOP_FREQUENCY,
    JointImpedance,
    PostureReference,
    YieldingImpedance,
    at_limit,
    joint_impedance,
    joint_limits,
    joint_speeds,
    limit_joint_speed,
    within_effort,
)
from tactile_maps.control.motion.limits import ActiveLimits, LimitKind
from tactile_maps.control.motion.observation import Observation
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Joint, Robot
from tests.support.limits import kinds
from tests.support.touch import arm, bar


def test_stiffness_and_damping_are_those_of_a_second_order_joint():
    command = joint_impedance(np.array([2.0, 0.5]), np.zeros(2), frequency=3.0, damping_ratio=0.7)
    assert command.stiffness == pytest.approx([18.0, 4.5])
    assert command.damping == pytest.approx(2 * 0.7 * np.sqrt(command.stiffness * [2.0, 0.5]))
    assert not command.torque.any()


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_stopped_arm_brakes_only_joints_faster_than_allowed_and_without_a_jump(direction):
    robot = bar()
    configuration = Configuration(robot)
    yielding = YieldingImpedance(configuration, np.array([0.6]))
    inertia = configuration.inertia()[0]
    home = robot.home
    slow, just, fast = (
        direction * yielding.about(home, np.array([direction * v])).torque_at(home, direction * v)[0]
        for v in (0.6, 0.6001, 1.6)
    )
    assert slow == pytest.approx(-2 * STOP_FREQUENCY * inertia * 0.6)
    assert just == pytest.approx(slow, rel=1e-3)
    assert fast == pytest.approx(-2 * STOP_FREQUENCY * inertia * 1.6 - 40.0 * inertia * 1.0)


def test_a_weightless_joint_still_holds():
    command = joint_impedance(np.zeros(1), np.zeros(1), frequency=10.0, damping_ratio=1.0)
    assert command.stiffness[0] == pytest.approx(100 * MIN_INERTIA)


@pytest.mark.parametrize("seed", range(5))
def test_every_joint_has_the_requested_frequency_and_damping_ratio_at_any_posture(seed):
    robot = arm().robot
    lower, upper = joint_limits(robot)
    configuration = Configuration(robot)
    impedance = JointImpedance(configuration, frequency=40.0, damping_ratio=1.0)
    configuration.update(lower + (upper - lower) * np.random.default_rng(seed).random(7))
    command = impedance.about(robot.home)
    inertia = configuration.inertia()
    assert np.sqrt(command.stiffness / inertia) == pytest.approx(np.full(7, 40.0))
    damping = command.damping + configuration.joint_damping
    assert damping == pytest.approx(80.0 * inertia), "less the damping that the joints have"
    assert impedance.damping == pytest.approx(damping)
    assert impedance.deviation() is None


def test_a_joint_whose_own_damping_exceeds_the_requested_is_named():
    robot = arm().robot
    configuration = Configuration(robot)
    own = configuration.joint_damping
    inertia = configuration.inertia()
    frequency = float((own / (2 * inertia)).max()) / 2  # the joint with most damping then has a ratio of 2
    limit = JointImpedance(configuration, frequency=frequency, damping_ratio=1.0).deviation()
    assert limit is not None
    assert limit.names == (robot.joints[int((own / inertia).argmax())].name,)
    assert limit.value == pytest.approx(frequency)
    assert limit.damping_ratio == pytest.approx(2.0)
    within = JointImpedance(configuration, frequency=2 * frequency / 1.25, damping_ratio=1.0)
    assert within.deviation() is None, "by less than 30 %"


def test_a_controller_names_the_joint_whose_response_differs():
    robot = arm().robot
    soft = ControlSettings(stiffness=0.5)
    controller = ImpedanceController(robot)
    controller.command(soft, Observation(robot.home, np.zeros(7), (), DT))
    assert kinds(controller.why_limited) == [LimitKind.JOINT_RESPONSE]
    controller.reset()
    assert controller.why_limited == ()


def test_limits_in_posture_order():
    lower, upper = joint_limits(arm().robot)
    assert lower.shape == upper.shape == (7,)
    assert (lower < upper).all()
    assert [side.shape for side in joint_limits(bar(hinged=False))] == [(0,), (0,)]


DT = 0.005
STILL = np.zeros(1)


def reference() -> PostureReference:
    return PostureReference(bar(), Configuration(bar()))


def test_it_starts_from_the_posture_found_and_integrates():
    mine = reference()
    limits = ActiveLimits()
    command = mine.move(np.array([0.2]), np.array([0.1]), DT, limits)
    assert command.posture == pytest.approx([0.2 + 0.1 * DT])
    assert mine.move(np.array([0.2]), np.array([0.1]), DT, limits).posture == pytest.approx([0.2 + 0.2 * DT])
    assert kinds(limits) == []
    mine.reset()
    assert mine.start_posture(STILL) == STILL


def test_it_can_start_with_a_torque():
    mine = reference()
    mine.start(np.array([0.2]), np.array([1.5]))
    assert mine.command_at(mine.desired).torque_at(np.array([0.2]), STILL) == pytest.approx([1.5])
    mine.start(np.array([0.2]), np.array([1e6]))
    assert mine.desired == pytest.approx([0.2 + MAX_LEAD])


def test_it_runs_neither_ahead_nor_over_a_limit_and_says_so():
    mine = reference()
    limits = ActiveLimits()
    mine.move(STILL, np.array([1e3]), DT, limits)
    assert (mine.desired, kinds(limits)) == ([MAX_LEAD], [LimitKind.HELD_BACK])
    limits = ActiveLimits()
    mine.start(np.array([1.49]), STILL)
    mine.move(np.array([1.49]), np.array([10.0]), DT, limits)
    assert (mine.desired, kinds(limits)) == ([1.5], [LimitKind.JOINT_LIMIT])
    assert limits.found[0].names == (bar().joints[0].name,)


def test_home_is_neared_gently():
    mine = reference()
    at = np.array([1.0])
    speeds = []
    for _ in range(2000):
        speeds.append(float(mine.home_speed(at, STILL, DT)[0]))
        at = at + speeds[-1] * DT
    assert at == pytest.approx([0.0], abs=1e-4)
    assert max(map(abs, speeds)) <= HOME_SPEED
    assert np.abs(np.diff(speeds)).max() / DT < HOME_SPEED / 0.15
    mine.stop_homing()
    assert abs(mine.home_speed(np.array([1.0]), STILL, DT)[0]) < 0.1 * HOME_SPEED, "it starts anew"


def test_joints_at_a_limit_and_too_fast_ones():
    mine = reference()
    assert at_limit(mine, np.array([1.5]), np.array([0.1])).all()
    assert not at_limit(mine, np.array([1.5]), np.array([-0.1])).any()
    limits = ActiveLimits()
    most = np.array([MAX_JOINT_SPEED, MAX_JOINT_SPEED])
    assert limit_joint_speed(np.array([0.5, -3.0]), most, limits) == pytest.approx([0.25, -MAX_JOINT_SPEED])
    assert kinds(limits) == [LimitKind.JOINT_SPEED]
    assert limit_joint_speed(np.array([0.5, 0.5]), np.array([1.5, 0.25]), limits) == pytest.approx([0.25, 0.25])
    assert limit_joint_speed(np.zeros(0), np.zeros(0), limits).shape == (0,)


def limited(**joint) -> Robot:
    """The bar with what its model states for the hinge."""
    robot = bar()
    return replace(robot, joints=(replace(robot.joints[0], **joint),))


def reference_of(robot: Robot) -> PostureReference:
    return PostureReference(robot, Configuration(robot))


def test_hinges_slides_and_stated_limits_have_their_own_speeds():
    robot = replace(bar(), joints=(Joint("h", -1, 1), Joint("s", 0, 1, slide=True), Joint("l", 0, 1, True, 0.07)))
    assert joint_speeds(robot).tolist() == [MAX_JOINT_SPEED, MAX_SLIDE_SPEED, 0.07]
    assert joint_speeds(limited(max_speed=50000.0)).tolist() == [MAX_JOINT_SPEED]


def test_slow_joint_returns_to_rest_at_the_same_share_of_its_speed():
    mine = reference_of(limited(max_speed=0.3))
    at = np.array([1.0])
    speeds = []
    for _ in range(4000):
        speeds.append(float(mine.home_speed(at, STILL, DT)[0]))
        at = at + speeds[-1] * DT
    assert max(map(abs, speeds)) == pytest.approx(HOME_SPEED * 0.3 / MAX_JOINT_SPEED, rel=1e-3)


def test_posture_stays_where_the_torque_of_the_joint_ends():
    mine = reference_of(limited(max_effort=2.0))
    limits = ActiveLimits()
    for _ in range(50):
        command = mine.move(STILL, np.array([1.0]), DT, limits)
        assert command.torque_at(STILL, STILL)[0] <= 2.0 * (1 + 1e-9)
    assert command.torque_at(STILL, STILL) == pytest.approx([2.0])
    assert mine.desired == pytest.approx(2.0 / mine.impedance.stiffness)
    assert mine.torque_limited
    assert limit_texts(limits.found) == "torque limit: hinge"
    back = mine.move(STILL, np.array([-1.0]), DT, ActiveLimits())
    assert back.torque_at(STILL, STILL)[0] < 2.0, "it turns back at once"
    assert not mine.torque_limited


def test_damping_counts_as_torque():
    mine = reference_of(limited(max_effort=2.0))
    limits = ActiveLimits()
    fast = np.array([-1.0])
    command = mine.move(STILL, STILL, DT, limits, velocity=fast)
    assert command.torque_at(STILL, fast) == pytest.approx([2.0])
    assert kinds(limits) == [LimitKind.TORQUE_LIMIT]


@pytest.mark.parametrize(("stiffness", "torque"), [(10.0, 0.0), (0.0, 5.0), (10.0, 5.0)])
def test_torque_above_the_limit_is_reduced_to_it(stiffness, torque):
    command = JointCommand(np.array([0.4, 0.1]), np.full(2, stiffness), np.zeros(2), np.full(2, torque))
    efforts = np.array([1.0, np.inf])
    bounded, excess = within_effort(command, np.zeros(2), np.zeros(2), efforts)
    assert excess.tolist() == [True, False]
    assert bounded.torque_at(np.zeros(2), np.zeros(2)) == pytest.approx([1.0, 0.1 * stiffness + torque])
    same, none = within_effort(bounded, np.zeros(2), np.zeros(2), efforts)
    assert same is bounded
    assert not none.any()


def test_impedance_moves_a_joint_no_faster_than_its_model_allows():
    """The spring of the impedance controller would pull it with up to three times the speed."""
    robot = limited(max_speed=0.2)
    controller = ImpedanceController(robot)
    settings = ControlSettings()
    at = np.array([1.0])
    speed = np.zeros(1)
    step = 1e-3
    fastest = 0.0
    said = set()
    inertia = Configuration(robot).inertia()
    for _ in range(10_000):
        torque = controller.command(settings, Observation(at, speed, (), step)).torque_at(at, speed)
        said |= {limit.kind for limit in controller.why_limited}
        speed = speed + step * torque / inertia
        at = at + step * speed
        fastest = max(fastest, float(np.abs(speed)[0]))
    assert 0.15 < fastest <= 0.2 * (1 + 1e-6)
    assert said == {LimitKind.JOINT_SPEED}
    assert at == pytest.approx([0.0], abs=1e-3)
    assert not controller.why_limited
