"""The controllers against the theory of sampled loops (theory page, 5.5): stability, settling, ripple, Routh, lag.

A plate of skin of 4 kg on three slides is pressed on a fixed ball without friction. Its joints are ideal,
or simulated under the posture loop of 40 rad/s of all controllers, or under one ten times as fast. Where the simulator
departs from the theory of ideal joints, the docstring says why, and the theory with that loop in it must agree.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.studies.loop_laws.closed_loop import Loop
from tactile_maps.studies.loop_laws.predictions import (
    FAST_SERVO,
    IDEAL_JOINTS,
    OUR_SERVO,
    PERIOD,
)
from tactile_maps.studies.loop_laws.sampled_loop import (
    LinearLoop,
)
from tactile_maps.studies.loop_laws.step_trials import (
    LoopTest,
    force_ripple,
)
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    stability_limit,
)
from tests.support.loop_trials import INTEGRAL_CONTROLLERS, QUANTITIES, place_stable, tracking_lag

DELAYS = range(5)


def three(figure, plant, *, delay=0, **said):
    """(measured, theory of ideal joints, theory with the posture loop)."""
    return QUANTITIES[figure](
        {"controller": "hybrid", "what": "force", "delay": delay, "x": 0.0, "seed": 0, "plant": plant, **said}
    )


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize("controller", INTEGRAL_CONTROLLERS)
def test_stiffness_of_onset_is_as_predicted(controller, delay):
    """A force gain is too much from the stiffness L / (k T) on."""
    found, theory, _ = three("onset", IDEAL_JOINTS, controller=controller, delay=delay)
    assert found == pytest.approx(theory, rel=0.03)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("delay", DELAYS)
def test_position_loop_has_the_predicted_limit(delay):
    """L < 2 sin(π / (2 (2 d + 1)))."""
    found, theory, _ = three("stability", IDEAL_JOINTS, what="place", delay=delay)
    assert found == pytest.approx(theory, rel=0.03)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("turn", [0.0, 45.0, 60.0, 75.0])
def test_rotated_map_lowers_the_limit_by_the_cosine(turn):
    """L < 2 cos turn; nothing works at 90 degrees."""
    expected = 2 * np.cos(np.radians(turn)) / PERIOD
    found = stability_limit(partial(place_stable, LoopTest(Loop(period=PERIOD, turn=turn))), expected, steps=5)
    assert found == pytest.approx(expected, rel=0.05)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize("what", ["force", "place"])
def test_settling_time_follows_from_the_delay(what, delay):
    """1, 9, 16, 23, 29 samples to 2 % without overshoot: about 6.4 (d + 1/2) T."""
    found, theory, _ = three("settling", IDEAL_JOINTS, what=what, delay=delay)
    assert found / PERIOD == [1, 9, 16, 23, 29][delay] == theory / PERIOD
    if delay:
        assert found == pytest.approx(6.4 * (delay + 0.5) * PERIOD, rel=0.1)


@pytest.mark.long
def test_halving_the_ripple_takes_four_times_the_settling_time():
    """White noise on the reading: variance of the true force times settling time T ln 50 / -ln(1 - L) is constant.

    Nothing departs but by chance: runs are finite.
    """
    loop = Loop(period=0.02, noise=0.05, stiffness=1000.0)
    products = []
    for gain in (0.05, 0.1, 0.2):
        true, noise = force_ripple(LoopTest(loop), gain / (1000.0 * 0.02), round(600 / gain))
        assert noise == pytest.approx(0.05, rel=0.05)
        assert (true / noise) ** 2 == pytest.approx(gain / (2 - gain), rel=0.2)
        products.append((true / noise) ** 2 / -np.log1p(-gain))
    assert max(products) / min(products) < 1.3


@pytest.mark.long
@pytest.mark.parametrize("inertia", [0.2, 0.4])
@pytest.mark.parametrize("place", [1.0, 10.0])
def test_parallel_controller_is_stable_up_to_the_bound_of_routh(inertia, place):
    """k_I k_e < k_D (k_P + k_F k_e), as the shortest integral time that is stable.

    In the simulator the posture loop lags by 50 ms; at 400 rad/s what is left is that the simulated contact bears half
    of what accelerates the plate.
    """
    found, theory, _ = three("routh", IDEAL_JOINTS, controller="parallel", x=place, inertia=inertia)
    assert theory == pytest.approx(inertia * 10 / (10 + place))
    assert found == pytest.approx(theory, rel=0.06)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("delay", [0, 1, 2, 3])
def test_target_of_a_path_leads_by_its_speed_over_the_gain(delay):
    """e = v T / L without feed-forward: (1, 4, 6.75, 9.5) v T at the gain without overshoot.

    The goal is known without delay and the contact with delay, so the true contact is nearer by v d T, or ahead if the
    controller knows the speed. The goal moves between readings if ticks are shorter than the period.
    """
    bench = LoopTest(Loop(period=PERIOD, delay=delay))
    speed = 0.001
    seen, true = tracking_lag(bench, critical_gain(delay) / PERIOD, speed, feedforward=False, periods=60 + 30 * delay)
    assert seen == pytest.approx(speed * PERIOD * [1, 4, 6.75, 9.48][delay], rel=0.01)
    assert seen - true == pytest.approx(speed * PERIOD * delay, abs=1e-7)
    seen, true = tracking_lag(bench, critical_gain(delay) / PERIOD, speed, feedforward=True, periods=60 + 30 * delay)
    assert seen == pytest.approx(0.0, abs=1e-7)
    assert true == pytest.approx(-speed * PERIOD * delay, abs=1e-7)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("stretch", [1.0, 1.5, 2.0])
def test_feedforward_of_the_speed_leaves_only_the_error_of_the_map(stretch):
    """The projection controller takes the map for an isometry; along x it is stretched by the root."""
    gain = 2.0
    speed = 0.001
    bench = LoopTest(Loop(period=0.1, stretch=stretch), "projection")
    seen, _ = tracking_lag(bench, gain, speed, feedforward=True, periods=150)
    assert seen == pytest.approx(speed / gain * (1 - stretch**-0.5), abs=2e-6)


@pytest.mark.long
@pytest.mark.parametrize("delay", DELAYS)
def test_simulated_force_loop_has_the_predicted_limit(delay):
    found, theory, explained = three("stability", OUR_SERVO, delay=delay)
    assert found == pytest.approx(theory, rel=0.1)
    assert found == pytest.approx(explained, rel=0.04)


@pytest.mark.long
@pytest.mark.parametrize("delay", [0, 2])
def test_simulated_position_loop_differs_only_by_the_posture_loop(delay):
    """A posture loop of 40 rad/s has not settled at the next reading, which damps the alternating case (place, no
    delay); a loop of 400 rad/s has settled.
    """
    found, theory, explained = three("stability", OUR_SERVO, what="place", delay=delay)
    assert found == pytest.approx(explained, rel=0.04)
    assert (abs(found / theory - 1) > 0.2) == (delay == 0), "smoothed where it would alternate"
    found, theory, _ = three("stability", FAST_SERVO, what="place", delay=delay)
    assert found == pytest.approx(theory, rel=0.1)


@pytest.mark.long  # 20 s a case
@pytest.mark.parametrize("delay", [0, 2])
def test_simulated_stiffness_of_onset_differs_by_the_posture_loop(delay):
    """The posture loop gives way as a spring of 6.4 kN/m in series with the contact; at 400 rad/s it is one of 640
    kN/m."""
    found, theory, explained = three("onset", OUR_SERVO, delay=delay)
    assert found == pytest.approx(explained, rel=0.05)
    assert found > 1.2 * theory
    found, theory, _ = three("onset", FAST_SERVO, delay=delay)
    assert found == pytest.approx(theory, rel=0.1)


@pytest.mark.long
@pytest.mark.parametrize("delay", [0, 1, 2])
def test_simulated_settling_time_matches_the_theory_with_the_posture_loop(delay):
    """The posture loop's lag of 50 ms overshoots without delay and hides in a longer one; at 400 rad/s it is gone."""
    for plant in (OUR_SERVO, FAST_SERVO):
        found, theory, explained = three("settling", plant, what="place", delay=delay)
        assert found == pytest.approx(explained, abs=1.1 * PERIOD)
        if plant == FAST_SERVO:
            assert found == pytest.approx(theory, abs=1.1 * PERIOD)


