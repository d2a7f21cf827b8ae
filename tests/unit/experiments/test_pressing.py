"""A pressed robot at one time step: it converges, what it shows is what happened, and a stop has a reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.experiments.pressed_arm import PRESS, pressed, pressed_arm
from app.experiments.pressing import FINE, HOLDING, LOOK_MS, SETTLING, Run, at_step, press
from app.touch.layer import Layer
from tests.touch import bar, bar_skin

ARM, SOFT = pressed_arm(120), Layer(stiffness=1e4)


@pytest.fixture(scope="module")
def fine():
    return press(ARM, FINE, SOFT)


def made(forces=(1.0,), postures=((0.0,),), stopped=""):
    return Run(np.array(postures), np.array(forces), np.array([8e-3, 1.0, 8e-3]), stopped)


def test_the_truth_is_the_truth(fine):
    """A fine step has converged: another integrator and twice the step give the same posture and force."""
    for integrator in ("discrete", "implicitfast"):
        other = press(ARM, at_step(integrator, 0.1), SOFT)
        assert other.forces.mean() == pytest.approx(fine.forces.mean(), rel=1e-6)
        assert np.abs(other.postures - fine.postures).max() < 2e-5
    assert np.ptp(fine.postures, axis=0).max() > 1e-3, "it gave way"
    assert fine.forces.mean() == pytest.approx(PRESS, rel=0.05)


def test_it_looks_often_then_at_every_step(fine):
    looks, steps = round(1e3 * SETTLING / LOOK_MS), round(HOLDING / FINE.timestep)
    assert fine.postures.shape == (looks, len(ARM.robot.joints))
    assert fine.seconds.shape == (looks,)
    assert fine.forces.shape == (steps,)
    assert fine.steady(fine)
    assert fine.posture_off(fine) == 0


def test_a_run_that_stops_keeps_what_it_saw(fine):
    run = press(ARM, at_step("euler", 8.0), SOFT)
    assert "time step" in run.stopped
    assert 0 < len(run.postures) < len(fine.postures)
    assert not run.steady(fine)


def test_errors_are_of_the_true_force():
    true = made(forces=(2.0, 2.0))
    run = made(forces=(1.0, 2.0), postures=((3.0,),))
    assert run.force_off(true) == pytest.approx((0.25, 0.25))
    assert run.posture_off(true) == pytest.approx(3.0)
    assert not run.steady(true)
    assert made(forces=(1.99, 2.01)).steady(true)
    assert made(forces=(0.0, 2.0, 2.0, 4.0)).lost == 0.25
    assert not made(forces=(2.0, 2.0), stopped="why").steady(true)


def test_the_time_is_a_median_for_a_simulated_second():
    assert made().ms == pytest.approx(1000.0)


def test_a_robot_without_joints_has_no_posture_to_be_off():
    still = pressed(bar(hinged=False), bar_skin())
    run = press(still, at_step("discrete", 1.0), SOFT)
    assert math.isnan(run.posture_off(run))
    assert run.steady(run)
    assert run.forces.mean() == pytest.approx(PRESS, rel=1e-3)
