"""Noise of each taxel from few readings: the estimate, its limits, and the rate of false contacts that follows."""

from __future__ import annotations

import numpy as np
import pytest
import scipy  # loads its parts when they are used: signal and stats take half a second

from tactile_maps.contacts.detection.centre_of_pressure import SensorUncertainty
from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.contacts.detection.taxel_noise import (
    TailShape,
    TaxelNoise,
    estimate_noise,
    student_factor,
    tail_of_readings,
)
from tactile_maps.contacts.pipeline import ReadingSettings
from tests.support.touch import bar_map

TAXELS = 1000
RATE = 200.0
"""Readings per second, for rates of false contacts."""
FEW = 3
"""Contacts per hour that noise alone may cause on ``TAXELS`` taxels at ``RATE``."""


def two_decades(random):
    """(taxels,) standard deviations [Pa], spread evenly over two decades."""
    return 1e3 * 10 ** random.uniform(0, 2, TAXELS)


def tared(random, sigma, readings):
    """Baseline of a tare, and the noise estimated from it."""
    values = sigma * random.standard_normal((readings, len(sigma)))
    return values.mean(0), estimate_noise(values.std(0), np.full(len(sigma), readings))


KINDS = {
    "normal": (lambda random, shape: random.standard_normal(shape), lambda limits: scipy.stats.norm.sf(limits)),
    "clipped": (
        lambda random, shape: np.maximum(0.0, random.standard_normal(shape)),
        lambda limits: np.where(limits > 0, scipy.stats.norm.sf(limits), 1.0),
    ),
    "laplace": (lambda random, shape: random.laplace(size=shape), lambda limits: scipy.stats.laplace.sf(limits)),
    "t5": (lambda random, shape: random.standard_t(5, size=shape), lambda limits: scipy.stats.t.sf(limits, 5)),
}
"""Kinds of noise: samples, and the probability to exceed a limit."""


def test_factors_are_quantiles_of_the_student_t_distribution():
    freedom = np.array([1.5, 4.0, 49.0, 1e9])
    for deviations in (3.0, 6.0):
        factors = student_factor(deviations, freedom)
        assert factors[:3] == pytest.approx(scipy.stats.t.isf(scipy.stats.norm.sf(deviations), freedom[:3]), rel=1e-6)
        assert factors[3] == deviations


def test_similar_taxels_share_their_noise():
    _, noise = tared(np.random.default_rng(0), np.full(TAXELS, 50.0), 5)
    assert noise.freedom.min() > 100
    assert noise.sd == pytest.approx(np.full(TAXELS, 50.0 * np.sqrt(1.2)), rel=0.1)


def test_different_taxels_keep_their_own_noise():
    random = np.random.default_rng(0)
    sigma = two_decades(random)
    _, noise = tared(random, sigma, 50)
    assert noise.sd == pytest.approx(sigma, rel=0.5)
    assert noise.freedom.max() < 55
    _, few = tared(random, sigma, 5)
    assert 4 < few.freedom.min() <= few.freedom.max() < 6


def test_constant_readings_give_no_noise_estimate():
    counts = np.full(60, 20)
    assert estimate_noise(np.zeros(60), counts) is None
    spread = np.full(60, 10.0)
    spread[7] = 0.0
    noise = estimate_noise(spread, np.where(np.arange(60) == 8, 1, counts))
    assert noise.sd[[7, 8]] == pytest.approx(noise.sd[9] * np.array([1.0, np.sqrt(2 / 1.05)]), rel=1e-6)


@pytest.mark.parametrize("quiet", [1, 9])
def test_one_noisy_taxel_does_not_hide_a_contact_of_its_neighbours(quiet):
    noise = TaxelNoise(np.r_[np.full(quiet, 1.0), 1e4], np.full(quiet + 1, 49.0))
    areas = np.full(quiet + 1, 2.0)
    taxels = np.arange(quiet + 1)
    assert noise.exceeded(6.0, np.r_[np.full(quiet, 2 * 20.0 / quiet**0.5), 0.0], taxels, areas)
    assert not noise.exceeded(6.0, np.r_[np.zeros(quiet), 2 * 5e4], taxels, areas)


