"""What arrives is put in order and counted; nothing that arrived in time is lost."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.live.arrival import ArrivalCounts, ArrivalTracker
from app.live.readings import Reading


def reading(number, at=None):
    return Reading(0.01 * number if at is None else at, [1.0], sequence=number % 2**32)


def taken(numbers, *, step=0.001, tracker=None):
    """What is handed on of numbers that come one after the other, and the tracker."""
    tracker = tracker or ArrivalTracker()
    out = [item for i, number in enumerate(numbers) for item in tracker.take(reading(number), step * i)]
    out += tracker.flush()
    return [item.reading.sequence for item in out], tracker


def test_in_order_they_pass_at_once():
    tracker = ArrivalTracker()
    for number in range(5):
        assert [item.reading.sequence for item in tracker.take(reading(number), 0.01 * number)] == [number]
    assert tracker.counts == ArrivalCounts(received=5)
    assert tracker.rate(0.04) == 100.0


def test_what_overtook_waits_for_its_turn():
    numbers, tracker = taken([0, 2, 3, 1, 4])
    assert numbers == [0, 1, 2, 3, 4]
    assert tracker.counts == ArrivalCounts(received=5, reordered=1)


def test_a_gap_is_lost_when_patience_ends_and_late_when_it_comes_after_all():
    tracker = ArrivalTracker(patience=0.02)
    tracker.take(reading(0), 0.0)
    assert tracker.take(reading(2), 0.01) == []
    assert tracker.due(0.029) == []
    assert [item.reading.sequence for item in tracker.due(0.031)] == [2]
    assert tracker.counts.lost == 1
    assert tracker.take(reading(1), 0.04) == []
    assert tracker.counts == ArrivalCounts(received=3, late=1)
    assert tracker.counts.loss == 1 / 3


def test_what_comes_twice_is_dropped_once():
    numbers, tracker = taken([0, 1, 1, 3, 3, 2])
    assert numbers == [0, 1, 2, 3]
    assert tracker.counts == ArrivalCounts(received=6, duplicated=2, reordered=1)


def test_numbers_go_round():
    numbers, tracker = taken([2**32 - 2, 2**32 - 1, 2**32, 2**32 + 1])
    assert numbers == [2**32 - 2, 2**32 - 1, 0, 1]
    assert tracker.counts == ArrivalCounts(received=4)


def test_a_sender_that_starts_again_is_followed():
    tracker = ArrivalTracker()
    first = [tracker.take(reading(number), 0.01 * number) for number in range(100)]
    again = [tracker.take(reading(number, 5.0 + 0.01 * number), 5 + 0.01 * number) for number in range(100)]
    assert [len(out) for out in first + again] == [1] * 200
    assert tracker.counts == ArrivalCounts(received=200, restarts=1)


def test_one_whose_clock_starts_again_too_is_followed_after_three():
    tracker = ArrivalTracker()
    for number in range(10_000, 15_000):
        tracker.take(reading(number), 0.01 * number)
    out = [len(tracker.take(reading(number), 200.0 + 0.01 * number)) for number in range(10)]
    assert out == [0, 0, *[1] * 8]
    assert tracker.counts.restarts == 1
    assert tracker.counts.late == 2


def test_readings_without_numbers_pass():
    tracker = ArrivalTracker()
    assert len(tracker.take(Reading(0.0, [1.0]), 0.0)) == 1
    assert tracker.delay is None


def test_the_delay_is_told_beyond_the_quickest():
    tracker = ArrivalTracker()
    for number, late in enumerate([0.0, 0.01, 0.03, 0.0, 0.0]):
        tracker.take(reading(number), 7.0 + 0.01 * number + late)
    assert np.isclose(tracker.delay.largest, 0.03)
    assert np.isclose(tracker.delay.median, 0.0)


@given(st.permutations(range(12)), st.sets(st.integers(0, 11)), st.lists(st.integers(0, 11), max_size=5))
def test_nothing_that_arrived_is_lost_and_every_packet_is_counted(order, dropped, repeated):
    sent = [0, *(n + 1 for n in order if n not in dropped), *(n + 1 for n in repeated if n not in dropped)]
    numbers, tracker = taken(sent, step=0.0)
    counts = tracker.counts
    assert numbers == sorted(set(sent))
    assert counts.received == len(sent)
    assert counts.duplicated == len(sent) - len(set(sent))
    assert counts.lost == max(sent) + 1 - len(set(sent))
    assert counts.late == counts.restarts == 0