@pytest.mark.long
def test_rotated_map_needs_more_time_than_a_stretched_one():
    """Settling times at the best gain and one sample of delay. The simulator adds the posture loop's lag of 50 ms; a
    controller with the map's Jacobian needs no extra time for stretch.
    """
    stretched, stretch_theory, _ = three("stretch", IDEAL_JOINTS, controller="projection", delay=1, x=2.0)
    turned, turn_theory, _ = three("turn", IDEAL_JOINTS, delay=1, x=30.0)
    assert (stretched, turned) == (stretch_theory, turn_theory) == (11, 20)
    aware, _, _ = three("stretch", IDEAL_JOINTS, controller="hybrid", delay=1, x=2.0)
    assert aware == 6, "what knows the map's Jacobian does not see its stretch"


def test_lag_of_the_joints_acts_as_a_delay_at_any_period_of_the_skin():
    """30 ms: 17 1/s at 50 ms and one sample of delay, where the joints without lag bear 20 (theory page, 5.5).

    A lag of 30 ms, or the posture loop's on a contact of 2 kN/m, is a delay that no faster skin shortens; without delay
    it also smooths what would alternate.
    """
    loop = Loop(period=0.05, delay=1, ticks=50, lag=0.03, stiffness=1.0)
    assert stability_limit(lambda gain: LinearLoop(loop, Filter(gain)).stable, 20.0) == pytest.approx(17.0, rel=0.03)
    fast = replace(loop, period=0.001)
    assert stability_limit(lambda gain: LinearLoop(fast, Filter(gain)).stable, 700.0) == pytest.approx(673.0, rel=0.02)
