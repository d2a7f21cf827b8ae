"""Stress below a loaded surface: formulas, receptive fields of buried taxels, and grids."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.mechanics import half_space_stress as module
from tactile_maps.tactile.mechanics.half_space_stress import (
    GridBlur,
    cutoff_radius,
    point_stress,
    rectangle_stress,
    square_stress,
    subsurface_field,
)
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tests.support.references import disc_stress
from tests.support.touch import arm, bar_skin, each_point_a_taxel

DEPTHS = (1e-4, 2e-3, 0.05)


@pytest.mark.parametrize("depth", DEPTHS)
def test_point_force_is_conserved_at_every_depth(depth):
    inner, _ = quad(lambda r: 2 * np.pi * r * point_stress(r, depth), 0, 20 * depth)
    outer, _ = quad(lambda r: 2 * np.pi * r * point_stress(r, depth), 20 * depth, np.inf)
    assert inner + outer == pytest.approx(1, rel=1e-8)
    assert inner == pytest.approx(disc_stress(20 * depth, depth), rel=1e-8)


@pytest.mark.parametrize("depth", [0.5e-3, 2e-3, 2e-2])
@pytest.mark.parametrize("at", [(0.0, 0.0), (0.003, 0.001), (0.002, -0.0015), (-0.01, 0.007)])
def test_rectangle_is_the_sum_of_its_points(at, depth):
    x, y = at
    a = 0.002
    b = 0.0015
    summed, _ = dblquad(lambda v, u: point_stress(np.hypot(x - u, y - v), depth), -a, a, -b, b, epsrel=1e-9)
    found = rectangle_stress(np.array(x), np.array(y), depth, sides=(np.array(2 * a), np.array(2 * b)))
    assert found == pytest.approx(summed, rel=1e-7, abs=1e-12)


def test_square_stress_equals_rectangle_stress_with_equal_sides():
    away, side = np.random.default_rng(2).uniform(0, 0.02, (2, 100))
    whole = rectangle_stress(away, np.zeros(1), 0.002, sides=(side, side))
    np.testing.assert_allclose(square_stress(away, 0.002, side=side), whole, atol=1e-14)


@pytest.mark.parametrize("share", [0.1, 0.01, 1e-4])
def test_force_beyond_the_cutoff_radius_is_the_share(share):
    assert 1 - disc_stress(cutoff_radius(0.002, share), 0.002) == pytest.approx(share, rel=1e-9)
    assert cutoff_radius(0.004, share) == pytest.approx(2 * cutoff_radius(0.002, share))


SKIN = bar_skin(200, finer=3)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("depth", [1e-4, 2e-3, 0.03])
def test_every_point_force_is_read_in_full(depth):
    for skin in (SKIN, arm().skin):
        field = subsurface_field(skin, depth)
        np.testing.assert_allclose((field.weights * skin.areas[field.taxels]).sum(axis=1), 1, rtol=1e-12)
        assert (field.weights >= 0).all()


@pytest.mark.long
def test_clusters_belong_to_one_taxel_and_span_at_most_0_3_depths():
    points = quadrature_points(SKIN)
    field = subsurface_field(SKIN, 0.02)
    assert len(field.taxels) < 0.5 * len(points.areas), "there are clusters of several points"
    for number in range(len(field.taxels)):
        members = field.cluster == number
        assert members.any()
        assert len(set(points.taxel[members])) == 1
        assert np.ptp(points.positions[members], axis=0).max() <= 0.006
    assert len(subsurface_field(SKIN, 1e-8).taxels) == len(points.areas), "a shallow taxel resolves all points"


@pytest.mark.long
def test_clusters_are_read_like_their_points():
    """The reading under a point, at a depth of four spacings, equals the sum over all points."""
    skin = each_point_a_taxel(bar_skin(finer=1))
    points = quadrature_points(skin)
    depth = 0.03
    pressures = np.zeros(len(skin))
    middle = int(np.linalg.norm(points.positions - [0.2, 0, 0.02], axis=1).argmin())
    subsurface_field(skin, depth, share=1e-3).add(pressures, np.array([middle]), np.ones(1))
    stress = point_stress(np.linalg.norm(points.positions - points.positions[middle], axis=1), depth)
    stress /= stress @ skin.areas
    np.testing.assert_allclose(pressures, stress, atol=0.03 * stress.max())


@pytest.mark.long
def test_result_does_not_depend_on_the_block_size(monkeypatch):
    whole = subsurface_field(SKIN, 2e-3)
    monkeypatch.setattr(module, "_BLOCK", 5_000)
    parts = subsurface_field(SKIN, 2e-3)
    np.testing.assert_array_equal(parts.taxels, whole.taxels)
    np.testing.assert_allclose(parts.weights, whole.weights, rtol=1e-12)


def test_cover_too_deep_for_its_skin_is_rejected(monkeypatch):
    monkeypatch.setattr(module, "_MOST_PAIRS", 10_000)
    with pytest.raises(SimulationError, match="too deep for so fine a skin") as caught:
        subsurface_field(SKIN, 0.05)
    assert "50 mm" in str(caught.value)


SHAPE = (17, 24)
PITCH = (0.0012, 0.001)
DEPTH = 0.002


@pytest.fixture(scope="module")
def pressures():
    return np.random.default_rng(0).uniform(0, 1e4, SHAPE) * (np.random.default_rng(1).random(SHAPE) < 0.2)


def summed(pressures, stress):
    """Cell by cell; ``stress`` of a cell at steps up and across from it [m]."""
    i, j = np.indices(SHAPE)
    felt = np.zeros(SHAPE)
    for row, column in np.argwhere(pressures):
        felt += pressures[row, column] * stress(PITCH[0] * np.abs(i - row), PITCH[1] * np.abs(j - column))
    return felt


def test_grid_blur_is_the_sum_over_all_cells(pressures):
    sides = np.array(PITCH[0]), np.array(PITCH[1])
    plain = summed(pressures, lambda up, across: rectangle_stress(up, across, DEPTH, sides=sides))
    np.testing.assert_allclose(GridBlur(SHAPE, PITCH, DEPTH).felt(pressures), plain, atol=1e-9 * plain.max())


def test_stress_on_a_curved_grid_uses_the_given_distances(pressures):
    def chord(up, around):
        return np.hypot(up, 2 * 0.005 * np.sin(np.minimum(around / 0.01, np.pi / 2)))

    plain = summed(pressures, lambda *steps: np.prod(PITCH) * point_stress(chord(*steps), DEPTH))
    found = GridBlur(SHAPE, PITCH, DEPTH, distance=chord).felt(pressures)
    np.testing.assert_allclose(found, plain, atol=1e-9 * plain.max())
