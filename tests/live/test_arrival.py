"""Readings are sorted and counted on arrival; none that arrives in time is lost."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.live.readings.arrival import ArrivalCounts, ArrivalTracker
from tactile_maps.live.readings.readings import Reading


def reading(number, at=None):
    return Reading(0.01 * number if at is None else at, [1.0], sequence=number % 2**32)


def taken(numbers, *, step=0.001, tracker=None):
    """Return the readings that are passed on for numbers arriving in sequence, and the tracker."""
    tracker = tracker or ArrivalTracker()
    out = [item for i, number in enumerate(numbers) for item in tracker.take(reading(number), step * i)]
    out += tracker.flush()
    return [item.reading.sequence for item in out], tracker


def test_readings_in_order_are_passed_on_immediately():
    tracker = ArrivalTracker()
    for number in range(5):
        assert [item.reading.sequence for item in tracker.take(reading(number), 0.01 * number)] == [number]
    assert tracker.counts == ArrivalCounts(received=5)
    assert tracker.rate(0.04) == 100.0


def test_reading_that_overtook_waits_for_its_turn():
    numbers, tracker = taken([0, 2, 3, 1, 4])
    assert numbers == [0, 1, 2, 3, 4]
    assert tracker.counts == ArrivalCounts(received=5, reordered=1)


def test_missing_reading_counts_as_lost_after_the_timeout_and_as_late_on_arrival():
    tracker = ArrivalTracker(patience=0.02)
    tracker.take(reading(0), 0.0)
    assert tracker.take(reading(2), 0.01) == []
    assert tracker.due(0.029) == []
    assert [item.reading.sequence for item in tracker.due(0.031)] == [2]
    assert tracker.counts.lost == 1
    assert tracker.take(reading(1), 0.04) == []
    assert tracker.counts == ArrivalCounts(received=3, late=1)
    assert tracker.counts.loss == 1 / 3


def test_repeated_reading_is_dropped():
    numbers, tracker = taken([0, 1, 1, 3, 3, 2])
    assert numbers == [0, 1, 2, 3]
    assert tracker.counts == ArrivalCounts(received=6, duplicated=2, reordered=1)


def test_sequence_numbers_wrap_around():
    numbers, tracker = taken([2**32 - 2, 2**32 - 1, 2**32, 2**32 + 1])
    assert numbers == [2**32 - 2, 2**32 - 1, 0, 1]
    assert tracker.counts == ArrivalCounts(received=4)


def test_restarted_sender_is_followed():
    tracker = ArrivalTracker()
    first = [tracker.take(reading(number), 0.01 * number) for number in range(100)]
    again = [tracker.take(reading(number, 5.0 + 0.01 * number), 5 + 0.01 * number) for number in range(100)]
    assert [len(out) for out in first + again] == [1] * 200
    assert tracker.counts == ArrivalCounts(received=200, restarts=1)


def test_restart_of_numbers_and_clock_is_accepted_after_three_packets():
    tracker = ArrivalTracker()
    for number in range(10_000, 15_000):
        tracker.take(reading(number), 0.01 * number)
    out = [len(tracker.take(reading(number), 200.0 + 0.01 * number)) for number in range(10)]
    assert out == [0, 0, *[1] * 8]
    assert tracker.counts.restarts == 1
    assert tracker.counts.late == 2


def test_board_whose_numbers_and_times_both_repeat_is_followed_after_five_packets():
    tracker = ArrivalTracker()
    for number in range(1000):
        tracker.take(reading(number), 0.01 * number)
    out = [len(tracker.take(reading(number), 20.0 + 0.01 * number)) for number in range(10)]
    assert out == [0] * 4 + [1] * 6
    assert (tracker.counts.restarts, tracker.counts.duplicated) == (1, 4)


def test_board_that_repeats_lost_numbers_is_followed_after_five_packets():
    tracker = ArrivalTracker()
    for number in (0, 1, 900, 901):
        tracker.take(reading(number), 0.01 * number)
    tracker.due(10.0)
    out = [len(tracker.take(reading(number), 20.0 + 0.01 * number)) for number in range(2, 12)]
    assert out == [0] * 4 + [1] * 6


def test_packet_replayed_many_times_is_not_a_restart():
    tracker = ArrivalTracker()
    for number in range(100):
        tracker.take(reading(number), 0.01 * number)
    assert not any(tracker.take(reading(40), 1.0 + 0.01 * number) for number in range(50))
    assert (tracker.counts.restarts, tracker.counts.duplicated) == (0, 50)


def test_packet_with_the_old_numbering_does_not_end_the_new_one():
    tracker = ArrivalTracker()
    for number in range(5000):
        tracker.take(reading(number), 0.01 * number)
    new = [*range(8), 5000, *range(8, 100)]
    out = [item for i, number in enumerate(new) for item in tracker.take(reading(number), 60.0 + 0.01 * i)]
    assert [item.reading.sequence for item in out] == list(range(2, 100))
    assert (tracker.counts.restarts, tracker.counts.lost) == (1, 0)


def test_clock_reset_counts_as_a_restart_without_dropped_packets():
    tracker = ArrivalTracker()
    out = [tracker.take(reading(number, 0.01 * (number % 50)), 0.01 * number) for number in range(100)]
    assert [len(items) for items in out] == [1] * 100
    assert tracker.counts == ArrivalCounts(received=100, restarts=1)
    assert tracker.delay.largest < 1e-9


@st.composite
def _sent(draw, count: int, first: int, clock: float):
    """Packets of one count in the order of their arrival: lost, repeated and reordered by up to three places."""
    numbers = range(first, first + count)
    fates = draw(st.lists(st.sampled_from(("arrives", "lost", "twice")), min_size=count, max_size=count))
    moved = draw(st.lists(st.integers(0, 3), min_size=2 * count, max_size=2 * count))
    arrivals = []
    for place, (number, fate) in enumerate(zip(numbers, fates, strict=True)):
        copies = {"arrives": 1, "lost": 0, "twice": 2}[fate]
        packet = reading(number, round(clock + 0.01 * place, 6))
        arrivals += [(place + moved[2 * place + copy], packet) for copy in range(copies)]
    arrivals.sort(key=lambda item: item[0])
    return [packet for _, packet in arrivals]


def _received(tracker, packets, start):
    """Return the readings passed on for each packet; packets arrive at the interval of their sending."""
    return [tracker.take(packet, start + 0.01 * place) for place, packet in enumerate(packets)]


@pytest.mark.long
@given(_sent(40, 0, 0.0))
def test_loss_repeats_and_reordering_are_not_a_restart(packets):
    tracker = ArrivalTracker(patience=0.15)
    out = [item.reading.sequence for items in _received(tracker, packets, 0.0) for item in items]
    out += [item.reading.sequence for item in tracker.flush()]
    counts = tracker.counts
    assert counts.restarts == 0
    assert out == sorted(set(out))
    assert len(out) + counts.duplicated + counts.late == counts.received == len(packets)


@st.composite
def _restarted(draw):
    """Packets before and after a restart by which the numbers, the clock or both begin again; some of the old ones are
    still under way after it.
    """
    first = draw(st.sampled_from([0, 700, 2**32 - 20]))
    old = draw(_sent(300, first, 0.0))
    numbers_again, clock_again = draw(st.sampled_from([(True, True), (True, False), (False, True)]))
    number = draw(st.sampled_from([0, first, first + 150])) if numbers_again else first + 303
    new = draw(_sent(60, number, 0.0 if clock_again else 3.1))
    late = draw(st.integers(0, 3))
    mixed = [*new[:late], *old[len(old) - late :], *new[late:]]
    return old[: len(old) - late], mixed, {id(packet) for packet in old[len(old) - late :]}


@pytest.mark.long
@given(_restarted())
def test_restart_is_followed_within_five_packets(packets):
    old, mixed, still_old = packets
    tracker = ArrivalTracker(patience=0.15)
    _received(tracker, old, 0.0)
    handed_on = {id(item.reading) for items in _received(tracker, mixed, 0.01 * len(old) + 0.1) for item in items}
    handed_on |= {id(item.reading) for item in tracker.flush()}
    last_old = max((place for place, packet in enumerate(mixed) if id(packet) in still_old), default=-1)
    first = {packet.sequence: packet for packet in reversed(mixed[last_old + 1 :])}
    in_order = [first[number] for number in dict.fromkeys(packet.sequence for packet in mixed[last_old + 1 :])]
    recognised = max((packet.time for packet in in_order[:5]), default=0.0)  # those sent before may come too late
    missing = [packet for packet in in_order[5:] if packet.time > recognised and id(packet) not in handed_on]
    assert not missing
    assert tracker.counts.restarts >= 1


def test_repeated_superseded_numbers_never_make_the_lost_count_negative():
    tracker = ArrivalTracker(patience=0.0)
    tracker.take(reading(0), 0.0)
    tracker.supersede([0.1] * 9, decoded=False)
    assert [item.reading.sequence for item in tracker.take(reading(10), 0.11)] == [10]
    assert tracker.counts.lost == 0
    tracker.take(reading(4), 0.12)  # of a sender that was started again, as long as that is not known
    assert (tracker.counts.lost, tracker.counts.late) == (0, 1)


def test_readings_without_numbers_are_passed_on():
    tracker = ArrivalTracker()
    assert len(tracker.take(Reading(0.0, [1.0]), 0.0)) == 1
    assert tracker.delay is None


def test_delay_is_reported_relative_to_the_fastest_packet():
    tracker = ArrivalTracker()
    for number, late in enumerate([0.0, 0.01, 0.03, 0.0, 0.0]):
        tracker.take(reading(number), 7.0 + 0.01 * number + late)
    assert np.isclose(tracker.delay.largest, 0.03)
    assert np.isclose(tracker.delay.median, 0.0)


@given(st.permutations(range(12)), st.sets(st.integers(0, 11)), st.lists(st.integers(0, 11), max_size=4))
def test_every_received_packet_is_passed_on_or_counted(order, dropped, repeated):
    """Five old numbers in a row, sent again, count as a restart."""
    sent = [0, *(n + 1 for n in order if n not in dropped), *(n + 1 for n in repeated if n not in dropped)]
    numbers, tracker = taken(sent, step=0.0)
    counts = tracker.counts
    assert numbers == sorted(set(sent))
    assert counts.received == len(sent)
    assert counts.duplicated == len(sent) - len(set(sent))
    assert counts.lost == max(sent) + 1 - len(set(sent))
    assert counts.late == counts.restarts == 0


@pytest.mark.parametrize(
    "wild",
    [
        Reading(0.5, [1.0], sequence=2**31),  # a number far ahead
        Reading(0.5, [1.0], sequence=3 * 2**30),  # a number from before
        Reading(0.5, [1.0], sequence=7),  # a known number with another time
        Reading(1e9, [1.0], sequence=50),  # times far ahead and from before, in the right place
        Reading(0.0, [1.0], sequence=50),
        Reading(-1e9, [1.0], sequence=2**31),
    ],
)
def test_single_packet_with_an_outlying_number_or_time_is_not_a_restart(wild):
    tracker = ArrivalTracker()
    numbers = [number for number in range(100) if number != wild.sequence or number != 50]
    packets = [reading(number) for number in numbers]
    packets.insert(50, wild)
    out = [item.reading for place, packet in enumerate(packets) for item in tracker.take(packet, 0.01 * place)]
    assert out == packets
    assert (tracker.counts.restarts, tracker.counts.lost, tracker.counts.late) == (0, 0, 0)


def test_unrelated_outliers_in_a_row_are_not_a_restart():
    tracker = ArrivalTracker()
    packets = [reading(number) for number in range(100)]
    packets[50:50] = [Reading(0.5, [1.0], sequence=number) for number in (2**31, 3 * 2**30, 10**9)]
    out = [item.reading for place, packet in enumerate(packets) for item in tracker.take(packet, 0.01 * place)]
    assert out == packets
    assert tracker.counts == ArrivalCounts(received=103)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (1, 0, 2, 3), (0, 0, 1, 1, 2, 3), (0, 2, 1, 3)])
def test_restart_is_counted_once_and_each_reading_passed_on_once(order):
    tracker = ArrivalTracker()
    for number in range(1000):
        tracker.take(reading(number), 0.01 * number)
    again = [reading(number, 20.0 + 0.01 * number) for number in order]
    out = [item.reading for place, packet in enumerate(again) for item in tracker.take(packet, 20 + 0.01 * place)]
    assert sorted(one.sequence for one in out) == [0, 1, 2, 3] if order != (0, 2, 1, 3) else [0, 2, 3]
    assert (tracker.counts.restarts, tracker.counts.duplicated) == (1, len(order) - len(set(order)))
