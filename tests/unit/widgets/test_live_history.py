"""The ring of live samples: the newest seconds, in order, and nothing older."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.panels.live_history import LiveHistory


def test_it_keeps_the_last_seconds_in_order():
    history = LiveHistory(seconds=2.0, capacity=64)
    for k in range(200):
        history.add(0.1 * k, {"force": float(k)})
    ages, force = history.series("force")
    assert ages[-1] == 0.0
    assert ages[0] == pytest.approx(-2.0, abs=0.11)
    assert (np.diff(ages) > 0).all()
    assert force.tolist() == list(range(200 - len(force), 200))


def test_a_full_ring_drops_the_oldest():
    history = LiveHistory(seconds=100.0, capacity=8)
    for k in range(11):
        history.add(float(k), {"x": float(k)})
    assert history.series("x")[1].tolist() == [3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize("time", [1.0, 50.0])
def test_a_jump_in_time_starts_over(time):
    history = LiveHistory()
    history.add(3.0, {"x": 1.0})
    history.add(time, {"x": 2.0})
    assert history.series("x")[1].tolist() == [2.0]


def test_series_that_come_and_go():
    history = LiveHistory()
    history.add(0.0, {"a": 1.0})
    history.add(0.1, {"b": 2.0, "a": 3.0})
    history.add(0.2, {"b": 4.0})
    assert history.names == ("a", "b")
    np.testing.assert_array_equal(history.series("a")[1], [1.0, 3.0, np.nan])
    np.testing.assert_array_equal(history.series("b")[1], [np.nan, 2.0, 4.0])


def test_nothing_known_is_nothing_drawn():
    history = LiveHistory()
    assert np.isnan(history.latest)
    assert [len(part) for part in history.series("force")] == [0, 0]
    history.add(0.0, {"force": 1.0})
    history.clear()
    assert history.names == ()
    assert len(history.series("force")[0]) == 0
