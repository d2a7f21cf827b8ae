"""Mapping from body to map and back is exact."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap, back_project


def _places(map_, count=400, seed=0):
    rng = np.random.default_rng(seed)
    patch = rng.integers(len(map_.charts), size=count)
    face = np.array([rng.integers(len(map_.charts[k].faces)) for k in patch])
    return patch, face, rng.dirichlet([1, 1, 1], count)


def _on_body(map_, patch, face, weights):
    return np.stack([map_.skin.patches[p].surface.point(f, w) for p, f, w in zip(patch, face, weights, strict=True)])


def test_round_trip_is_exact(three_patches):
    places = _places(three_patches)
    back = three_patches.to_body_many(three_patches.to_map_many(*places))
    np.testing.assert_array_equal(back[0], places[0])
    np.testing.assert_allclose(_on_body(three_patches, *back), _on_body(three_patches, *places), atol=1e-12)


def test_single_and_batched_queries_agree(three_patches):
    patch, face, weights = _places(three_patches, 20)
    points = three_patches.to_map_many(patch, face, weights)
    for k in range(20):
        at = SurfacePoint(int(patch[k]), int(face[k]), tuple(weights[k]))
        np.testing.assert_allclose(three_patches.to_map(at), points[k], atol=1e-15)
        back = three_patches.to_body(points[k])
        assert (back.patch, back.face) == (at.patch, at.face)


def test_every_vertex_of_the_body_has_a_map_position(three_patches):
    for number, uv in enumerate(three_patches.uv):
        patch, face, weights = three_patches.to_body_many(uv)
        assert (patch == number).all()
        surface = three_patches.skin.patches[number].surface
        expected = surface.vertices[three_patches.charts[number].vertex_of]
        np.testing.assert_allclose(surface.points(face, weights), expected, atol=1e-9)


def test_points_outside_all_patches_have_no_body_point(three_patches):
    low, high = three_patches.bounds
    assert three_patches.to_body(low - 0.01) is None
    assert three_patches.to_body(high + 0.01) is None
    assert three_patches.to_body(np.array([np.nan, 0.0])) is None
    gaps = np.random.default_rng(0).uniform(low, high, (500, 2))
    assert (three_patches.to_body_many(gaps)[0] == -1).any(), "there is free space between patches"


def test_taxels_are_mapped_with_their_faces(three_patches):
    skin = three_patches.skin
    for taxel in range(0, len(skin), 7):
        at = skin.taxel_point(taxel)
        np.testing.assert_allclose(three_patches.to_map(at), three_patches.taxel_points[taxel], atol=1e-15)
        np.testing.assert_allclose(
            skin.position(at), skin.patches[at.patch].taxels.positions[taxel - skin.first[at.patch]], atol=1e-12
        )


def test_outlines_close_around_the_area_of_their_patch(three_patches):
    for patch, loop in zip(three_patches.skin.patches, three_patches.outlines, strict=True):
        after = np.roll(loop, -1, axis=0)
        area = 0.5 * (loop[:, 0] * after[:, 1] - loop[:, 1] * after[:, 0]).sum()
        assert area == pytest.approx(patch.surface.area, rel=1e-9)


def test_each_seam_is_on_the_border_twice(three_patches):
    tube, saddle, _ = three_patches.seams
    assert len(tube) == 2 * len(three_patches.charts[0].seams) > 0
    assert len(saddle) == 0
    border = {tuple(point) for point in three_patches.outlines[0]}
    assert {tuple(point) for point in tube.reshape(-1, 2)} <= border


def test_bounds_contain_all_patches(three_patches):
    low, high = three_patches.bounds
    assert (three_patches.taxel_points >= low).all()
    assert (three_patches.taxel_points <= high).all()


def test_mirrored_and_rotated_patch_is_inverted(three_patches):
    places = (Placement(1.0, (2.0, 0.0), mirrored=True), *three_patches.layout.placements[1:])
    moved = TactileMap(three_patches.skin, three_patches.charts, MapLayout(places))
    asked = _places(moved, 100)
    back = moved.to_body_many(moved.to_map_many(*asked))
    np.testing.assert_allclose(_on_body(moved, *back), _on_body(moved, *asked), atol=1e-12)


def test_moving_patches_reuses_expensive_data(three_patches):
    assert three_patches.to_body(three_patches.taxel_points[0]) is not None
    known = [chart.locator for chart in three_patches.charts]
    moved = TactileMap(three_patches.skin, three_patches.charts, MapLayout((Placement(scale=0.5),) * 3))
    assert moved.to_body(moved.taxel_points[0]) is not None
    assert [chart.locator for chart in moved.charts] == known


def test_point_on_overlapping_patches_belongs_to_one_of_them(three_patches):
    heap = TactileMap(three_patches.skin, three_patches.charts, MapLayout((Placement(),) * 3))
    asked = _places(heap, 100)
    points = heap.to_map_many(*asked)
    np.testing.assert_allclose(heap.to_map_many(*heap.to_body_many(points)), points, atol=1e-12)


def test_inconsistent_skin_charts_and_layout_are_rejected(three_patches):
    skin = three_patches.skin
    charts = three_patches.charts
    layout = three_patches.layout
    with pytest.raises(MapError, match="number of patches"):
        TactileMap(skin, charts[:2], layout)
    with pytest.raises(MapError, match="surface's faces"):
        TactileMap(skin, charts[::-1], layout)


def test_map_point_is_converted_to_its_link(three_patches):
    skin = three_patches.skin
    for taxel in range(0, len(skin), 7):
        place = back_project(three_patches, three_patches.taxel_points[taxel])
        at = skin.taxel_point(taxel)
        assert place.link == skin.link(at)
        np.testing.assert_allclose(place.link_position, skin.position(at), atol=1e-9)
        assert np.linalg.norm(place.link_normal) == pytest.approx(1.0)


def test_point_off_the_map_is_rejected(three_patches):
    with pytest.raises(MapError, match="outside all patches.*taxel_points"):
        back_project(three_patches, three_patches.bounds[1] + 1.0)
