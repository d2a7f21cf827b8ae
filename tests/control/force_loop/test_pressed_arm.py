"""The gain margin of a pressed arm against the closed forms of sampled loops, and against eigenvalues."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import SensorTiming
from tactile_maps.control.force_loop.pressed_arm import LoopFilter, PressedArm, pressed_arm
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import posture_loop
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    ForceLoop,
    stability_limit,
)
from tests.control.contacts import touch
from tests.support.generated_robots import leg, load
from tests.support.loop_trials import max_stable_gain


def slide(servo: float, stiffness: float) -> PressedArm:
    """A mass of 1 kg on one slide, held by a critically damped servo [rad/s]."""
    one = np.ones(1)
    return PressedArm(servo**2 * one, 2 * servo * one, one, servo**2 * one, stiffness)


def test_point_that_no_joint_moves_has_no_limit():
    rigid = PressedArm(np.ones(1), np.ones(1), np.zeros(1), np.zeros(1), 100.0)
    readings = SensorTiming(0.05)
    assert math.isinf(rigid.sampled_limit(readings))
    assert math.isinf(rigid.gain_limit(LoopFilter(), readings, 0.005))


@pytest.mark.parametrize("delay", range(4))
def test_ideal_joints_have_the_limit_of_a_sampled_loop(delay):
    """k_f k T < 2 sin(pi / (2 (2 d + 1)))."""
    readings = SensorTiming(0.25, 0.25 * delay)
    assert slide(2e3, 100.0).sampled_limit(readings) == pytest.approx(max_stable_gain(100.0, readings), rel=1e-3)
    found = slide(2e3, 100.0).gain_limit(LoopFilter(), readings, 0.0005)
    assert found == pytest.approx(max_stable_gain(100.0, readings), rel=0.03)


def test_servo_with_lag_is_stable_up_to_the_bound_of_routh():
    """s (s² + 2 w s + w² + k / m) + g k w² of a skin that is read all the time: g k < 2 w (1 + k / (m w²))."""
    found = slide(40.0, 4e3).gain_limit(LoopFilter(), SensorTiming(1e-4), 1e-4)
    assert found == pytest.approx(2 * 40.0 * (1 + 4e3 / 40.0**2) / 4e3, rel=0.01)


@pytest.mark.parametrize("averaged", [False, True])
@pytest.mark.parametrize("controller", [LoopFilter(0.3), LoopFilter(inertia_time=0.05), LoopFilter(0.6, 4.0, 0.05)])
def test_limit_agrees_with_the_eigenvalues_of_the_loop(controller, averaged):
    """Read at every tick, at its end or as the mean over it."""
    tick = 0.005
    servo = 40.0
    stiffness = 5e3
    one = np.ones(1)
    loop = ForceLoop.of_joints(tick, np.eye(1), servo**2 * one, 2 * servo * one, stiffness, one, one, averaged=averaged)
    filter_ = Filter(0.0, controller.integral_time, controller.position_gain, controller.inertia_time)
    found = slide(servo, stiffness).gain_limit(controller, SensorTiming(tick, averaged=averaged), tick)
    explained = stability_limit(lambda gain: loop.stable(replace(filter_, gain=gain)), found)
    assert found == pytest.approx(explained, rel=0.02)


def test_filter_follows_from_the_settings_of_the_controller():
    calm = ControlSettings(controller="qp")
    assert LoopFilter.of(calm) == LoopFilter(0.3)
    assert LoopFilter.of(replace(calm, controller="admittance")) == LoopFilter(math.inf, inertia_time=0.05)
    assert LoopFilter.of(replace(calm, controller="parallel")) == LoopFilter(0.3, 4.0, 0.05)


def test_servo_and_contact_are_in_series_at_rest():
    still = slide(40.0, 4800.0).response(np.array([1e-6j]))
    assert still == pytest.approx(1 / (1 + 4800 / 1600), abs=1e-6)


def test_friction_adds_the_stiffness_of_the_cover_in_all_directions(tmp_path):
    """The joints then rest at the least energy of their springs and the cover:  (K + k J' J) q = K push."""
    robot = load(leg(), tmp_path)
    configuration = Configuration(robot)
    configuration.update(np.array([-1.2, 0.8, 1.0]))
    impedance = posture_loop(configuration)
    pressed = replace(touch(3.0)[0], link="link3", link_position=np.array([0.03, 0.0, 0.15]))
    normal = configuration.pose("link3").rotation @ pressed.link_normal
    move = configuration.jacobian("link3", pressed.link_position)
    push = np.linalg.pinv((normal @ move)[None])[:, 0]
    for stiffness in (1e2, 1e4, 1e6):
        springs = np.diag(impedance.stiffness)
        rest = np.linalg.solve(springs + stiffness * move.T @ move, springs @ push)
        arm = pressed_arm(configuration, impedance, pressed, stiffness, slides=True)
        assert arm.sticking_stiffness == pytest.approx(stiffness * normal @ move @ rest)
