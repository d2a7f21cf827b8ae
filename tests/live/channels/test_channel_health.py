"""A channel that stays the same while its neighbours change is found; a skin at rest is not suspected."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.live.channels.channel_health import ChannelHealth, SilentChannel
from tests.support.touch import bar_skin

ALL = np.arange(60)


def watched(values_at, *, seconds=2.0, until=6.0):
    health = ChannelHealth(bar_skin(), seconds=seconds)
    for number in range(int(until * 50)):
        health.add(ALL, values_at(number), 0.02 * number)
    return health


def noisy(number, **fixed):
    values = 20 + np.random.default_rng(number).normal(size=60)
    for taxel, value in fixed.items():
        values[int(taxel[1:])] = value
    return values


def test_only_dead_and_stuck_channels_are_found():
    found = watched(lambda number: noisy(number, t12=0.0, t40=255.0)).silent
    assert found == (SilentChannel(12, 0.0, False), SilentChannel(40, 255.0, True))


def test_channel_that_fails_later_is_found_and_a_recovered_one_is_not():
    health = watched(lambda number: noisy(number, t12=0.0) if number > 100 else noisy(number))
    assert [one.taxel for one in health.silent] == [12]
    for number in range(300, 600):
        health.add(ALL, noisy(number), 0.02 * number)
    assert health.silent == ()


def test_constant_readings_make_no_channel_suspect():
    assert watched(lambda _number: np.zeros(60)).silent == ()


def test_contact_elsewhere_makes_no_channel_suspect():
    def values(number):
        return np.where(ALL == 3, float(number), 0.0)

    assert watched(values).silent == ()


def test_parts_of_a_skin_may_arrive_separately():
    health = ChannelHealth(bar_skin(), seconds=2.0)
    for number in range(300):
        half = ALL[number % 2 :: 2]
        health.add(half, noisy(number, t12=0.0)[half], 0.02 * number)
    assert [one.taxel for one in health.silent] == [12]
    health.reset()
    assert health.silent == ()


@pytest.mark.parametrize("jump", [0.5, 3.0, 9.9])
def test_jump_of_the_clock_makes_no_channel_suspect(jump):
    health = ChannelHealth(bar_skin(), seconds=2.0)
    found = set()
    for number in range(600):
        values = (number + 7 * ALL) // 10  # each channel changes every 0.2 s, one of them every 1.6 s
        values[12] = number // 80
        health.add(ALL, values.astype(float), 0.02 * number + jump * (number > 350))
        found |= {one.taxel for one in health.silent}
    assert not found


def test_dead_channel_is_found_in_a_stream_with_gaps():
    health = ChannelHealth(bar_skin(), seconds=2.0)
    for number in range(300):
        health.add(ALL, noisy(number, t12=0.0), 0.02 * number + 30.0 * (number // 50))
    assert [one.taxel for one in health.silent] == [12]
