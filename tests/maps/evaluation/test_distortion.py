"""Distortion of faces is what the map was made with; its textures show it where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.distortion import (
    Distortion,
    TissotCircles,
    checkerboard,
    distortion,
    nested_patches,
    spaced_subset,
    stretch,
)
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.model.tactile_map import TactileMap
from tests.support.surfaces import named, sheet, skin_of


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


@pytest.mark.long
def test_stretch_is_computed_for_each_triangle():
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


def test_known_stretch_is_measured(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [2, 0.5]))
    for values, expected in ((found.angle, 4), (found.area, 1), (found.isometry, 2), (found.energy, 8.5)):
        np.testing.assert_allclose(values, expected, rtol=1e-3)
    assert not found.flipped.any()


def test_flipped_faces_are_found_and_measured_like_others(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [-1, 1]))
    assert found.flipped.all()
    np.testing.assert_allclose(found.energy, 4, rtol=1e-5)


def test_face_mapped_to_a_line_has_infinite_distortion(flat):
    found = distortion(_spoiled(flat, lambda plane: plane * [1, 0]))
    assert found.flipped.all()
    assert np.isinf([found.angle, found.isometry, found.energy]).all()
    assert found.spread(found.energy).median == np.inf


def test_median_and_percentiles_are_weighted_by_area():
    faces = Distortion(np.ones((4, 2)), np.zeros(4, bool), np.array([0.5, 0.3, 0.1, 0.1]))
    spread = faces.spread(np.array([1.0, 2.0, 3.0, 9.0]))
    assert (spread.median, spread.p95, spread.max) == (2.0, 9.0, 9.0)
    assert faces.spread(np.array([2.0, 1.0, 3.0, 9.0])).median == 2.0


def test_distribution_without_faces_raises_an_error():
    empty = Distortion(np.zeros((0, 2)), np.zeros(0, bool), np.zeros(0))
    for summarise in (lambda: empty.spread(np.zeros(0)), lambda: empty.mean_energy):
        with pytest.raises(MapError, match="without faces"):
            summarise()


def test_distortion_is_read_only(flat):
    with pytest.raises(ValueError, match="read-only"):
        distortion(flat).stretch[0] = 1


MEASURES = ("angle", "area", "isometry")


def spoiled(map_, change, *, patch=0):
    """The same map with one chart's points (k, 2) changed by hand."""
    charts = list(map_.charts)
    charts[patch] = replace(charts[patch], plane=change(charts[patch].plane))
    return TactileMap(map_.skin, tuple(charts), map_.layout)


@pytest.mark.parametrize(("measured", "factor"), [("angle", 2.0), ("area", 2.0), ("isometry", 2.0)])
def test_sheet_stretched_to_twice_its_length_has_distortion_two(flat, measured, factor):
    found = stretch(spoiled(flat, lambda plane: plane * [2.0, 1.0]), measured)
    assert found.measure == measured
    np.testing.assert_allclose(found.faces, factor, rtol=1e-4)
    assert (found.spread.median, found.spread.p95) == pytest.approx((factor, factor), rel=1e-4)


def test_shrunk_and_enlarged_areas_count_equally(flat):
    smaller = stretch(spoiled(flat, lambda plane: 0.5 * plane), "area")
    np.testing.assert_allclose(smaller.faces, 0.25, rtol=1e-4)
    assert smaller.spread.median == pytest.approx(4.0, rel=1e-4)


@pytest.mark.long
def test_values_equal_those_of_the_quality_panel(three_patches):
    quality = measure(three_patches)
    for kind, card in (("angle", quality.angle), ("area", quality.area)):
        assert stretch(three_patches, kind).spread == card


def test_every_face_is_measured(three_patches):
    count = sum(len(chart.faces) for chart in three_patches.charts)
    for kind in MEASURES:
        assert stretch(three_patches, kind).faces.shape == (count,)


def test_patch_mapped_to_a_line_has_infinite_distortion(flat):
    line = spoiled(flat, lambda plane: plane * [1.0, 0.0])
    assert np.isinf(stretch(line, "angle").spread.max)
    assert stretch(line, "area").flipped.all()


