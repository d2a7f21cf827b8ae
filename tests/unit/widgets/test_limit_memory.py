"""Limits are remembered, so that none flickers by unread."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.panels.limit_memory import LEGIBLE, Limit, LimitMemory


def played(*times_and_limits, seconds=10.0):
    memory = LimitMemory(seconds=seconds)
    for time, limits in times_and_limits:
        memory.take(time, limits)
    return memory


def test_nothing_is_told_before_anything_happened():
    assert LimitMemory().told == ()
    assert played((0.0, ())).rows == ()


def test_an_active_limit_is_told_with_its_newest_words():
    memory = played((0.0, ("energy given, 0.1 J",)), (0.1, ("energy given, 0.2 J", "joint limit")))
    assert memory.told == (Limit("energy given, 0.2 J", True), Limit("joint limit", True))
    assert [name for name, _ in memory.rows] == ["energy given", "joint limit"]


def test_one_that_ended_stays_legible_for_a_second():
    memory = played((0.0, ("joint limit",)), (0.5, ()))
    assert memory.told == (Limit("joint limit", False),)
    memory.take(LEGIBLE, ())
    assert memory.told == (Limit("joint limit", False),)
    memory.take(LEGIBLE + 0.01, ())
    assert memory.told == ()
    assert len(memory.rows) == 1, "the strip has it for longer"


def test_the_active_come_first_and_then_the_newest():
    memory = played((0.0, ("a",)), (0.2, ("b",)), (0.4, ("c",)))
    assert [limit.words for limit in memory.told] == ["c", "b", "a"]
    assert [limit.active for limit in memory.told] == [True, False, False]


def test_spans_are_ages_that_end_now_while_it_is_active():
    memory = played((0.0, ("a",)), (0.05, ("a",)), (0.1, ()), (1.0, ("a",)), (1.5, ("a",)))
    ((_, spans),) = memory.rows
    np.testing.assert_allclose(spans, [(-1.5, -1.45), (-0.5, 0.0)])


def test_flicker_is_one_span():
    memory = played(*((0.02 * k, ("a",) if k % 2 else ()) for k in range(40)))
    ((_, spans),) = memory.rows
    assert len(spans) == 1


def test_what_is_long_past_is_forgotten():
    memory = played((0.0, ("a",)), (5.0, ("b",)), (10.0, ()), (10.1, ()))
    assert [name for name, _ in memory.rows] == ["b"]


def test_a_span_that_began_long_ago_is_cut_at_the_edge():
    memory = played(*((0.5 * k, ("a",)) for k in range(40)))
    ((_, spans),) = memory.rows
    assert spans == ((-10.0, 0.0),)


@pytest.mark.parametrize("time", [0.0, 30.0])
def test_time_that_jumps_starts_afresh(time):
    memory = played((5.0, ("a",)), (time, ()))
    assert memory.rows == memory.told == ()
