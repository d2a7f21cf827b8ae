"""Each effect of the sensor against a closed form that does not know its code."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy  # loads its parts when they are used: signal and stats take half a second

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
from tests.support.sensors import readings, row, stage
from tests.support.touch import arm

MANY = 20_000
"""Taxels, for chance."""


def assert_deviation(values, expected):
    """The standard deviation of normal numbers of mean 0, by chi-square bounds that one sound seed in 1e6 misses."""
    low, high = scipy.stats.chi2.ppf([5e-7, 1 - 5e-7], values.size)
    assert low < np.sum((values / expected) ** 2) < high


def assert_normal(values):
    """Kolmogorov and Smirnov see nothing but standard normal numbers."""
    assert scipy.stats.kstest(values.ravel(), "norm").pvalue > 1e-6


@pytest.mark.sampled(13)
@pytest.mark.parametrize("tick", [1e-4, 0.001, 0.005, 0.03, 1.0, 100.0])
@pytest.mark.parametrize("seconds", [0.001, 0.1, 3.0])
def test_creep_of_a_step_is_exponential_at_any_tick(tick, seconds):
    pressures = np.concatenate([np.zeros(3), np.full(200, 5e4), np.full(200, 2e4)])
    read = readings(stage(Hysteresis(0.3, seconds), tick=tick), pressures[:, None])[:, 0]
    since = tick * np.arange(200)
    arrived = 1 - math.exp(-200 * tick / seconds)
    up = 5e4 * (1 - 0.3 * np.exp(-since / seconds))
    down = 2e4 + 0.3 * (5e4 * arrived - 2e4) * np.exp(-since / seconds)
    assert not read[:3].any()
    assert read[3:203] == pytest.approx(up, rel=1e-12)
    assert read[203:] == pytest.approx(down, rel=1e-12)


def test_noise_is_white_and_normal_with_the_deviation_given():
    read = readings(stage(Noise(sd=37.0), 2000), np.full((50, 2000), 1e4)) - 1e4
    assert_deviation(read, 37.0)
    assert_normal(read / 37.0)
    bound = 5 / math.sqrt(read.size)
    assert abs(np.mean(read[1:] * read[:-1])) < bound * 37.0**2, "the next reading knows nothing of this one"
    assert abs(np.mean(read[:, 1:] * read[:, :-1])) < bound * 37.0**2, "nor the next taxel"


@pytest.mark.parametrize("tick", [0.001, 0.02])
def test_drift_variance_is_linear_in_time_at_any_tick(tick):
    ticks = round(0.4 / tick)
    read = readings(stage(OffsetDrift(sd=30.0, walk=50.0), MANY, tick=tick), np.zeros((ticks + 1, MANY)))
    for k in (0, ticks // 4, ticks // 2, ticks):
        expected = math.sqrt(30.0**2 + 50.0**2 * k * tick)
        assert_deviation(read[k], expected)
        assert_normal(read[k] / expected)
    assert_deviation(read[-1] - read[ticks // 2], 50.0 * math.sqrt(tick * (ticks - ticks // 2)))


def test_random_numbers_of_effects_are_uncorrelated():
    """The same seed, yet gains, first offsets and noise are not correlated."""
    (gains,) = np.log(readings(stage(GainSpread(), MANY), np.ones((1, MANY))))
    (offsets,), (noise,) = (readings(stage(spec, MANY), np.zeros((1, MANY))) for spec in (OffsetDrift(), Noise()))
    assert np.abs(np.corrcoef([gains, offsets, noise]) - np.eye(3)).max() < 5 / math.sqrt(MANY)


@pytest.mark.parametrize("sd", [0.05, 0.3, 1.0])
def test_gains_have_mean_one_and_the_deviation_given(sd):
    (gains,) = readings(stage(GainSpread(sd), MANY), np.ones((1, MANY)))
    spread = math.sqrt(math.log(1 + sd**2))
    assert_normal((np.log(gains) + spread**2 / 2) / spread)
    assert abs(gains.mean() - 1) < 5 * sd / math.sqrt(MANY)
    assert gains.std() == pytest.approx(sd, rel=0.1)


def test_error_of_quantisation_is_uniform():
    rng = np.random.default_rng(0)
    pressures = rng.uniform(0, 1e5, MANY)
    error = readings(stage(Quantisation(step=200.0), MANY), [pressures])[0] - pressures
    assert np.abs(error).max() <= 100.0
    assert scipy.stats.kstest(error / 200.0 + 0.5, "uniform").pvalue > 1e-6
    assert error.std() == pytest.approx(200.0 / math.sqrt(12), rel=0.02)


@pytest.mark.parametrize("covered", ["arm", "row"])
@pytest.mark.parametrize("share", [0.0, 0.05, 0.9])
def test_crosstalk_conserves_force(covered, share):
    skin = arm().skin if covered == "arm" else row(50, areas=np.geomspace(1e-6, 1e-4, 50))
    rng = np.random.default_rng(0)
    at_work = stage(Crosstalk(share), skin=skin)
    for _ in range(20):
        pressures = rng.uniform(0, 1e5, len(skin)) * (rng.random(len(skin)) < 0.1)
        (read,) = readings(at_work, [pressures])
        assert read @ skin.areas == pytest.approx(pressures @ skin.areas, rel=1e-13)
        assert (read >= 0).all()


def test_crosstalk_spreads_to_neighbours_and_keeps_uniform_pressure_nearly_uniform():
    skin = arm().skin
    at_work = stage(Crosstalk(0.05), skin=skin)
    for taxel in (0, 150, len(skin) - 1):
        (read,) = readings(at_work, [np.arange(len(skin)) == taxel])
        near = {int(n) for pair in skin.neighbours for n in pair if taxel in pair} - {taxel}
        assert read[taxel] == pytest.approx(0.95)
        assert set(np.flatnonzero(read)) == near | {taxel}
        assert (read * skin.areas)[list(near)] == pytest.approx(0.05 * skin.areas[taxel] / len(near))
    (even,) = readings(at_work, [np.ones(len(skin))])
    assert np.abs(even - 1).max() < 0.02


def test_saturation_and_threshold_are_exact_at_their_edges():
    edges = [np.nextafter(2500.0, 0), 2500.0, np.nextafter(2500.0, 1e9), np.nextafter(18e4, 0), 18e4, 1e99]
    felt = readings(stage(Threshold(2500.0), 6), [edges])[0]
    assert felt.tolist() == [0.0, *edges[1:]]
    assert readings(stage(Saturation(18e4), 6), [edges])[0].tolist() == [*edges[:4], 18e4, 18e4]


@pytest.mark.parametrize(("rate", "tick"), [(50.0, 0.005), (30.0, 0.005), (7.3, 0.001), (90.0, 0.01), (1e4, 0.005)])
@pytest.mark.parametrize("delay", [0.0, 0.0137, 0.02, 0.5])
def test_samples_are_taken_at_the_nearest_ticks_indefinitely_and_arrive_after_the_delay(rate, tick, delay):
    ticks = round(40 / tick) // 4
    read = readings(stage(Sampling(rate, delay), tick=tick), np.arange(1.0, ticks + 1)[:, None])[:, 0]
    taken = np.unique(read[read > 0]) - 1
    late = int(np.flatnonzero(read)[0])
    assert abs(late * tick - delay) <= tick / 2 * (1 + 1e-9), "the delay in whole ticks, the nearest"
    period = max(1 / rate, tick)
    assert np.abs(taken * tick - period * np.arange(len(taken))).max() <= tick / 2 * (1 + 1e-6)
    assert len(taken) == pytest.approx((ticks - late) * tick / period, abs=1.5), "none is left out"
    held = np.repeat(taken + 1, np.diff([*(taken + late), ticks]).astype(int))
    assert np.array_equal(read, np.concatenate([np.zeros(late), held])), "each holds until the next arrives"


@pytest.mark.parametrize("count", [1, 7, 100, 1000])
@pytest.mark.parametrize(
    ("dead", "stuck"), [(0.0, 0.0), (0.02, 0.0), (0.1, 0.25), (0.333, 0.667), (1.0, 0.0), (0.0, 1.0)]
)
def test_number_of_broken_taxels_follows_the_share(count, dead, stuck):
    codes = stage(DeadTaxels(dead, stuck), count).codes
    assert abs(np.count_nonzero(codes == 1) - dead * count) <= 0.5
    assert abs(np.count_nonzero(codes == 2) - stuck * count) <= 0.5 + 1e-9


@pytest.mark.long
def test_after_an_hour_drift_is_within_its_bound_and_creep_has_vanished():
    chain = SensorChain(row(3), SensorEffects(hysteresis=Hysteresis(), offset_drift=OffsetDrift()), tick=0.02, seed=1)
    chain.read(np.full(3, 1e5))
    for _ in range(180_000):
        read = chain.read(np.zeros(3))
    bound = scipy.stats.norm.isf(1e-7) * math.hypot(100.0, 20.0 * 60.0)
    assert np.isfinite(read).all()
    assert np.abs(read).max() < bound
    late = chain.state()[:3]
    assert not late.any(), "nothing lingers as a subnormal number"


def test_effects_are_applied_in_order():
    """The order is creep, then the highest reading, then the least, then steps; each sees what the one before made."""
    effects = SensorEffects(
        hysteresis=Hysteresis(0.5, 1.0),
        saturation=Saturation(1000.0),
        threshold=Threshold(300.0),
        quantisation=Quantisation(7.0),
    )
    read = SensorChain(row(4), effects, tick=0.01, seed=0).read(np.array([590.0, 620.0, 1990.0, 5000.0]))
    assert read.tolist() == [0.0, 308.0, 994.0, 1001.0]
