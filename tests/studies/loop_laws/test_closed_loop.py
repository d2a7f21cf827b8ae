"""The closed loop on the gantry: ideal and simulated plants agree where they should."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.loop_laws.closed_loop import IDEAL, Loop, run_loop
from tactile_maps.studies.loop_laws.step_trials import proportional_settings

STEP = 0.1


def raised(loop, gain, *, rest=20, periods=20):
    """Forces [N] from when the goal rose by ``STEP``."""
    settings = [proportional_settings("hybrid", gain, force_goal=goal) for goal in (3.0, 3.0 + STEP)]
    return run_loop(loop, lambda tick: settings[tick >= rest * loop.ticks], rest + periods).force[rest:]


def test_ideal_joints_follow_the_recursion_after_a_step():
    """e[k + 1] = e[k] - L e[k - d]."""
    loop = Loop(period=0.1, stiffness=1000.0, delay=1)
    force = raised(loop, 0.25 / (1000.0 * 0.1))
    errors = [STEP, STEP]  # of the goal's step it hears at once
    for _ in range(19):
        errors.append(errors[-1] - 0.25 * errors[-2])
    assert 3.0 + STEP - force == pytest.approx(errors[1:], abs=1e-9)


@pytest.mark.long
def test_fast_posture_loop_gives_nearly_the_ideal_response():
    hard = 2e4
    servo = 4.0 * 400.0**2
    ideal = raised(Loop(period=0.25, stiffness=hard), 0.3 / (hard * 0.25))
    simulated = raised(Loop(period=0.25, stiffness=hard, servo=400.0, ticks=5), 0.3 * (1 / hard + 1 / servo) / 0.25)
    assert simulated == pytest.approx(ideal, abs=0.05 * STEP)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("servo", [IDEAL, 40.0])
def test_sliding_the_plate_moves_the_contact_in_the_opposite_direction_on_the_map(servo):
    loop = Loop(period=0.1, servo=servo, ticks=5, stretch=2.0)
    settings = ControlSettings(controller="hybrid", task="hold_point", path=((0.004, -0.002),), force_gain=1e-4)
    loop_run = run_loop(loop, lambda _: settings, 40)
    assert loop_run.place[-1] == pytest.approx([0.004, -0.002], abs=1e-4)
    assert loop_run.error[-1] == pytest.approx(0.0, abs=1e-4)
    assert loop_run.force[-1] == pytest.approx(3.0, abs=0.2)
    assert loop_run.read[-1] == pytest.approx(loop_run.force[-1], rel=1e-6)


@pytest.mark.long
def test_noise_affects_only_readings_and_is_reproducible():
    for servo, noise in ((IDEAL, 0.05), (40.0, 150.0)):
        loop = Loop(period=0.02, servo=servo, noise=noise)
        settings = proportional_settings("hybrid", 0.0)
        first, again = (run_loop(loop, lambda _, settings=settings: settings, 60) for _ in range(2))
        assert np.array_equal(first.read, again.read)
        assert np.std(first.read[30:] - first.force[30:]) > 0.01
        assert np.std(first.force[30:]) < 0.01
