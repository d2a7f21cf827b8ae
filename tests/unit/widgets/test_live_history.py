"""The ring of live samples: the newest seconds, in order, and nothing older."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.panels.live_history import LiveHistory, TaxelHistory


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


def test_series_that_fell_silent_are_dropped():
    history = LiveHistory(seconds=2.0)
    for k in range(30):
        history.add(0.125 * k, {"all": 1.0} | ({"short": 2.0} if k < 5 else {}))
        assert history.forget_silent() == (("short",) if k == 21 else ())
    assert history.names == ("all",)


def test_a_taxel_asked_for_later_shows_its_past():
    history = TaxelHistory(seconds=2.0, capacity=64)
    for k in range(100):
        history.add(0.1 * k, 1e3 * np.array([k, 2 * k, 0.5]))
    ages, kilopascals = history.traces(np.array([2, 1]))
    assert ages[-1] == 0.0
    assert ages[0] == pytest.approx(-2.0, abs=0.11)
    assert kilopascals.shape == (len(ages), 2)
    np.testing.assert_allclose(kilopascals[:, 1], 2.0 * np.arange(100 - len(ages), 100))
    assert set(kilopascals[:, 0]) == {0.5}


def test_a_full_ring_of_taxels_drops_the_oldest():
    history = TaxelHistory(seconds=100.0, capacity=8)
    for k in range(11):
        history.add(float(k), np.array([1e3 * k]))
    assert history.traces(np.array([0]))[1][:, 0].tolist() == [3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize(("time", "count"), [(1.0, 2), (50.0, 2), (2.1, 5)])
def test_taxels_start_over_after_a_jump_or_with_another_skin(time, count):
    history = TaxelHistory()
    assert history.traces(np.array([], int))[0].size == 0
    for k in range(3):
        history.add(1.0 * k, np.array([1e3, 2e3]))
    history.add(time, np.zeros(count))
    assert history.traces(np.array([0]))[1].tolist() == [[0.0]]
