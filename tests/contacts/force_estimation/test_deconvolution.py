"""Undoing the cover's blur."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.deconvolution import (
    BlurMatrix,
    ContactOperator,
    nonnegative_least_squares,
    tikhonov_inverse,
)
from tactile_maps.contacts.force_estimation.estimate import AreaSum, EstimateRefusal
from tactile_maps.contacts.force_estimation.estimation import build_estimator
from tactile_maps.core.errors import MapError
from tactile_maps.tactile.mechanics.half_space_stress import subsurface_field
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tests.contacts.force_estimation.readings_by_hand import PITCH, SKIN, reading

ALL = np.arange(len(SKIN))


@pytest.mark.parametrize("depth", [0.002, 0.008])
def test_columns_of_the_blur_matrix_conserve_force(depth):
    """All taxels together measure the force on an area at any depth."""
    matrix = ContactOperator(SKIN, depth).blur(ALL).matrix
    np.testing.assert_allclose(SKIN.areas @ matrix, SKIN.areas, rtol=1e-9)
    assert (matrix >= 0).all()
    assert np.diag(matrix).min() > 0.1


def test_blur_matrix_agrees_with_the_half_space_model():
    pressures = np.random.default_rng(0).random(len(SKIN))
    points = quadrature_points(SKIN)
    felt = np.zeros(len(SKIN))
    subsurface_field(SKIN, 0.004).add(felt, np.arange(len(points.areas)), pressures[points.taxel] * points.areas)
    np.testing.assert_allclose(ContactOperator(SKIN, 0.004).blur(ALL).matrix @ pressures, felt, rtol=1e-9)


def test_latest_blur_matrices_are_cached():
    spread = ContactOperator(SKIN, 0.004)
    parts = [np.array([k, k + 1, k + 2]) for k in range(40)]
    kept = [spread.blur(part) for part in parts]
    assert all(spread.blur(part) is blur for part, blur in zip(parts[-10:], kept[-10:], strict=True))


@pytest.mark.parametrize("depth", [0.0, -1.0, float("nan"), float("inf")])
def test_invalid_depth_is_rejected(depth):
    with pytest.raises(MapError, match="depth"):
        ContactOperator(SKIN, depth)


DEPTH = 0.5 * PITCH


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
@pytest.mark.parametrize("depth", [0.25 * PITCH, 0.5 * PITCH, PITCH])
def test_total_obeys_the_balance_of_forces(name, depth):
    """The distribution accounts for the force that passes through the region and for all of the rest."""
    given = reading(depth=depth)
    found = build_estimator(name, SKIN, depth=depth).estimate(given)
    taxels = given.region.taxels
    blur = ContactOperator(SKIN, depth).blur(taxels)
    areas = SKIN.areas[taxels]
    pressures = nonnegative_least_squares(blur, given.pressures[taxels], 0.0)
    inside = (areas @ blur.matrix @ pressures) / (areas @ pressures)
    assert 0.9 < inside < 1 - 1e-6, "some force passes outside"
    assert found.force * inside == pytest.approx(given.region.force, rel=1e-12)
    assert found.forces.sum() == pytest.approx(found.force, rel=1e-12)


def test_region_without_pressure_is_rejected_as_a_pull():
    given = reading(depth=DEPTH)
    found = build_estimator("tikhonov", SKIN, depth=DEPTH).estimate(replace(given, pressures=-given.pressures))
    assert found.refused is EstimateRefusal.PULL
    assert found.force < 0
    assert len(found.forces) == 0


@pytest.mark.long
@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_error_bar_matches_the_scatter_of_force_due_to_noise(name):
    estimator = build_estimator(name, SKIN, depth=DEPTH)
    exact = reading(depth=DEPTH)
    noise = 0.02 * exact.region.peak
    random = np.random.default_rng(0)
    forces = []
    reported = []
    for _ in range(300):
        noisy = replace(exact, noise=noise, pressures=exact.pressures + random.normal(0, noise, len(SKIN)))
        estimate = estimator.estimate(noisy)
        forces.append(estimate.force)
        reported.append(estimate.force_error)
    assert np.std(forces) == pytest.approx(np.median(reported), rel=0.15)


def test_peak_and_mean_match_the_distribution():
    found = build_estimator("local-nnls", SKIN, depth=DEPTH).estimate(reading(depth=DEPTH))
    pressures = found.forces / SKIN.areas[found.taxels]
    assert found.peak == pytest.approx(pressures.max())
    pressed = pressures > 0
    assert found.mean == pytest.approx(np.average(pressures[pressed], weights=SKIN.areas[found.taxels][pressed]))


@pytest.mark.sampled(1)
@pytest.mark.parametrize("depth", [0.25 * PITCH, 0.5 * PITCH, PITCH])
def test_force_under_a_cover_is_estimated_with_a_sharper_peak(depth):
    given = reading(depth=depth)
    found = build_estimator("local-nnls", SKIN, depth=depth).estimate(given)
    summed = AreaSum(SKIN).estimate(given)
    assert found.force == pytest.approx(10.0, rel=0.01)
    assert (found.forces >= 0).all()
    assert found.forces.max() >= summed.forces.max()
    assert found.refused is None
    assert found.at == given.region.at
    assert found.forces.sum() == pytest.approx(found.force)


@pytest.mark.long
def test_deep_cover_gives_a_total_without_distribution():
    depth = 2 * PITCH
    exact = reading(depth=depth)
    given = reading(depth=depth, noise=0.1 * exact.region.peak)
    found = build_estimator("local-nnls", SKIN, depth=depth).estimate(given)
    assert found.refused is EstimateRefusal.RANK
    assert len(found.forces) == len(found.taxels) == 0
    assert found.force == pytest.approx(10.0, rel=0.25)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("depth", [0.25 * PITCH, 0.5 * PITCH, PITCH])
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_force_under_a_cover_is_estimated(depth, share):
    exact = reading(depth=depth)
    given = reading(depth=depth, noise=share * exact.region.peak) if share else exact
    found = build_estimator("tikhonov", SKIN, depth=depth).estimate(given)
    chance = given.noise * np.linalg.norm(SKIN.areas[given.region.taxels])
    assert found.force == pytest.approx(10.0, abs=0.1 + 3 * chance)
    assert found.force == pytest.approx(given.region.force, rel=0.06), "no worse than the sum"
    assert found.refused is None
    assert found.forces.sum() == pytest.approx(found.force)
    if share:
        assert 0 < found.misfit <= 1 + 1e-3, "explained to within the noise"
    else:
        assert found.residual < 1e-6 * exact.region.peak


def test_deconvolution_without_noise_is_least_squares():
    random = np.random.default_rng(0)
    matrix = random.normal(size=(8, 8))
    expected = random.normal(size=8)
    found = tikhonov_inverse(BlurMatrix.of(matrix), matrix @ expected, 0.0) @ matrix @ expected
    assert found == pytest.approx(expected)


def test_readings_within_noise_give_no_pressure():
    assert not tikhonov_inverse(BlurMatrix.of(np.eye(4)), np.full(4, 0.5), 1.0).any()


@pytest.mark.parametrize("noise", [0.01, 0.1, 0.5])
def test_residual_equals_the_noise(noise):
    random = np.random.default_rng(1)
    matrix = random.normal(size=(20, 12))
    readings = random.normal(size=20)
    missed = np.linalg.norm(
        matrix @ tikhonov_inverse(BlurMatrix.of(matrix), readings, noise) @ readings - readings
    ) / np.sqrt(20)
    best = np.linalg.norm(matrix @ np.linalg.lstsq(matrix, readings)[0] - readings) / np.sqrt(20)
    assert missed == pytest.approx(max(noise, best), rel=1e-6)
