"""Tikhonov's regularization, its price from the noise."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.blur import Blur
from app.contacts.estimators.table import make_estimator
from app.contacts.estimators.tikhonov import discrepancy
from tests.unit.contacts.estimators.contacts_by_hand import PITCH, SKIN, reading


@pytest.mark.parametrize("depth", [0.25 * PITCH, 0.5 * PITCH, PITCH])
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_force_is_found_below_a_cover(depth, share):
    exact = reading(depth=depth)
    given = reading(depth=depth, noise=share * exact.region.peak) if share else exact
    found = make_estimator("tikhonov", SKIN, depth=depth).estimate(given)
    chance = given.noise * np.linalg.norm(SKIN.areas[given.region.taxels])
    assert found.force == pytest.approx(10.0, abs=0.1 + 3 * chance)
    assert found.force == pytest.approx(given.region.force, rel=0.06), "no worse than the sum"
    assert found.refused == ""
    assert found.forces.sum() == pytest.approx(found.force)
    if share:
        assert 0 < found.misfit <= 1 + 1e-3, "explained to within the noise"
    else:
        assert found.residual < 1e-6 * exact.region.peak


def test_too_deep_a_cover_tells_no_distribution():
    depth = 2 * PITCH
    exact = reading(depth=depth)
    found = make_estimator("tikhonov", SKIN, depth=depth).estimate(reading(depth=depth, noise=0.1 * exact.region.peak))
    assert found.refused
    assert len(found.forces) == 0


def test_without_noise_it_is_least_squares():
    random = np.random.default_rng(0)
    matrix, wanted = random.normal(size=(8, 8)), random.normal(size=8)
    found = discrepancy(Blur.of(matrix), matrix @ wanted, 0.0) @ matrix @ wanted
    assert found == pytest.approx(wanted)


def test_what_lies_in_the_noise_is_nothing():
    assert not discrepancy(Blur.of(np.eye(4)), np.full(4, 0.5), 1.0).any()


@pytest.mark.parametrize("noise", [0.01, 0.1, 0.5])
def test_the_residual_is_the_noise(noise):
    random = np.random.default_rng(1)
    matrix, readings = random.normal(size=(20, 12)), random.normal(size=20)
    missed = np.linalg.norm(matrix @ discrepancy(Blur.of(matrix), readings, noise) @ readings - readings) / np.sqrt(20)
    best = np.linalg.norm(matrix @ np.linalg.lstsq(matrix, readings)[0] - readings) / np.sqrt(20)
    assert missed == pytest.approx(max(noise, best), rel=1e-6)


def test_equal_taxels_share_what_is_theirs():
    matrix = np.eye(3)[[0, 0, 2]]
    found = discrepancy(Blur.of(matrix), np.array([1.0, 1.0, 2.0]), 0.0) @ [1.0, 1.0, 2.0]
    assert np.isfinite(found).all()
    assert matrix @ found == pytest.approx([1.0, 1.0, 2.0])