def test_underestimated_taxel_and_quiet_neighbour_are_not_a_contact():
    """The degrees of freedom of the sum alone would accept a large reading next to a small one."""
    noise = TaxelNoise(np.full(2, 1.0), np.full(2, 5.0))
    areas = np.ones(2)
    taxels = np.arange(2)
    alone = float(noise.limits(6.0)[0])
    assert not noise.exceeded(6.0, np.array([0.8 * alone, 0.1 * alone]), taxels, areas)
    assert noise.exceeded(6.0, np.array([1.01 * alone, 0.1 * alone]), taxels, areas)


def test_several_taxels_above_their_thresholds_are_a_contact_although_each_alone_might_be_noise():
    """After few readings the limit of one taxel is far above its threshold."""
    noise = TaxelNoise(np.full(6, 1.0), np.full(6, 5.0))
    areas = np.ones(6)
    taxels = np.arange(6)
    forces = np.full(6, 1.5 * float(noise.limits(3.0)[0]))
    assert forces.sum() < float(noise.limits(6.0)[0])
    assert noise.exceeded(6.0, forces, taxels, areas)
    assert not noise.exceeded(6.0, forces[:3], taxels[:3], areas[:3])
    assert not noise.exceeded(6.0, forces / 3, taxels, areas)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("readings", [5, 10, 20, 50])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("decades", [0, 2])
def test_rate_of_false_contacts_is_kept_for_non_normal_noise(kind, readings, decades):
    """The average over tares is tested, from 20 readings; with fewer, a single tare may underestimate a heavy tail."""
    draw, exceeds = KINDS[kind]
    rates = []
    for seed in range(4):
        random = np.random.default_rng(seed)
        sigma = 10 ** random.uniform(0, decades, TAXELS)
        values = sigma * draw(random, (readings, TAXELS))
        noise = estimate_noise(values.std(0), np.full(TAXELS, readings), tail_of_readings(values))
        rates.append(exceeds((noise.limits(6.0) + values.mean(0)) / sigma).sum() * RATE * 3600)
    assert np.median(rates) < FEW
    if readings >= 20:
        assert np.mean(rates) < FEW


@pytest.mark.parametrize("kind", KINDS)
def test_fifty_readings_of_similar_taxels_keep_moderate_contacts(kind):
    """A contact of 100 standard deviations on each of several taxels is found whatever the noise; normal noise at 7."""
    values = KINDS[kind][0](np.random.default_rng(0), (50, TAXELS))
    noise = estimate_noise(values.std(0), np.full(TAXELS, 50), tail_of_readings(values))
    least = 7.0 if kind == "normal" else 100.0
    forces = least * noise.sd[:9]
    assert noise.exceeded(6.0, forces, np.arange(9), np.ones(9))


@pytest.mark.parametrize("readings", [5, 10])
def test_few_clipped_readings_of_a_skin_with_noisy_taxels_keep_moderate_contacts(readings):
    """So few clipped readings suggest a tail so heavy that nothing would be a contact; it is bounded."""
    random = np.random.default_rng(0)
    sigma = np.where(np.arange(300) % 10 < 2, 180.0, 15.0)
    values = np.maximum(0.0, sigma * random.standard_normal((readings, 300)))
    noise = estimate_noise(values.std(0), np.full(300, readings), tail_of_readings(values))
    taxels = np.arange(100, 116)
    assert noise.exceeded(6.0, np.linspace(500.0, 3500.0, 16), taxels, np.ones(16))
    assert noise.exceeded(6.0, np.full(1, 4000.0), taxels[5:6], np.ones(1))


