"""Joint impedance, and the desired posture that it holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controllers import ImpedanceController
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
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Joint, Robot
from tests.control.contacts import TICK, observed
from tests.support.limits import kinds
from tests.support.touch import arm, bar

STILL = np.zeros(1)


def test_stiffness_and_damping_match_a_second_order_joint():
    command = joint_impedance(np.array([2.0, 0.5, 0.0]), np.zeros(3), frequency=3.0, damping_ratio=0.7)
    assert command.stiffness == pytest.approx([18.0, 4.5, 9 * MIN_INERTIA]), "a weightless joint still holds"
    assert command.damping[:2] == pytest.approx(2 * 0.7 * np.sqrt(command.stiffness * [2.0, 0.5, 0.0])[:2])
    assert not command.torque.any()


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_stopped_arm_brakes_only_joints_faster_than_allowed_and_without_a_jump(direction):
    configuration = Configuration(bar())
    yielding = YieldingImpedance(configuration, np.array([0.6]))
    inertia = configuration.inertia()[0]
    home = bar().home
    slow, just, fast = (
        direction * yielding.about(home, np.array([direction * v])).torque_at(home, direction * v)[0]
        for v in (0.6, 0.6001, 1.6)
    )
    assert slow == pytest.approx(-2 * STOP_FREQUENCY * inertia * 0.6)
    assert just == pytest.approx(slow, rel=1e-3)
    assert fast == pytest.approx(-2 * STOP_FREQUENCY * inertia * 1.6 - 40.0 * inertia * 1.0)


@pytest.mark.parametrize("seed", range(5))
def test_every_joint_has_the_requested_frequency_and_damping_ratio_at_any_posture(seed):
    robot = arm().robot
    lower, upper = joint_limits(robot)
    assert [side.shape for side in joint_limits(bar(hinged=False))] == [(0,), (0,)]
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


def test_joint_with_more_own_damping_than_requested_is_reported():
    robot = arm().robot
    configuration = Configuration(robot)
    own = configuration.joint_damping
    inertia = configuration.inertia()
    frequency = float((own / (2 * inertia)).max()) / 2  # the joint with most damping then has a ratio of 2
    limit = JointImpedance(configuration, frequency=frequency, damping_ratio=1.0).deviation()
    assert limit.names == (robot.joints[int((own / inertia).argmax())].name,)
    assert (limit.value, limit.damping_ratio) == pytest.approx((frequency, 2.0))
    within = JointImpedance(configuration, frequency=2 * frequency / 1.25, damping_ratio=1.0)
    assert within.deviation() is None, "by less than 30 %"
    controller = ImpedanceController(robot)
    controller.command(ControlSettings(stiffness=0.5), observed(robot.home))
    assert kinds(controller.why_limited) == [LimitKind.JOINT_RESPONSE]


def test_joint_with_high_own_damping_follows_a_motion_with_the_requested_lag():
    """Joints with critical damping follow a steady motion 2 / frequency late; the rest is not changed."""
    inertia = np.array([2.0, 0.5])
    own = np.array([0.0, 400.0])  # five times the critical damping at 80 rad/s
    command = joint_impedance(inertia, np.zeros(2), frequency=80.0, damping_ratio=1.0, own_damping=own, same_lag=True)
    assert (command.damping + own) / command.stiffness == pytest.approx([1 / 40, 1 / 40])
    assert command.stiffness[0] == pytest.approx(80.0**2 * 2.0)
    assert command.damping == pytest.approx([320.0, 0.0])


class Reference(PostureReference):
    """The desired posture of the bar, whose model states limits of the hinge."""

    def __init__(self, **joint) -> None:
        self.robot = replace(bar(), joints=(replace(bar().joints[0], **joint),))
        super().__init__(self.robot, Configuration(self.robot))

    def step(self, posture=0.0, speed=0.0, *, velocity=0.0):
        """The command, with its torque and the limits stored."""
        limits = ActiveLimits()
        measured = np.array([posture])
        command = self.move(measured, np.array([speed]), TICK, limits, velocity=np.array([velocity]))
        self.torque = command.torque_at(measured, velocity)
        self.limits = limits.found
        return command


def test_desired_posture_starts_at_the_measured_one_and_integrates_the_speed():
    reference = Reference()
    postures = [float(reference.step(0.2, 0.1).posture[0]) for _ in range(2)]
    assert postures == pytest.approx([0.2 + 0.1 * TICK, 0.2 + 0.2 * TICK])
    assert reference.limits == ()
    reference.reset()
    assert reference.start_posture(STILL) == STILL


def test_desired_posture_can_start_with_a_torque():
    reference = Reference()
    posture = np.array([0.2])
    reference.start(posture, np.array([1.5]))
    assert reference.command_at(reference.desired).torque_at(posture, STILL) == pytest.approx([1.5])
    reference.start(posture, np.array([1e6]))
    assert reference.desired == pytest.approx([0.2 + MAX_LEAD])


def test_desired_posture_stays_near_a_blocked_arm_and_within_joint_limits():
    reference = Reference()
    reference.step(0.0, 1e3)
    assert (reference.desired, reference.limits) == ([MAX_LEAD], (Limit(LimitKind.HELD_BACK, ("hinge",)),))
    reference.start(np.array([1.49]), STILL)
    reference.step(1.49, 10.0)
    assert (reference.desired, reference.limits) == ([1.5], (Limit(LimitKind.JOINT_LIMIT, ("hinge",)),))


@pytest.mark.parametrize("max_speed", [np.inf, 0.3])
def test_return_to_rest_is_smooth_and_at_most_at_the_same_share_of_the_joint_speed(max_speed):
    reference = Reference(max_speed=max_speed)
    at = np.array([1.0])
    speeds = []
    for _ in range(4000):
        speeds.append(float(reference.home_speed(at, STILL, TICK)[0]))
        at = at + speeds[-1] * TICK
    assert at == pytest.approx([0.0], abs=1e-4)
    most = HOME_SPEED * min(max_speed, MAX_JOINT_SPEED) / MAX_JOINT_SPEED
    assert max(map(abs, speeds)) == pytest.approx(most, rel=0.02)
    assert max(map(abs, speeds)) <= most
    assert np.abs(np.diff(speeds)).max() / TICK < most / 0.15
    reference.stop_homing()
    assert abs(reference.home_speed(np.array([1.0]), STILL, TICK)[0]) < 0.1 * most, "it starts again"


def test_joint_speeds_are_limited_together():
    reference = Reference()
    assert at_limit(reference, np.array([1.5]), np.array([0.1])).all()
    assert not at_limit(reference, np.array([1.5]), np.array([-0.1])).any()
    for speed, most, expected in (
        ([0.5, -3.0], [MAX_JOINT_SPEED] * 2, [0.25, -MAX_JOINT_SPEED]),
        ([0.5, 0.5], [1.5, 0.25], [0.25, 0.25]),
    ):
        limits = ActiveLimits()
        assert limit_joint_speed(np.array(speed), np.array(most), limits) == pytest.approx(expected)
        assert kinds(limits) == [LimitKind.JOINT_SPEED]
    assert limit_joint_speed(np.zeros(0), np.zeros(0), limits).shape == (0,)


def test_hinges_slides_and_stated_limits_have_their_own_speeds():
    joints = (
        Joint("h", -1, 1),
        Joint("s", 0, 1, slide=True),
        Joint("l", 0, 1, True, 0.07),
        Joint("f", -1, 1, False, 5e4),
    )
    assert joint_speeds(replace(bar(), joints=joints)).tolist() == [
        MAX_JOINT_SPEED,
        MAX_SLIDE_SPEED,
        0.07,
        MAX_JOINT_SPEED,
    ]


def test_desired_posture_does_not_run_ahead_at_the_torque_limit():
    reference = Reference(max_effort=2.0)
    for _ in range(50):
        reference.step(0.0, 1.0)
        assert reference.torque[0] <= 2.0 * (1 + 1e-9)
    assert reference.torque == pytest.approx([2.0])
    assert reference.desired == pytest.approx(2.0 / reference.impedance.stiffness)
    assert reference.bounded
    assert reference.limits == (Limit(LimitKind.TORQUE_LIMIT, ("hinge",)),)
    reference.step(0.0, -1.0)
    assert reference.torque[0] < 2.0, "it turns back at once"
    assert not reference.bounded
    damped = Reference(max_effort=2.0)
    damped.step(velocity=-1.0)
    assert damped.torque == pytest.approx([2.0]), "damping counts"
    assert kinds(damped.limits) == [LimitKind.TORQUE_LIMIT]


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


@pytest.mark.long
def test_impedance_moves_a_joint_no_faster_than_its_model_allows():
    """The spring of the impedance controller would pull it with up to three times the speed."""
    robot: Robot = Reference(max_speed=0.2).robot
    controller = ImpedanceController(robot)
    at, speed = 1.0, 0.0
    fastest = 0.0
    found = set()
    inertia = Configuration(robot).inertia()[0]
    for _ in range(10_000):
        command = controller.command(ControlSettings(), observed([at], velocity=speed))
        found |= set(kinds(controller.why_limited))
        speed += 1e-3 * float(command.torque_at(np.array([at]), speed)[0]) / inertia
        at += 1e-3 * speed
        fastest = max(fastest, abs(speed))
    assert 0.15 < fastest <= 0.2 * (1 + 1e-6)
    assert found == {LimitKind.JOINT_SPEED}
    assert at == pytest.approx(0.0, abs=1e-3)
    assert not controller.why_limited
