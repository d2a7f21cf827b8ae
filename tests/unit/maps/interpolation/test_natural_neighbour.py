"""Sibson's weights are the areas taken from the Voronoi cells, found here by cutting the cells themselves."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.interpolation.natural_neighbour import natural_neighbour
from app.maps.interpolation.triangles import TaxelTriangles
from tests.numerics.taxel_fields import held, horseshoe, jittered


def _cell_area(sites, number):
    """Area of the Voronoi cell of one site within a large square: the square cut along each bisector."""
    cell, site = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), sites[number]
    for other in np.delete(sites, number, axis=0):
        side = (cell - 0.5 * (site + other)) @ (other - site)
        kept = []
        for k in range(len(cell)):
            if side[k] <= 0:
                kept.append(cell[k])
            if (side[k] <= 0) != (side[k - 1] <= 0):
                share = side[k - 1] / (side[k - 1] - side[k])
                # Between the corner before and this one; put before this one where it is kept.
                kept.insert(len(kept) - (side[k] <= 0), cell[k - 1] + share * (cell[k] - cell[k - 1]))
        cell = np.array(kept)
    x, y = (cell - site).T
    return 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()


def test_each_weight_is_the_share_of_the_area_taken():
    sites = jittered(7)
    middle = sites.mean(axis=0)
    points = middle + np.random.default_rng(3).uniform(-0.008, 0.008, (12, 2))
    before = np.array([_cell_area(sites, k) for k in range(len(sites))])
    for point, weights in zip(points, natural_neighbour(TaxelTriangles(sites), points).toarray(), strict=True):
        both = np.concatenate([sites, [point]])
        taken = before - [_cell_area(both, k) for k in range(len(sites))]
        assert taken.sum() == pytest.approx(_cell_area(both, len(sites)), rel=1e-6)
        np.testing.assert_allclose(weights, taken / taken.sum(), atol=1e-6)


def test_a_regular_grid_where_every_four_taxels_lie_on_a_circle_is_no_trouble():
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    sites = 0.01 * np.stack([x, y], axis=-1).reshape(-1, 2)
    middles = 0.01 * np.array([[2.5, 2.5], [2.5, 2.0], [2.0, 2.0]])
    weights = natural_neighbour(TaxelTriangles(sites), middles).toarray()
    square = np.isin(np.arange(36), [14, 15, 20, 21])
    np.testing.assert_allclose(weights[0], 0.25 * square, atol=1e-12)
    assert weights[1, 14] == pytest.approx(weights[1, 15])
    np.testing.assert_allclose(weights[2], np.arange(36) == 14, atol=1e-12)


def _creases(triangles, line, values):
    """Largest change of slope along a line of points, between one step and the next."""
    shown = natural_neighbour(triangles, line) @ values
    return np.abs(np.diff(shown, 2)).max() / np.linalg.norm(line[1] - line[0])


def test_the_field_has_no_creases():
    """The change of slope over a step falls with the step; at a crease it would stay."""
    triangles = TaxelTriangles(jittered())
    values = np.random.default_rng(2).random(len(triangles.sites))
    ends = triangles.sites.mean(axis=0) + [[-0.02, -0.011], [0.02, 0.013]]
    coarse, fine = (_creases(triangles, np.linspace(*ends, count), values) for count in (400, 6400))
    assert coarse > 0
    assert fine < 0.15 * coarse


@pytest.mark.parametrize("sites", [jittered(), horseshoe()], ids=["square", "horseshoe"])
def test_beside_a_border_or_a_gap_weights_stay_positive_and_exact(sites):
    triangles = TaxelTriangles(sites)
    face, side = np.nonzero(triangles.beyond < 0)
    start, end = (triangles.sites[triangles.faces[face, (side + turn) % 3]] for turn in (1, 2))
    inward = np.stack([start[:, 1] - end[:, 1], end[:, 0] - start[:, 0]], axis=1)
    for depth in (1e-12, 1e-8, 2e-7, 1e-6, 1e-3, 0.05):
        points = 0.7 * start + 0.3 * end + depth * inward
        points = points[triangles.locate(points)[0] >= 0]
        assert len(points) > 20
        weights = natural_neighbour(triangles, points)
        assert weights.data.min() > -1e-7
        np.testing.assert_allclose(weights @ triangles.sites, points, atol=1e-9)


def test_at_and_around_a_taxel_the_walk_ends_and_the_taxel_rules():
    triangles = TaxelTriangles(jittered())
    site = 40
    for away in (0, 1e-16, 1e-12, 1e-9, 1e-8, 1e-6):
        around = triangles.sites[site] + away * np.array([[1, 0], [0, 1], [-1, 1], [-0.3, -1]])
        weights = natural_neighbour(triangles, around)
        assert weights[:, [site]].toarray().min() > 1 - 1e3 * away - 1e-9


def test_laws_hold_at_any_size():
    for size in (1e-6, 1e6):
        triangles = TaxelTriangles(size * jittered())
        points = held(triangles)
        weights = natural_neighbour(triangles, points)
        np.testing.assert_allclose(weights @ triangles.sites, points, atol=1e-13 * size)


def _needles(kind, generator):
    """(40, 2) taxels nearly in rows, nearly in pairs, nearly on one circle, or in a very thin strip."""
    places = generator.random((40, 2))
    if kind == "rows":
        return np.round(6 * places) / 6 + 1e-9 * generator.normal(size=(40, 2))
    if kind == "pairs":
        return np.concatenate([places[:20], places[:20] + 1e-8 * generator.normal(size=(20, 2))])
    if kind == "circle":
        turn = 2 * np.pi * places[:, 0]
        return np.stack([np.cos(turn), np.sin(turn)], axis=1) * np.minimum(np.arange(40), 1)[:, None]
    return places * [1, 1e-6]


@pytest.mark.parametrize("kind", ["rows", "pairs", "circle", "strip"])
def test_among_needles_the_walk_ends_and_weights_are_sound(kind, monkeypatch):
    monkeypatch.setattr("app.maps.interpolation.triangles.LONGEST_SIDE", 1e9)
    generator, asked = np.random.default_rng(0), 0
    for _ in range(25):
        sites = _needles(kind, generator)
        triangles, size = TaxelTriangles(sites), np.ptp(sites, axis=0)
        around = 10.0 ** generator.uniform(-12, -1, (300, 1)) * generator.normal(size=(300, 2))
        points = sites[generator.integers(0, 40, 300)] + size * around
        points = points[triangles.locate(points)[0] >= 0]
        asked += len(points)
        weights = natural_neighbour(triangles, points)
        np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)
        assert weights.data.min(initial=0.0) > -2e-6
        np.testing.assert_allclose((weights @ sites - points) / size, 0, atol=1e-5)
    assert (asked > 1000) == (kind != "strip")
