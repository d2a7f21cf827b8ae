"""The lattice: perfect where the surface allows it, the count always exact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from app.geometry.subdivide import subdivide
from app.skin.place import place_taxels
from app.skin.placing.lattice import carried_lattice, place_lattice
from tests.numerics.map_surfaces import frustum, sheet

PITCH = 0.008


def _fine(surface):
    return subdivide(surface, longest=PITCH / 2.5).mesh


def _everywhere(surface):
    return np.ones(len(surface.faces), dtype=bool)


def test_on_a_plane_it_is_the_lattice():
    flat = _fine(sheet(width=0.2, height=0.15))
    points, faces = carried_lattice(flat, PITCH, np.random.default_rng(3), _everywhere(flat))
    assert len(points) == pytest.approx(0.03 / (PITCH**2 * np.sqrt(3) / 2), rel=0.05)
    inner = (points[:, :2] > 0.02).all(axis=1) & (points[:, :2] < [0.18, 0.13]).all(axis=1)
    away = cKDTree(points).query(points[inner], k=7)[0][:, 1:]
    assert inner.sum() > 200
    assert away == pytest.approx(PITCH, rel=1e-6)
    assert len(faces) == len(points)


def test_on_a_tube_it_tears_once():
    tube = _fine(frustum(around=72))
    points, _ = carried_lattice(tube, PITCH, np.random.default_rng(0), _everywhere(tube))
    away = cKDTree(points).query(points, k=2)[0][:, 1]
    assert (np.abs(away / PITCH - 1) < 0.03).mean() > 0.8
    assert away.min() > 0.7 * PITCH


@pytest.mark.parametrize("shape", [frustum(around=72), sheet(shape=lambda x, y: 3 * x * y)], ids=["tube", "saddle"])
def test_nine_of_ten_have_six_neighbours_and_half_of_those_placed_evenly(shape):
    surface = _fine(shape)
    count = round(surface.area / (PITCH**2 * np.sqrt(3) / 2))
    lattice = place_lattice(surface, count, PITCH, allowed=_everywhere(surface), seed=1)
    inner = _from_border(surface, lattice.positions) > 1.5 * PITCH

    def six(taxels):
        inside = _from_border(surface, taxels.positions) > 1.5 * PITCH
        return (np.bincount(taxels.neighbours.ravel(), minlength=count)[inside] == 6).mean()

    assert len(lattice) == count
    assert inner.sum() > 50
    assert six(lattice) > 0.85
    assert six(place_taxels(surface, count)) < 0.75
    away = cKDTree(lattice.positions).query(lattice.positions[inner], k=2)[0][:, 1] / PITCH
    assert away.std() < 0.07
    assert np.median(away) == pytest.approx(0.93, abs=0.05)


def _from_border(surface, points):
    ends = surface.vertices[surface.edges]
    table = np.bincount(np.searchsorted(_keys(surface, surface.edges), _keys(surface, _sides(surface))))
    return cKDTree(ends[table == 1].reshape(-1, 3)).query(points)[0]


def _sides(surface):
    return np.sort(surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)


def _keys(surface, pairs):
    return pairs[:, 0] * len(surface.vertices) + pairs[:, 1]
