"""Ages of readings: two clocks without a common zero, drift, backlogs and clocks that are set."""

from __future__ import annotations

import pytest

from tactile_maps.live.readings.data_age import DRIFT, JUMP, SETTLE_SECONDS, DataAge

OFFSET = 1.7e9
"""Sender's clock minus receiver's [s]."""


def stream(ages, seconds, *, delay=0.001, start=0.0, rate=1.0, period=0.01):
    """Add steady readings; the last age."""
    age = None
    for number in range(round(seconds / period)):
        now = start + number * period
        age = ages.add(OFFSET + rate * now - delay, now)
    return age


def test_age_is_the_delay_above_the_shortest():
    ages = DataAge()
    assert stream(ages, 1.0) == pytest.approx(0.0, abs=1e-6)
    assert ages.add(OFFSET + 1.0 - 0.001 - 0.12, 1.0) == pytest.approx(0.12, abs=1e-5)


@pytest.mark.parametrize("rate", [1 + 0.9 * DRIFT, 1 - 0.9 * DRIFT])
def test_drift_of_either_clock_is_followed(rate):
    ages = DataAge()
    assert stream(ages, 1000.0, rate=rate) < 1e-3
    assert ages.jumps == 0
    assert ages.settled


def test_growing_delay_beyond_the_drift_is_age():
    ages = DataAge()
    stream(ages, 1.0)
    for number in range(1, 15):  # a queue that grows by 1 % of the time
        now = 1.0 + number
        age = ages.add(OFFSET + now - 0.001 - 0.01 * (now - 1.0), now)
    assert age == pytest.approx(0.14 - 14 * DRIFT, abs=1e-3)


def test_backlog_at_the_start_delays_settling():
    ages = DataAge()
    for number in range(200):  # two seconds of packets arrive at once, in bursts
        ages.add(OFFSET + 0.01 * number, 2.0 + 0.001 * number)
    assert not ages.settled
    stream(ages, SETTLE_SECONDS - 0.02, start=2.2, delay=0.0)
    assert not ages.settled
    stream(ages, SETTLE_SECONDS + 0.05, start=2.2 + SETTLE_SECONDS, delay=0.0)
    assert ages.settled


@pytest.mark.parametrize("set_by", [2 * JUMP, -2 * JUMP, -1e9, 1e9])
def test_changed_clock_is_counted_and_measured_again(set_by):
    ages = DataAge()
    stream(ages, 1.0)
    ages.add(OFFSET + 1.0 + set_by, 1.0)
    assert ages.jumps == 1
    assert not ages.settled
    for number in range(100):
        age = ages.add(OFFSET + 1.0 + 0.01 * number + set_by, 1.0 + 0.01 * number)
    assert age == pytest.approx(0.0, abs=1e-6)
    assert (ages.jumps, ages.settled) == (1, True)


def test_increased_delay_of_all_readings_is_the_new_reference_after_a_second():
    ages = DataAge()
    stream(ages, 1.0)
    assert stream(ages, 0.6, start=1.3, delay=0.101 + JUMP) > JUMP
    assert stream(ages, 2.0, start=1.9, delay=0.101 + JUMP) < 0.01
    assert ages.jumps == 0


def test_file_has_no_age():
    ages = DataAge(live=False)
    assert ages.settled
    assert ages.add(5.0, 1000.0) == 0.0
    assert ages.add(4.0, 2000.0) == 0.0
    assert ages.jumps == 0
