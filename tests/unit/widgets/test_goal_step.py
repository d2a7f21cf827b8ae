"""Steps of the goal are noticed, and what followed them is read."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.panels.goal_step import GoalStep, step_words

TICK = 0.016


def follow(watch, seconds, *, start, goal, force):
    for k in range(round(seconds / TICK)):
        time = start + k * TICK
        watch.take(time, force(time - start) if callable(force) else force, goal)
    return start + seconds


def stepped(answer=lambda t: 6 - 3 * np.exp(-t / 0.1)):
    watch = GoalStep()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    follow(watch, 2.0, start=now, goal=6.0, force=answer)
    return watch


def test_the_first_goal_is_no_step():
    watch = GoalStep()
    follow(watch, 1.0, start=0.0, goal=3.0, force=0.0)
    assert watch.response is None


def test_a_step_is_read():
    found = stepped().response
    assert (found.before, found.goal, found.overshoot) == (3.0, 6.0, 0.0)
    assert found.settling == pytest.approx(0.3, abs=2 * TICK)
    assert step_words(found).startswith("Goal 3.0 → 6.0\u2009N: 0\u2009% over, settled in 0.3")


def test_one_that_overshoots_says_so_and_one_that_has_not_settled_too():
    found = stepped(lambda t: 6.0 + 1.5 * np.exp(-t) * np.cos(8 * t)).response
    assert found.overshoot == pytest.approx(0.5, abs=0.02)
    assert step_words(stepped(lambda _t: 4.0).response).endswith("0\u2009% over, not settled yet")


def test_a_slider_on_its_way_is_one_step():
    watch = GoalStep()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    for goal in (3.5, 4.0, 4.5, 5.0):
        now = follow(watch, 0.1, start=now, goal=goal, force=3.0)
    follow(watch, 1.0, start=now, goal=5.0, force=5.0)
    assert (watch.response.before, watch.response.goal) == (3.0, 5.0)


def test_a_slider_that_came_back_is_no_step():
    watch = GoalStep()
    now = follow(watch, 1.0, start=0.0, goal=3.0, force=3.0)
    now = follow(watch, 0.1, start=now, goal=4.0, force=3.0)
    follow(watch, 0.5, start=now, goal=3.0, force=3.0)
    assert watch.response is None


def test_a_lost_contact_ends_the_watch_and_its_return_is_no_step():
    watch = stepped()
    before = watch.response
    watch.take(3.1, 0.0, None)
    watch.take(3.2, 0.0, 6.0)
    assert watch.response.before == before.before
    assert watch.response.goal == before.goal


def test_another_change_ends_the_watch():
    watch = stepped()
    before = watch.response
    watch.hold()
    follow(watch, 1.0, start=3.0, goal=6.0, force=20.0)
    assert watch.response == before
    follow(watch, 1.0, start=4.0, goal=2.0, force=2.0)
    assert watch.response.goal == 2.0, "until the next step"


def test_time_that_runs_backwards_forgets():
    watch = stepped()
    watch.take(0.0, 0.0, 6.0)
    assert watch.response is None
