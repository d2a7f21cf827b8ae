"""Noise of each taxel from few readings: the estimate, its limits, and the rate of false contacts that follows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from app.contacts.centre_of_pressure import SensorUncertainty
from app.contacts.detection import ContactDetector
from app.contacts.pipeline import ReadingSettings
from app.contacts.taxel_noise import TaxelNoise, estimate_noise, student_factor
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


def test_factors_are_quantiles_of_students_t():
    freedom = np.array([1.5, 4.0, 49.0, 1e9])
    for deviations in (3.0, 6.0):
        factors = student_factor(deviations, freedom)
        assert factors[:3] == pytest.approx(stats.t.isf(stats.norm.sf(deviations), freedom[:3]), rel=1e-6)
        assert factors[3] == deviations


def test_taxels_that_are_alike_share_their_noise():
    _, noise = tared(np.random.default_rng(0), np.full(TAXELS, 50.0), 5)
    assert noise.freedom.min() > 100
    assert noise.sd == pytest.approx(np.full(TAXELS, 50.0 * np.sqrt(1.2)), rel=0.1)


def test_taxels_that_differ_keep_their_own_noise():
    random = np.random.default_rng(0)
    sigma = two_decades(random)
    _, noise = tared(random, sigma, 50)
    assert noise.sd == pytest.approx(sigma, rel=0.5)
    assert noise.freedom.max() < 55
    _, few = tared(random, sigma, 5)
    assert 4 < few.freedom.min() <= few.freedom.max() < 6


def test_readings_that_never_differ_say_nothing_of_the_noise():
    counts = np.full(60, 20)
    assert estimate_noise(np.zeros(60), counts) is None
    spread = np.full(60, 10.0)
    spread[7] = 0.0
    noise = estimate_noise(spread, np.where(np.arange(60) == 8, 1, counts))
    assert noise.sd[[7, 8]] == pytest.approx(noise.sd[9] * np.array([1.0, np.sqrt(2 / 1.05)]), rel=1e-6)


def test_one_noisy_taxel_does_not_hide_a_contact_of_its_neighbours():
    noise = TaxelNoise(np.r_[np.full(9, 1.0), 1e4], np.full(10, 49.0))
    areas, taxels = np.full(10, 2.0), np.arange(10)
    assert noise.exceeded(6.0, np.full(10, 2 * 5.0), taxels, areas)
    assert not noise.exceeded(6.0, np.r_[np.zeros(9), 2 * 5e4], taxels, areas)


def test_one_underestimated_taxel_is_no_contact_together_with_a_quiet_one():
    """By the sum's degrees of freedom alone, a large reading of one taxel would count if its neighbour reads a bit."""
    noise = TaxelNoise(np.full(2, 1.0), np.full(2, 5.0))
    areas, taxels = np.ones(2), np.arange(2)
    alone = float(noise.limits(6.0)[0])
    assert not noise.exceeded(6.0, np.array([0.8 * alone, 0.1 * alone]), taxels, areas)
    assert noise.exceeded(6.0, np.array([1.01 * alone, 0.1 * alone]), taxels, areas)


@pytest.mark.parametrize("readings", [5, 10, 50])
def test_rate_of_false_contacts_of_single_taxels_holds_for_any_number_of_readings(readings):
    """Exact for each tare: the limits are fixed by it, and what a taxel reads later is normal around 0."""
    rates = []
    for seed in range(30):
        random = np.random.default_rng(seed)
        sigma = two_decades(random)
        baseline, noise = tared(random, sigma, readings)
        rates.append(stats.norm.sf((noise.limits(6.0) + baseline) / sigma).sum() * RATE * 3600)
    assert np.mean(rates) < FEW
    assert np.median(rates) < FEW


def false_contacts(readings, seed, seconds):
    """Number of readings in which noise alone is a contact, and of those that were looked at."""
    random, map_ = np.random.default_rng(seed), bar_map(TAXELS)
    sigma, pairs = two_decades(random), map_.skin.neighbours
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


@pytest.mark.parametrize("readings", [5, 50])
def test_noise_over_two_decades_is_no_contact(readings):
    found, looked = false_contacts(readings, seed=1, seconds=60)
    assert looked > 0
    assert found == 0


@pytest.mark.long
@pytest.mark.parametrize("readings", [5, 10, 50])
def test_false_contacts_in_an_hour_are_few(readings):
    found = [false_contacts(readings, seed, seconds=900)[0] for seed in range(4)]
    assert sum(found) <= FEW


@pytest.mark.parametrize("readings", [5, 50])
def test_a_contact_above_the_noise_is_found(readings):
    random, map_ = np.random.default_rng(2), bar_map(TAXELS)
    sigma = two_decades(random) / 50
    baseline, noise = tared(random, sigma, readings)
    errors = SensorUncertainty.measured(noise)
    detector = ContactDetector(map_, threshold=ReadingSettings().thresholds_for(errors), errors=errors)
    positions = map_.skin.patches[0].taxels.positions
    away = np.linalg.norm(positions - positions[500], axis=1)
    pressed = 60e3 * np.clip(1 - (away / 0.02) ** 2, 0, None)
    found = [len(detector.read(pressed + sigma * random.standard_normal(TAXELS) - baseline)) for _ in range(200)]
    assert np.mean(np.array(found) == 1) > 0.95
