"""Whatever is on and whatever presses: the same readings again, from the same seed, the same state or the start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import (
    Crosstalk,
    DeadTaxels,
    GainSpread,
    Hysteresis,
    Noise,
    OffsetDrift,
    Quantisation,
    Sampling,
    Saturation,
    SensorEffects,
    Threshold,
)
from tests.support.examples import examples
from tests.support.sensors import ALL_ON, STAGES, readings, row

TAXELS = 7
SKIN = row(TAXELS)
pascals = st.floats(0.0, 1e6)


def maybe(kind, **numbers):
    """The effect with any numbers it takes, or None."""
    return st.none() | st.builds(kind, **numbers)


effects = st.builds(
    SensorEffects,
    crosstalk=maybe(Crosstalk, share=st.floats(0, 0.9)),
    hysteresis=maybe(Hysteresis, share=st.floats(0, 1), seconds=st.floats(1e-3, 1e4)),
    gain_spread=maybe(GainSpread, sd=st.floats(0, 1)),
    offset_drift=maybe(OffsetDrift, sd=pascals, walk=pascals),
    noise=maybe(Noise, sd=pascals),
    saturation=maybe(Saturation, at=st.floats(1.0, 1e9)),
    threshold=maybe(Threshold, at=pascals),
    quantisation=maybe(Quantisation, step=st.floats(1e-3, 1e6)),
    dead_taxels=maybe(DeadTaxels, dead=st.floats(0, 0.5), stuck=st.floats(0, 0.5), stuck_at=st.floats(0, 1e9)),
    sampling=maybe(Sampling, rate=st.floats(0.1, 1e4), delay=st.floats(0, 1)),
)
ticks = st.sampled_from([0.0005, 0.005, 0.0333, 1.0])
presses = st.lists(st.lists(st.floats(-1e99, 1e99), min_size=TAXELS, max_size=TAXELS), max_size=30)


def chain(choice, tick, seed):
    return SensorChain(SKIN, choice, tick=tick, seed=seed)


def assert_same(one, other):
    """Bit for bit, signs of noughts included."""
    assert one.tobytes() == other.tobytes()


@pytest.mark.long
@given(choice=effects, tick=ticks, seed=st.integers(0, 2**70), pressures=presses)
@examples(150)
def test_replay_and_reset_give_the_same_finite_readings(choice, tick, seed, pressures):
    one = chain(choice, tick, seed)
    other = chain(choice, tick, seed)
    start = one.state()
    first = readings(one, pressures)
    assert np.isfinite(first).all()
    assert_same(readings(other, pressures), first)
    assert_same(other.state(), one.state())
    one.reset()
    assert_same(one.state(), start)
    assert_same(readings(one, pressures), first)


@given(choice=effects, one=presses, other=presses, after=presses)
@examples(100)
def test_equal_states_with_different_histories_give_the_same_readings(choice, one, other, after):
    """Buffers, masks and the place of the random numbers are not in the state, and follow from it all the same."""
    creep = choice.hysteresis and replace(choice.hysteresis, seconds=1e-3)
    bus = choice.sampling and replace(choice.sampling, rate=1.0 + choice.sampling.rate / 2)
    choice = replace(choice, hysteresis=creep, sampling=bus)
    chains = chain(choice, 1.0, 5), chain(choice, 1.0, 5)
    count = min(len(one), len(other))
    forgotten = [[0.0] * TAXELS] * 5
    readings(chains[0], one[:count] + forgotten)
    readings(chains[1], other[:count] + forgotten)
    assert np.array_equal(chains[0].state(), chains[1].state()), "a second is long enough to forget"
    assert_same(readings(chains[0], after), readings(chains[1], after))


@given(name=st.sampled_from(STAGES), at=st.integers(0, 10), again=st.integers(0, 10))
@examples(100)
def test_switching_one_effect_at_run_time_does_not_change_the_others(name, at, again):
    """The other stages have the same state and random numbers as in a chain in which nothing was switched."""
    live = chain(ALL_ON, 0.005, 1)
    steady = chain(ALL_ON, 0.005, 1)
    off = replace(ALL_ON, **{name: None})
    rng = np.random.default_rng(0)
    for k in range(25):
        if k == at:
            live.use(off)
        if k == at + again:
            live.use(ALL_ON)
        pressures = rng.uniform(0, 2e5, TAXELS)
        alive = dict(live.stages)
        calm = dict(steady.stages)
        for other in STAGES:
            expected = calm[other](pressures)
            if other != name:
                assert_same(alive[other](pressures), expected)
            elif other in alive:
                alive[other](pressures)
    assert_same(live.dead, steady.dead)


@given(choice=effects, tick=ticks, seed=st.integers(0, 100), pressures=presses)
@examples(100)
def test_chain_output_satisfies_its_last_stages(choice, tick, seed, pressures):
    at_work = chain(replace(choice, sampling=None), tick, seed)
    for read in readings(at_work, pressures):
        alive = read[at_work.dead == 0]
        step = choice.quantisation.step if choice.quantisation else 0.0
        if choice.saturation:
            assert (alive <= choice.saturation.at + 0.5 * step * (1 + 1e-9)).all()
        if choice.threshold and (choice.quantisation or choice.threshold.at > 0):
            assert (alive >= 0).all()
        if choice.quantisation:
            assert np.array_equal(alive, np.rint(alive / step) * step)
        assert (read[at_work.dead == 1] == 0).all()
