"""Readings at their end, oscillation, and what a step shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import (
    BAND,
    GONE,
    MEMORY,
    TURNS,
    OscillationDetector,
    assume_goal_where_saturated,
    step_response,
)
from tests.control.contacts import touch


def test_a_reading_at_its_end_is_no_less_than_the_goal():
    (weak,), (strong,) = touch(1.0), touch(2.0, id_=2)
    end = replace(weak, peak=180e3)
    taken, plateau = assume_goal_where_saturated((strong, end), 3.0, 180e3)
    assert plateau
    assert [(region.id, region.force) for region in taken] == [(1, 3.0), (2, 2.0)], "the strongest first"
    assert assume_goal_where_saturated((replace(end, force=5.0),), 3.0, 180e3)[0][0].force == 5.0
    assert assume_goal_where_saturated((strong, weak), 3.0, 180e3) == ((strong, weak), False)
    assert assume_goal_where_saturated((), 3.0, 180e3) == ((), False)


DT = 0.005
GOAL = 3.0


STIFFNESS = 2e4


def swung(amplitude, *, rate=5.0, seconds=3.0, goal=GOAL, way=lambda time, force: force / STIFFNESS):
    """Return whether a sine about the goal counts as an oscillation at the end."""
    watch = OscillationDetector()
    swings = False
    for k in range(round(seconds / DT)):
        force = max(goal + amplitude * np.sin(2 * np.pi * rate * k * DT), 0.0)
        swings = watch.look(goal, force, way(k * DT, force), DT)
    return swings


def test_large_swings_count_and_small_or_slow_ones_do_not():
    assert swung(2.0)
    assert swung(10.0), "down to nothing"
    assert not swung(1.0)
    assert not swung(2.0, rate=0.4, seconds=12.0)
    assert not swung(2.0, seconds=0.3)
    assert not swung(2.0, goal=0.0)


def test_only_force_that_follows_the_arm_is_an_oscillation_of_the_loop():
    assert swung(2.0, way=lambda time, force: 0.1 * time + force / STIFFNESS), "while the arm moves on"
    assert not swung(2.0, way=lambda time, force: -force / STIFFNESS), "it yields to what pushes"
    assert not swung(2.0, way=lambda time, force: 0.0), "it stands still"


def test_bounces_that_lose_the_contact_are_an_oscillation_of_the_loop():
    """The force is never far above the goal: 0 to 3 N."""

    def bounced(way_at, rate=2.0):
        watch = OscillationDetector()
        swings = False
        for k in range(round(3.0 / DT)):
            way = way_at * np.sin(2 * np.pi * rate * k * DT)
            swings = watch.look(GOAL, max(GOAL * np.sin(2 * np.pi * rate * k * DT), 0.0), way, DT)
        return swings

    assert bounced(1e-4)
    assert not bounced(-1e-4), "the arm yields to taps"
    assert not bounced(0.0)


def test_swings_whose_energy_the_arm_absorbs_are_taps():
    """Taps of 12 N push the arm in; it comes back while nothing touches, so that force and way still correlate."""
    watch = OscillationDetector()
    named = False
    for k in range(round(3.0 / DT)):
        phase = (k * DT / 0.4) % 1.0
        force = 12 * np.sin(2 * np.pi * phase) if phase < 0.5 else 0.0
        way = 1e-3 * np.cos(2 * np.pi * phase - 0.9)
        named |= watch.look(GOAL, force, way, DT)
    assert np.cos(np.pi / 2 - 0.9) > 0.7, "in phase as far as the way alone tells"
    assert not named


def test_swings_faster_than_taps_count_in_any_phase():
    for way in (lambda time, force: 0.0, lambda time, force: -force / STIFFNESS):
        assert swung(2.5, rate=10.0, way=way)
        assert not swung(2.5, rate=6.0, way=way)


def test_calm_is_noticed_too():
    watch = OscillationDetector()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), np.sin(30 * k * DT), DT)
    assert watch.look(GOAL, GOAL, 0.0, DT)
    calm = [watch.look(GOAL, GOAL, 0.0, DT) for _ in range(round(MEMORY / DT))]
    assert not calm[-1]


@pytest.mark.parametrize("pause", [GONE + 0.1, 1.0])
def test_taps_are_no_swings(pause):
    watch = OscillationDetector()
    for _ in range(2 * TURNS):
        for force, seconds in ((6.0, 0.1), (0.0, pause)):
            assert not any(watch.look(GOAL, force, 0.0, DT) for _ in range(round(seconds / DT)))


def test_a_reset_forgets():
    watch = OscillationDetector()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), np.sin(30 * k * DT), DT)
    watch.reset()
    assert not watch.look(GOAL, GOAL, 0.0, DT)


TIME = np.linspace(0.0, 4.0, 4001)


def second_order(ratio, *, omega=10.0):
    """Response of a unit step."""
    damped = omega * np.sqrt(1 - ratio**2)
    lag = ratio / np.sqrt(1 - ratio**2)
    return 1 - np.exp(-ratio * omega * TIME) * (np.cos(damped * TIME) + lag * np.sin(damped * TIME))


@pytest.mark.parametrize("ratio", [0.2, 0.4, 0.6])
@pytest.mark.parametrize(("before", "goal"), [(0.0, 1.0), (2.0, 6.0), (5.0, 1.0)])
def test_overshoot_is_the_textbook_s_up_and_down(ratio, before, goal):
    values = before + (goal - before) * second_order(ratio)
    found = step_response(TIME, values, before=before, goal=goal)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)), rel=1e-3)
    assert (found.before, found.goal) == (before, goal)


def test_a_first_order_lag_settles_after_three_time_constants_without_overshoot():
    found = step_response(TIME, 3 * (1 - np.exp(-TIME / 0.2)), before=0.0, goal=3.0)
    assert found.overshoot == 0
    assert found.settling == pytest.approx(-0.2 * np.log(BAND), abs=2e-3)
    assert found.ripple < 0.05


def test_ripple_is_what_stays():
    ripple = np.random.default_rng(0).normal(0, 0.01, len(TIME))
    found = step_response(TIME, np.where(TIME < 0.5, 0.0, 1.0) + ripple * (TIME >= 0.5), before=0.0, goal=1.0)
    assert found.settling == pytest.approx(0.5, abs=1e-3)
    assert found.ripple == pytest.approx(0.01, rel=0.05)


def test_what_has_not_settled_has_no_settling_time():
    for values in (0.5 * np.ones(4001), np.where(TIME > 3.998, 0.5, 1.0)):
        found = step_response(TIME, values, before=0.0, goal=1.0)
        assert found.settling is None
        assert found.ripple is None


def test_a_step_just_made_has_nothing_to_show_yet():
    found = step_response(np.zeros(0), np.zeros(0), before=0.0, goal=1.0)
    assert found.overshoot == 0
    assert found.settling is None