def test_tail_of_taxels_that_are_constant_silent_or_rarely_differ():
    assert tail_of_readings(np.full((20, 60), 0.1)) == TailShape()
    assert tail_of_readings(np.full((20, 60), np.nan)) == TailShape()
    assert tail_of_readings(np.random.default_rng(0).standard_normal((2, 60))) == TailShape()
    values = np.random.default_rng(0).laplace(size=(20, TAXELS))
    expected = tail_of_readings(values)
    more = np.full((20, TAXELS + 9), 3.0)
    more[:, :TAXELS] = values
    more[1:, TAXELS + 3] = np.nan
    assert tail_of_readings(more) == expected
    rare = (np.random.default_rng(0).random((20, 300)) < 0.02) * 1.0
    noise = estimate_noise(rare.std(0), np.full(300, 20), tail_of_readings(rare))
    assert noise.limits(6.0).max() < 30


@pytest.mark.parametrize("kind", ["normal", "clipped"])
def test_taxels_of_an_ended_contact_are_not_contacts(kind):
    random = np.random.default_rng(3)
    map_ = bar_map(60)
    values = 10e3 * KINDS[kind][0](random, (50, 60))
    noise = estimate_noise(values.std(0), np.full(60, 50), tail_of_readings(values))
    errors = SensorUncertainty.measured(noise)
    detector = ContactDetector(map_, threshold=ReadingSettings().thresholds_for(errors), errors=errors)
    after = []
    for _ in range(200):
        rows = 10e3 * KINDS[kind][0](random, (2, 60)) - values.mean(0)
        assert detector.read(rows[0] + 1e5)
        after.append(len(detector.read(rows[1])))
    assert sum(after) <= 2


def false_contacts(readings, seed, seconds):
    """Number of readings in which noise alone is a contact, and of those that were looked at."""
    random = np.random.default_rng(seed)
    map_ = bar_map(TAXELS)
    sigma = two_decades(random)
    pairs = map_.skin.neighbours
    baseline, noise = tared(random, sigma, readings)
    errors = SensorUncertainty.measured(noise)
    detector = ContactDetector(map_, threshold=ReadingSettings().thresholds_for(errors), errors=errors)
    found = looked = 0
    for _ in range(round(seconds * RATE / 1000)):
        values = sigma * random.standard_normal((1000, TAXELS)) - baseline
        touched = values >= detector.threshold
        # A contact needs two neighbours above their thresholds, or one taxel above the limit for one.
        worth = (touched[:, pairs[:, 0]] & touched[:, pairs[:, 1]]).any(1) | (values >= noise.limits(6.0)).any(1)
        for row in values[worth]:
            looked += 1
            found += len(detector.read(row))
            detector.reset()
    return found, looked


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("readings", [5, 50])
def test_noise_over_two_decades_is_not_a_contact(readings):
    found, looked = false_contacts(readings, seed=1, seconds=60)
    assert looked > 0
    assert found == 0


@pytest.mark.long
@pytest.mark.parametrize("readings", [5, 10, 50])
def test_false_contacts_in_an_hour_are_few(readings):
    found = [false_contacts(readings, seed, seconds=900)[0] for seed in range(4)]
    assert sum(found) <= FEW


@pytest.mark.parametrize("readings", [5, 50])
def test_contact_above_the_noise_is_found(readings):
    random = np.random.default_rng(2)
    map_ = bar_map(TAXELS)
    sigma = two_decades(random) / 50
    baseline, noise = tared(random, sigma, readings)
    errors = SensorUncertainty.measured(noise)
    detector = ContactDetector(map_, threshold=ReadingSettings().thresholds_for(errors), errors=errors)
    positions = map_.skin.patches[0].taxels.positions
    away = np.linalg.norm(positions - positions[500], axis=1)
    pressed = 60e3 * np.clip(1 - (away / 0.02) ** 2, 0, None)
    found = [len(detector.read(pressed + sigma * random.standard_normal(TAXELS) - baseline)) for _ in range(200)]
    assert np.mean(np.array(found) == 1) > 0.95
