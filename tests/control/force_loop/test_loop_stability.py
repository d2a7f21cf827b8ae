"""Saturated readings, oscillation, and step responses."""

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
from tests.control.contacts import TICK, touch

GOAL = 3.0
STIFFNESS = 2e4


def test_saturated_contact_has_at_least_the_goal_force():
    (weak,), (strong,) = touch(1.0), touch(2.0, id_=2)
    saturated = replace(weak, peak=180e3)
    regions, found = assume_goal_where_saturated((strong, saturated), GOAL, 180e3)
    assert found
    assert [(region.id, region.force) for region in regions] == [(1, 3.0), (2, 2.0)], "the strongest first"
    assert assume_goal_where_saturated((replace(saturated, force=5.0),), GOAL, 180e3)[0][0].force == 5.0
    for regions in ((strong, weak), ()):
        assert assume_goal_where_saturated(regions, GOAL, 180e3) == (regions, False)


def along(force):
    """The way of an arm that presses on a spring."""
    return force / STIFFNESS


class Swings:
    """Forces and ways, tick by tick, for an oscillation detector."""

    def __init__(self):
        self.detector = OscillationDetector()

    def run(self, force, way, seconds=3.0, *, goal=GOAL):
        """Whether each tick counts as an oscillation; ``force`` and ``way`` are functions of the time."""
        times = TICK * np.arange(round(seconds / TICK))
        return [self.detector.look(goal, force(time), way(time), TICK) for time in times]


def sine(amplitude, rate=5.0, goal=GOAL):
    return lambda time: max(goal + amplitude * np.sin(2 * np.pi * rate * time), 0.0)


@pytest.mark.sampled(6)
@pytest.mark.parametrize(
    ("amplitude", "how", "oscillates"),
    [
        (2.0, {}, True),
        (10.0, {}, True),  # down to zero
        (1.0, {}, False),
        (2.0, {"rate": 0.4, "seconds": 12.0}, False),
        (2.0, {"seconds": 0.3}, False),
        (2.0, {"goal": 0.0}, False),
        (2.0, {"way": lambda time, force: 0.1 * time + along(force)}, True),  # while the arm moves on
        (2.0, {"way": lambda time, force: -along(force)}, False),  # it yields
        (2.0, {"way": lambda time, force: 0.0}, False),
        *(
            (2.5, {"rate": rate, "way": lambda time, force, sign=sign: -sign * along(force)}, rate == 10.0)
            for rate in (6.0, 10.0)  # faster than taps
            for sign in (0, 1)
        ),
    ],
)
def test_only_large_fast_swings_that_follow_the_arm_are_an_oscillation(amplitude, how, oscillates):
    goal = how.get("goal", GOAL)
    force = sine(amplitude, how.get("rate", 5.0), goal)
    way = how.get("way", lambda time, force: along(force))
    found = Swings().run(force, lambda time: way(time, force(time)), how.get("seconds", 3.0), goal=goal)
    assert found[-1] == oscillates


@pytest.mark.parametrize(("way", "oscillates"), [(1e-4, True), (-1e-4, False), (0.0, False)])
def test_bounces_are_an_oscillation_unless_the_arm_yields(way, oscillates):
    """The force is never far above the goal: 0 to 3 N."""
    wave = sine(1.0, 2.0, 0.0)
    found = Swings().run(lambda time: GOAL * wave(time), lambda time: way * np.sin(4 * np.pi * time))
    assert found[-1] == oscillates


def test_swings_whose_energy_the_arm_absorbs_are_taps():
    """Taps of 12 N push the arm in; it returns while nothing touches, so that force and way still correlate."""

    def phase(time):
        return (time / 0.4) % 1.0

    def force(time):
        return 12 * np.sin(2 * np.pi * phase(time)) if phase(time) < 0.5 else 0.0

    assert np.cos(np.pi / 2 - 0.9) > 0.7, "in phase as far as the way alone shows"
    assert not any(Swings().run(force, lambda time: 1e-3 * np.cos(2 * np.pi * phase(time) - 0.9)))


@pytest.mark.parametrize("pause", [GONE + 0.1, 1.0])
def test_slow_taps_do_not_count(pause):
    found = Swings().run(
        lambda time: 6.0 if time % (0.1 + pause) < 0.1 else 0.0, lambda _: 0.0, 2 * TURNS * (0.1 + pause)
    )
    assert not any(found)


@pytest.mark.long
def test_oscillation_ends_with_calm_and_with_a_reset():
    for reset in (False, True):
        swings = Swings()
        swings.run(sine(2.0, 30 / (2 * np.pi)), lambda time: np.sin(30 * time))
        if reset:
            swings.detector.reset()
        calm = swings.run(lambda _: GOAL, lambda _: 0.0, MEMORY)
        assert (calm[0], calm[-1]) == (not reset, False)


TIME = np.linspace(0.0, 4.0, 4001)


def second_order(ratio, *, omega=10.0):
    """Response of a unit step."""
    damped = omega * np.sqrt(1 - ratio**2)
    lag = ratio / np.sqrt(1 - ratio**2)
    return 1 - np.exp(-ratio * omega * TIME) * (np.cos(damped * TIME) + lag * np.sin(damped * TIME))


@pytest.mark.parametrize("ratio", [0.2, 0.4, 0.6])
@pytest.mark.parametrize(("before", "goal"), [(0.0, 1.0), (2.0, 6.0), (5.0, 1.0)])
def test_overshoot_matches_the_textbook_for_steps_up_and_down(ratio, before, goal):
    found = step_response(TIME, before + (goal - before) * second_order(ratio), before=before, goal=goal)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)), rel=1e-3)
    assert (found.before, found.goal) == (before, goal)


def test_settling_time_and_ripple_of_a_response():
    lag = step_response(TIME, 3 * (1 - np.exp(-TIME / 0.2)), before=0.0, goal=3.0)
    assert lag.overshoot == 0
    assert lag.settling == pytest.approx(-0.2 * np.log(BAND), abs=2e-3)
    assert lag.ripple < 0.05
    noise = np.random.default_rng(0).normal(0, 0.01, len(TIME))
    step = step_response(TIME, (TIME >= 0.5) * (1.0 + noise), before=0.0, goal=1.0)
    assert step.settling == pytest.approx(0.5, abs=1e-3)
    assert step.ripple == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize("values", [0.5 * np.ones(4001), np.where(TIME > 3.998, 0.5, 1.0), np.zeros(0)])
def test_response_that_has_not_settled_has_no_settling_time(values):
    found = step_response(TIME[: len(values)], values, before=0.0, goal=1.0)
    assert (found.overshoot, found.settling, found.ripple) == (0, None, None)