def test_patch_in_a_hole_of_another_is_not_within_it():
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    ring = [3 * circle, 2 * circle[::-1]]
    small = [0.5 * circle]
    assert nested_patches([ring, small], [np.array([2.5, 0.0]), np.zeros(2)]).tolist() == []
    assert nested_patches([ring, [0.1 * circle + [0, 2.5]]], [np.array([2.5, 0.0]), np.array([0, 2.5])]).tolist() == [
        [0, 2.5]
    ]


def test_checker_is_dark_on_alternate_squares_and_half_dark_on_lines():
    squares = np.array([[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [-0.5, 0.5], [-0.5, -0.5]])
    assert checkerboard(0.02 * squares, side=0.02, blur=1e-4).tolist() == [1, 0, 1, 0, 1]
    on_lines = np.array([[1.0, 0.3], [0.3, 2.0], [1.0, 1.0]])
    np.testing.assert_allclose(checkerboard(0.02 * on_lines, side=0.02, blur=1e-3), 0.5, atol=1e-9)
    faded = checkerboard(np.array([[0.02 + 2e-4, 0.01]]), side=0.02, blur=1e-3)
    np.testing.assert_allclose(faded, 0.3, atol=1e-9)


def test_circles_are_round_on_the_body():
    wall = sheet(40, 30, width=0.2, height=0.15)
    skin = skin_of(wall)
    circles = TissotCircles(skin.patches, radius=0.01, spacing=0.03)
    face = np.arange(len(wall.faces))
    weights = np.full((len(face), 3), 1 / 3)
    covered = circles.cover(np.zeros(len(face), int), face, weights, blur=1e-4)
    places = wall.points(face, weights)
    away = np.linalg.norm(places[:, None] - circles.middles[0], axis=2).min(axis=1)
    np.testing.assert_array_equal(covered == 1, away < 0.01 - 5e-5)
    np.testing.assert_array_equal(covered == 0, away > 0.01 + 5e-5)
    assert 0 < covered.mean() < 1
    assert circles.cover(np.array([-1]), np.array([0]), np.full((1, 3), 1 / 3), blur=1e-4).tolist() == [0.0]


def test_circles_are_not_visible_through_a_thin_wall():
    """The far side of a tube is within reach of a large circle, but looks the other way."""
    tube = named("tube")
    circles = TissotCircles(skin_of(tube).patches, radius=0.5, spacing=10.0)
    assert len(circles.middles[0]) == 1
    face = np.arange(len(tube.faces))
    covered = circles.cover(np.zeros(len(face), int), face, np.full((len(face), 3), 1 / 3), blur=1e-3)
    normal = tube.vertex_normals[np.linalg.norm(tube.vertices - circles.middles[0][0], axis=1).argmin()]
    np.testing.assert_array_equal(covered > 0, tube.face_normals @ normal > 0)
    assert 0.4 < (covered > 0).mean() < 0.6


def test_number_of_spread_points_is_as_large_as_fits():
    points = np.random.default_rng(5).uniform(0, 1, (500, 2))
    chosen = points[spaced_subset(points, 0.1)]
    apart = np.linalg.norm(chosen[:, None] - chosen, axis=2)
    assert apart[np.triu_indices(len(chosen), 1)].min() > 0.1
    assert np.linalg.norm(points[:, None] - chosen, axis=2).min(axis=1).max() <= 0.1, "no other would fit"


@pytest.mark.parametrize("size", [0.0, -1.0, np.inf, np.nan])
def test_patterns_without_a_size_are_rejected(flat, size):
    with pytest.raises(MapError, match="size of a pattern must be above zero"):
        checkerboard(np.zeros((1, 2)), side=size, blur=1e-3)
    with pytest.raises(MapError, match="size of a pattern must be above zero"):
        TissotCircles(flat.skin.patches, radius=size, spacing=0.02)
    with pytest.raises(MapError, match="size of a pattern must be above zero"):
        spaced_subset(np.zeros((3, 2)), size)
