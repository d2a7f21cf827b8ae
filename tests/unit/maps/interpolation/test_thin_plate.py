"""Local thin plates: the whole plate where one plate holds all, through every reading, and exact where taxels allow."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import RBFInterpolator

from app.maps.interpolation.barycentric import barycentric
from app.maps.interpolation.thin_plate import STENCIL, thin_plate
from app.maps.interpolation.triangles import TaxelTriangles
from tests.numerics.taxel_fields import held, horseshoe, jittered


def test_with_few_taxels_it_is_scipys_thin_plate_spline():
    sites = jittered(3, jitter=0.15)
    triangles, values = TaxelTriangles(sites), np.random.default_rng(2).random(9)
    points = held(triangles)
    assert len(sites) <= STENCIL
    assert (np.diff(thin_plate(triangles, points).indptr) == 9).all(), "each plate holds all"
    expected = RBFInterpolator(sites, values, kernel="thin_plate_spline", degree=1)(points)
    np.testing.assert_allclose(thin_plate(triangles, points) @ values, expected, atol=1e-10)


def test_with_many_taxels_it_is_close_to_it():
    triangles = TaxelTriangles(jittered(12))
    values = np.sin(60 * triangles.sites[:, 0]) * np.cos(50 * triangles.sites[:, 1])
    points = held(triangles)
    whole = RBFInterpolator(triangles.sites, values, kernel="thin_plate_spline", degree=1)(points)
    apart = np.abs(thin_plate(triangles, points) @ values - whole)
    linear = np.abs(barycentric(triangles, points) @ values - whole)
    assert np.sqrt((apart**2).mean()) < 0.25 * np.sqrt((linear**2).mean())


def test_no_plate_reaches_over_a_gap():
    triangles = TaxelTriangles(horseshoe())
    points = held(triangles)
    lower = points[(points[:, 0] > 0.09) & (points[:, 1] < 0.03)]
    assert len(lower) > 50
    asked = triangles.sites[np.unique(thin_plate(triangles, lower).indices)]
    assert asked[:, 1].max() < 0.045


def test_taxels_nearly_in_one_line_or_in_one_place_fall_back_to_linear():
    line = np.stack([0.01 * np.arange(12), 5e-6 * (np.arange(12) % 2)], axis=1)
    twins = np.concatenate([jittered(5), jittered(5)[12:13] + 1e-9])
    for sites in (line, twins):
        triangles = TaxelTriangles(sites)
        assert len(triangles.faces) > 5
        points = triangles.sites[triangles.faces].mean(axis=1)
        weights = thin_plate(triangles, points)
        np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-9)
        assert np.abs(weights.data).max() < 2


def test_laws_hold_at_any_size():
    for size in (1e-6, 1e6):
        triangles = TaxelTriangles(size * jittered())
        points = held(triangles)
        np.testing.assert_allclose(thin_plate(triangles, points) @ triangles.sites, points, atol=1e-12 * size)


def test_a_regular_grid_is_no_trouble():
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    triangles = TaxelTriangles(0.01 * np.stack([x, y], axis=-1).reshape(-1, 2))
    points = held(triangles)
    np.testing.assert_allclose(thin_plate(triangles, points) @ triangles.sites, points, atol=1e-12)
    np.testing.assert_allclose(thin_plate(triangles, triangles.sites).toarray(), np.eye(36), atol=1e-12)
