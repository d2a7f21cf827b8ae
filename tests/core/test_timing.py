"""A stopwatch adds up stages by the clock it is given."""

from __future__ import annotations

import pytest

from tactile_maps.core.timing import Stopwatch


def test_stage_times_are_summed_and_returned_once():
    times = iter([0.0, 0.5, 1.0, 1.25, 2.0, 4.0])
    watch = Stopwatch(clock=lambda: next(times))
    for name in ("a", "b", "a"):
        with watch.stage(name):
            pass
    taken = watch.take()
    assert taken.ms == {"a": pytest.approx(2500.0), "b": pytest.approx(250.0)}
    assert taken.total_ms == pytest.approx(2750.0)
    assert watch.take().ms == {}


def test_failing_stage_is_timed():
    times = iter([0.0, 1.0])
    watch = Stopwatch(clock=lambda: next(times))
    with pytest.raises(ZeroDivisionError), watch.stage("a"):
        raise ZeroDivisionError
    assert watch.take().ms == {"a": 1000.0}
