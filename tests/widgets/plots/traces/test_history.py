"""Histories of the plots: samples of the last seconds, spans of limits and events, times of changed settings."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.timing import Timings
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.plots.traces.history import (
    LIMIT_SHOWN_FOR,
    ContactHistory,
    EventHistory,
    LimitHistory,
    SampleHistory,
    SettingChanges,
    ShownLimit,
    TaxelHistory,
    VectorHistory,
    stage_times,
)
from tests.support.cost import cost_of

AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))


def test_history_keeps_the_last_seconds_in_order():
    history = SampleHistory(seconds=2.0, capacity=64)
    for k in range(200):
        history.add(0.1 * k, {"force": float(k)})
    ages, force = history.series("force")
    assert ages[-1] == 0.0
    assert ages[0] == pytest.approx(-2.0, abs=0.11)
    assert (np.diff(ages) > 0).all()
    assert force.tolist() == list(range(200 - len(force), 200))


@pytest.mark.long
def test_full_history_keeps_minimum_and_maximum_of_each_span():
    """A push of one tick among ten thousand is drawn at full height."""
    history = SampleHistory(seconds=10.0, capacity=200)
    for k in range(20_000):
        history.add(1e-3 * k, {"force": {15_003: 6.4, 15_407: -1.5}.get(k, 2.4), "other": float(k)})
    ages, force = history.series("force")
    assert len(force) <= 200
    assert (force.max(), force.min()) == (6.4, -1.5)
    assert (np.diff(ages) > 0).all()
    assert ages[force.argmax()] == pytest.approx(15.003 - 19.999, abs=0.1)
    assert ages[0] == pytest.approx(-10.0, abs=0.2)
    assert history.series("other")[1][-1] == 19_999


@pytest.mark.parametrize("time", [1.0, 50.0])
def test_jump_in_time_starts_a_new_history(time):
    history = SampleHistory()
    history.add(3.0, {"x": 1.0})
    history.add(time, {"x": 2.0})
    assert history.series("x")[1].tolist() == [2.0]


def test_missing_values_of_a_series_are_nan():
    history = SampleHistory()
    history.add(0.0, {"a": 1.0})
    history.add(0.1, {"b": 2.0, "a": 3.0})
    history.add(0.2, {"b": 4.0})
    assert history.names == ("a", "b")
    np.testing.assert_array_equal(history.series("a")[1], [1.0, 3.0, np.nan])
    np.testing.assert_array_equal(history.series("b")[1], [np.nan, 2.0, 4.0])


def test_empty_and_cleared_histories_have_empty_series():
    history = SampleHistory()
    assert history.latest is None
    assert [len(part) for part in history.series("force")] == [0, 0]
    history.add(0.0, {"force": 1.0})
    history.clear()
    assert history.names == ()
    assert len(history.series("force")[0]) == 0


def test_contact_is_dropped_when_its_last_sample_is_too_old():
    history = ContactHistory(seconds=2.0)
    for k in range(30):
        history.add(0.125 * k, {"lasting": 1.0} | ({"short": 2.0} if k < 5 else {}))
        assert history.names == (("lasting", "short") if k <= 20 else ("lasting",))
    ages, forces = history.series("lasting")
    assert ages.tolist() == [-2.0 + 0.125 * k for k in range(17)]
    assert (forces == 1.0).all()
    assert len(history.series("short")[0]) == 0


def test_contact_that_was_absent_has_a_gap_and_its_age_is_that_of_its_samples():
    history = ContactHistory(seconds=2.0)
    for k in range(5):
        history.add(0.25 * k, {"short": 1.0 * k} if k in (0, 1, 4) else {})
        ages, forces = history.series("short")
        if k == 3:
            assert ages.tolist() == [-0.75, -0.5, -0.5]
            np.testing.assert_array_equal(forces, [0.0, 1.0, np.nan])
    ages, forces = history.series("short")
    assert ages.tolist() == [-1.0, -0.75, -0.25, 0.0]
    np.testing.assert_array_equal(forces, [0.0, 1.0, np.nan, 4.0])


@pytest.mark.parametrize("time", [0.0, 3.5])
def test_contacts_start_again_when_time_jumps(time):
    history = ContactHistory(seconds=2.0)
    history.add(1.0, {"before": 1.0})
    history.add(time, {"after": 1.0})
    assert history.names == ("after",)


def test_sample_of_a_contact_costs_the_same_after_hundreds_of_short_contacts():
    history = ContactHistory(seconds=10.0)
    cost = [cost_of(partial(history.add, 0.02 * k, {str(k): 1.0})).steps for k in range(400)]
    assert cost[-1] <= cost[10]


def test_merging_samples_ignores_missing_values():
    history = SampleHistory(seconds=10.0, capacity=20)
    for k in range(4):
        history.add(0.1 * k, {"all": 1.0} | ({"some": 5.0} if k == 2 else {}))
    assert np.nanmax(history.series("some")[1]) == 5.0


def test_taxel_history_returns_the_past_of_any_taxel():
    history = TaxelHistory(seconds=2.0, capacity=64)
    for k in range(100):
        history.add(0.1 * k, 1e3 * np.array([k, 2 * k, 0.5]))
    ages, kilopascals = history.traces(np.array([2, 1]))
    assert ages[-1] == 0.0
    assert ages[0] == pytest.approx(-2.0, abs=0.11)
    assert kilopascals.shape == (len(ages), 2)
    np.testing.assert_allclose(kilopascals[:, 1], 2.0 * np.arange(100 - len(ages), 100))
    assert set(kilopascals[:, 0]) == {0.5}


def test_full_taxel_history_drops_the_oldest_frames():
    history = TaxelHistory(seconds=8.0, capacity=8)
    for k in range(11):
        history.add(float(k), np.array([1e3 * k]))
    assert history.traces(np.array([0]))[1][:, 0].tolist() == [3, 4, 5, 6, 7, 8, 9, 10]


@pytest.mark.parametrize(("time", "count"), [(1.0, 2), (50.0, 2), (2.1, 5)])
def test_jump_in_time_or_another_skin_starts_a_new_taxel_history(time, count):
    history = TaxelHistory()
    assert history.traces(np.array([], int))[0].size == 0
    for k in range(3):
        history.add(1.0 * k, np.array([1e3, 2e3]))
    history.add(time, np.zeros(count))
    assert history.traces(np.array([0]))[1].tolist() == [[0.0]]


A, B, C = (Limit(kind) for kind in (LimitKind.JOINT_LIMIT, LimitKind.JOINT_SPEED, LimitKind.CONTACT_LOST))


def energy(given):
    return Limit(LimitKind.ENERGY_TANK, value=given)


def played(*times_and_limits, seconds=10.0):
    memory = LimitHistory(seconds=seconds)
    for time, limits in times_and_limits:
        memory.take(time, limits)
    return memory


def test_new_limit_history_is_empty():
    assert LimitHistory().recent == ()
    assert played((0.0, ())).rows == ()


def test_active_limit_has_its_latest_value():
    memory = played((0.0, (energy(0.1),)), (0.1, (energy(0.2), A)))
    assert memory.recent == (ShownLimit(energy(0.2), True), ShownLimit(A, True))
    assert [kind for kind, _ in memory.rows] == [LimitKind.ENERGY_TANK, LimitKind.JOINT_LIMIT]


def test_ended_limit_is_listed_for_one_second():
    memory = played((0.0, (A,)), (0.5, ()))
    assert memory.recent == (ShownLimit(A, False),)
    memory.take(LIMIT_SHOWN_FOR, ())
    assert memory.recent == (ShownLimit(A, False),)
    memory.take(LIMIT_SHOWN_FOR + 0.01, ())
    assert memory.recent == ()
    assert len(memory.rows) == 1, "the strip still shows it"


def test_active_limits_come_first_then_the_most_recent():
    memory = played((0.0, (A,)), (0.2, (B,)), (0.4, (C,)))
    assert [shown.limit for shown in memory.recent] == [C, B, A]
    assert [limit.active for limit in memory.recent] == [True, False, False]


def test_span_of_an_active_limit_ends_now():
    memory = played((0.0, (A,)), (0.05, (A,)), (0.1, ()), (1.0, (A,)), (1.5, (A,)))
    ((_, spans),) = memory.rows
    np.testing.assert_allclose(spans, [(-1.5, -1.45), (-0.5, 0.0)])


def test_flickering_limit_is_one_span():
    memory = played(*((0.02 * k, (A,) if k % 2 else ()) for k in range(40)))
    ((_, spans),) = memory.rows
    assert len(spans) == 1


def test_old_limits_are_discarded():
    memory = played((0.0, (A,)), (5.0, (B,)), (10.0, ()), (10.1, ()))
    assert [kind for kind, _ in memory.rows] == [LimitKind.JOINT_SPEED]


def test_long_span_is_clipped_to_the_history():
    memory = played(*((0.5 * k, (A,)) for k in range(40)))
    ((_, spans),) = memory.rows
    assert spans == ((-10.0, 0.0),)


@pytest.mark.parametrize("time", [0.0, 30.0])
def test_jump_in_time_discards_limits(time):
    memory = played((5.0, (A,)), (time, ()))
    assert memory.rows == memory.recent == ()


def marked(*events):
    """Return changes after these times, each with whether a setting changed."""
    marks = SettingChanges(seconds=10.0)
    for time, changed in events:
        marks.at(time)
        if changed:
            marks.change()
    return marks


def test_old_changes_are_discarded():
    marks = marked((0.0, False), (1.0, True), (5.0, True), (6.0, False))
    assert marks.ages == (-5.0, -1.0)
    marks.at(11.5)
    assert marks.ages == (-6.5,)


def test_changes_in_quick_succession_are_one():
    marks = marked(*((0.1 * k, True) for k in range(30)), (4.0, False))
    assert marks.ages == pytest.approx((-1.1,))


@pytest.mark.parametrize("time", [0.0, 40.0])
def test_jump_in_time_discards_changes(time):
    marks = marked((2.0, False), (3.0, True), (time, False))
    assert marks.ages == ()


def test_change_before_the_first_time_is_ignored():
    marks = SettingChanges()
    marks.change()
    assert marks.ages == ()


def test_sensor_effects_are_summed_to_one_stage():
    timings = Timings({"physics": 1.0, "touch": 0.5, "noise": 0.25, "sampling": 0.125, "contacts": 2.0})
    times = stage_times(timings)
    assert list(times) == ["physics", "touch", "sensor", "contacts"]
    assert times["sensor"] == 0.375
    assert sum(times.values()) == timings.total_ms


def test_ideal_sensor_has_no_stage():
    assert "sensor" not in stage_times(Timings({"physics": 1.0, "touch": 0.5}))


def test_full_taxel_history_keeps_the_peak_of_a_short_press():
    history = TaxelHistory(seconds=1.0, capacity=100)
    for k in range(1000):
        history.add(1e-3 * k, np.array([6400.0 if k == 503 else 10.0, 5.0]))
    assert history.traces(np.array([0, 1]))[1].max(axis=0) == pytest.approx([6.4, 0.005])


def test_full_vector_history_keeps_extremes():
    history = VectorHistory(seconds=1.0, capacity=20)
    for k in range(1000):
        history.add(1e-3 * k, np.array([np.sin(0.01 * k), 5.0 if k == 503 else 0.0]))
    ages, values = history.series(1)
    assert values.max() == 5.0
    assert len(ages) <= 20
    assert ages[-1] == 0.0
    assert ages[values.argmax()] == pytest.approx(0.503 - 0.999, abs=0.1)
    assert history.series(7)[0].size == 0
    history.add(5.0, np.zeros(2))
    assert len(history.series(0)[0]) == 1, "a jump in time starts a new history"


def event(kind, time, phase="began", contacts=(1,), duration=0.0):
    return ContactEvent(round(200 * time), time, kind, phase, contacts, ("hand",), AT, duration=duration)


def test_events_are_rows_of_past_and_current_spans_without_repetition():
    history = EventHistory()
    touch = event("touch", 1.0)
    press = event("press", 1.2)
    history.take(1.5, (press, touch))
    history.take(2.0, (press, touch))
    assert dict(history.rows) == {
        "touch": ((pytest.approx(-1.0), pytest.approx(-1.0)),),
        "press": ((pytest.approx(-0.8), 0.0),),
    }
    history.take(3.0, (event("press", 2.5, "ended", duration=1.3), press, touch))
    assert dict(history.rows)["press"] == ((pytest.approx(-1.8), pytest.approx(-0.5)),)
    history.take(11.6, ())
    assert [kind for kind, _ in history.rows] == ["press"], "until its end is too old"
    history.take(3.0, ())
    assert history.rows == (), "time that runs backwards starts a new history"
