"""A force that swings is told from one that is pulled, tapped or calm."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.swing_watch import GONE, MEMORY, TURNS, SwingWatch

DT, GOAL = 0.005, 3.0


def swung(amplitude, *, rate=5.0, seconds=3.0, goal=GOAL):
    """Whether a sine about the goal counts as a swing at the end."""
    watch, swings = SwingWatch(), False
    for k in range(round(seconds / DT)):
        swings = watch.look(goal, max(goal + amplitude * np.sin(2 * np.pi * rate * k * DT), 0.0), DT)
    return swings


def test_large_swings_count_and_small_or_slow_ones_do_not():
    assert swung(2.0)
    assert swung(10.0), "down to nothing"
    assert not swung(1.0)
    assert not swung(2.0, rate=0.4, seconds=12.0)
    assert not swung(2.0, seconds=0.3)
    assert not swung(2.0, goal=0.0)


def test_calm_is_noticed_too():
    watch = SwingWatch()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), DT)
    assert watch.look(GOAL, GOAL, DT)
    calm = [watch.look(GOAL, GOAL, DT) for _ in range(round(MEMORY / DT))]
    assert not calm[-1]


@pytest.mark.parametrize("pause", [GONE + 0.1, 1.0])
def test_taps_are_no_swings(pause):
    watch = SwingWatch()
    for _ in range(2 * TURNS):
        for force, seconds in ((6.0, 0.1), (0.0, pause)):
            assert not any(watch.look(GOAL, force, DT) for _ in range(round(seconds / DT)))


def test_a_reset_forgets():
    watch = SwingWatch()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), DT)
    watch.reset()
    assert not watch.look(GOAL, GOAL, DT)
