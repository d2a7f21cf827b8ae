"""Distortion face by face and taxel by taxel: known stretches give known numbers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.maps.build import build_map
from app.maps.distortion import Distortion, distortion, taxel_cells
from app.maps.tactile_map import TactileMap
from tests.numerics.map_surfaces import named, sheet, skin_of


@pytest.fixture(scope="module")
def flat():
    return build_map(skin_of(sheet(24, 16), taxels=30))


def _spoiled(map_, change):
    return TactileMap(map_.skin, (replace(map_.charts[0], plane=change(map_.charts[0].plane)),), map_.layout)


def _by_triangles(map_):
    """Singular values of each face's map, from 3-D edges by a plain least-squares fit and numpy's own SVD."""
    values = []
    for patch, chart in zip(map_.skin.patches, map_.charts, strict=True):
        for face in chart.faces:
            body = np.diff(patch.surface.vertices[chart.vertex_of[face]], axis=0)
            basis = np.linalg.qr(body.T)[0]
            flat = np.diff(chart.plane[face], axis=0)
            values.append(np.linalg.svd(np.linalg.solve(body @ basis, flat), compute_uv=False))
    return np.array(values)


def test_stretch_is_that_of_each_triangle():
    map_ = build_map(skin_of(named("hemisphere"), named("saddle"), taxels=20))
    found = distortion(map_)
    expected = _by_triangles(map_)
    np.testing.assert_allclose(found.stretch, expected, rtol=1e-9)
    np.testing.assert_allclose(
        found.areas, np.concatenate([p.surface.face_areas for p in map_.skin.patches]), rtol=1e-9
    )
    s1, s2 = expected.T
    np.testing.assert_allclose(found.angle, s1 / s2, rtol=1e-9)
    np.testing.assert_allclose(found.area, s1 * s2, rtol=1e-9)
    np.testing.assert_allclose(found.isometry, np.maximum(s1, 1 / s2), rtol=1e-9)
    np.testing.assert_allclose(found.energy, s1**2 + s2**2 + s1**-2 + s2**-2, rtol=1e-9)
    mean = (found.energy * found.areas).sum() / found.areas.sum()
    assert found.mean_energy == pytest.approx(mean)
    assert mean > 4.01


def test_a_known_stretch_is_told(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [2, 0.5]))
    for values, expected in ((found.angle, 4), (found.area, 1), (found.isometry, 2), (found.energy, 8.5)):
        np.testing.assert_allclose(values, expected, rtol=1e-3)
    assert not found.flipped.any()


def test_turned_faces_are_found_and_measured_like_others(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [-1, 1]))
    assert found.flipped.all()
    np.testing.assert_allclose(found.energy, 4, rtol=1e-5)


def test_a_face_drawn_as_a_line_is_infinitely_distorted(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [1, 0]))
    assert found.flipped.all()
    assert np.isinf([found.angle, found.isometry, found.energy]).all()
    assert found.spread(found.energy).median == np.inf


def test_the_middle_and_the_tail_are_by_area():
    faces = Distortion(np.ones((4, 2)), np.zeros(4, bool), np.array([0.5, 0.3, 0.1, 0.1]))
    spread = faces.spread(np.array([1.0, 2.0, 3.0, 9.0]))
    assert (spread.median, spread.p95, spread.max) == (2.0, 9.0, 9.0)
    assert faces.spread(np.array([2.0, 1.0, 3.0, 9.0])).median == 2.0


def test_nothing_has_no_spread():
    empty = Distortion(np.zeros((0, 2)), np.zeros(0, bool), np.zeros(0))
    assert np.isnan([*vars(empty.spread(np.zeros(0))).values(), empty.mean_energy]).all()


def test_a_taxels_distortion_is_the_mean_over_its_cell():
    map_ = build_map(skin_of(named("saddle"), named("hemisphere"), taxels=15))
    skin, found = map_.skin, distortion(map_)
    cells = taxel_cells(skin)
    assert cells.shape == (30, len(found.areas))
    np.testing.assert_allclose(cells.sum(axis=1), 1, rtol=1e-12)
    # Cells are whole faces on a covered skin, so that sums over cells are sums over the skin.
    np.testing.assert_allclose(cells.T @ skin.areas, found.areas, rtol=1e-9)
    assert skin.areas @ (cells @ found.energy) == pytest.approx(found.areas @ found.energy)
    second = np.flatnonzero(cells[20].toarray()[0])
    assert second.min() >= len(map_.charts[0].faces)


def test_values_cannot_be_changed(flat):
    with pytest.raises(ValueError, match="read-only"):
        distortion(flat).stretch[0] = 1
