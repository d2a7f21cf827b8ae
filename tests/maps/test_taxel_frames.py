"""Frames of taxels on the body, and their directions on the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.model.taxel_frames import map_directions, taxel_frames
from tactile_maps.skin.model.skin import Skin
from tests.support.surfaces import frustum, sheet, skin_of

NO_SEAMS = np.zeros((0, 2), dtype=np.int64)


def plane_map(angle=0.0, *, mirrored=False, stretch=(1.0, 1.0), tangents=None):
    """Return a map of a flat skin whose chart is its own x and y."""
    skin = skin_of(sheet(6, 5), taxels=12)
    patch = skin.patches[0]
    if tangents is not None:
        skin = Skin((replace(patch, taxels=replace(patch.taxels, axes=np.full(12, 3), tangents=tangents)),))
    plane = patch.surface.vertices[:, :2] * stretch
    chart = Chart(patch.surface.faces, plane, np.arange(len(plane)), NO_SEAMS, "by hand")
    return TactileMap(skin, (chart,), MapLayout((Placement(angle, (0.3, -0.2), mirrored=mirrored, scale=2.0),)))


def stated(vector, count=12):
    return np.tile(np.asarray(vector) / np.linalg.norm(vector), (count, 1))


def test_frames_are_right_handed_and_orthonormal(three_patches):
    frames = taxel_frames(three_patches)
    normals = np.concatenate([patch.taxels.normals for patch in three_patches.skin.patches])
    np.testing.assert_allclose(frames @ np.swapaxes(frames, 1, 2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(frames), 1, atol=1e-12)
    np.testing.assert_allclose(frames[:, 2], normals, atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_default_tangent_on_a_plane_is_the_map_x_axis_of_the_rotated_patch(angle):
    frames = taxel_frames(plane_map(angle))
    np.testing.assert_allclose(frames[:, 0], stated([np.cos(angle), -np.sin(angle), 0]), atol=1e-12)
    np.testing.assert_allclose(frames[:, 1], stated([np.sin(angle), np.cos(angle), 0]), atol=1e-12)


def test_default_tangent_on_a_tube_is_where_its_triangle_moves_along_map_x():
    map_ = build_map(skin_of(frustum(), taxels=60))
    frames = taxel_frames(map_)
    taxels = map_.skin.patches[0].taxels
    for taxel in range(0, 60, 7):
        at = map_.skin.taxel_point(taxel)
        step = map_.to_map(at) + np.array([1e-7, 0.0])
        corners = map_.uv[0][map_.charts[0].faces[at.face]]
        weights = np.linalg.solve(np.vstack([corners.T, np.ones(3)]), [*step, 1.0])
        moved = map_.skin.patches[0].surface.point(at.face, tuple(weights)) - taxels.positions[taxel]
        moved -= moved @ taxels.normals[taxel] * taxels.normals[taxel]
        np.testing.assert_allclose(frames[taxel, 0], moved / np.linalg.norm(moved), atol=1e-6)


def test_directions_of_default_tangents_point_along_map_x(three_patches):
    directions = map_directions(three_patches)
    assert (directions[:, 0, 0] > 0).all()
    np.testing.assert_allclose(directions[:, 1, 0], 0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(directions), 1, atol=1e-9)


def test_stated_tangent_is_kept_and_its_direction_on_the_map_rotates_with_the_patch():
    map_ = plane_map(0.4, tangents=stated([1.0, 1.0, 0.0]))
    np.testing.assert_allclose(taxel_frames(map_)[:, 0], stated([1, 1, 0]), atol=1e-12)
    angle = np.pi / 4 + 0.4
    expected = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    np.testing.assert_allclose(map_directions(map_), np.broadcast_to(expected, (12, 2, 2)), atol=1e-12)


def test_frames_of_a_mirrored_patch_are_right_handed_and_its_second_direction_is_reversed():
    map_ = plane_map(mirrored=True)
    np.testing.assert_allclose(taxel_frames(map_)[:, 0], stated([-1, 0, 0]), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(taxel_frames(map_)), 1, atol=1e-12)
    np.testing.assert_allclose(map_directions(map_), np.broadcast_to(np.diag([1.0, -1.0]), (12, 2, 2)), atol=1e-12)


def test_direction_is_that_of_the_map_where_it_stretches():
    map_ = plane_map(stretch=(2.0, 0.5), tangents=stated([1.0, 1.0, 0.0]))
    direction = map_directions(map_)[:, :, 0]
    np.testing.assert_allclose(direction[:, 1] / direction[:, 0], 0.25, atol=1e-12)


def test_row_without_stated_tangent_follows_the_map():
    tangents = stated([1.0, 1.0, 0.0])
    tangents[[0, 5]] = np.nan
    frames = taxel_frames(plane_map(tangents=tangents))
    np.testing.assert_allclose(frames[[0, 5], 0], stated([1, 0, 0], 2), atol=1e-12)
    np.testing.assert_allclose(frames[1:5, 0], stated([1, 1, 0], 4), atol=1e-12)


def test_degenerate_triangles_have_frames_from_the_axes_of_the_link():
    map_ = plane_map(stretch=(1.0, 0.0))
    np.testing.assert_allclose(taxel_frames(map_)[:, 0], stated([1, 0, 0]), atol=1e-12)
    np.testing.assert_array_equal(map_directions(map_), np.broadcast_to(np.eye(2), (12, 2, 2)))
    skin = map_.skin
    thin = Mesh(skin.patches[0].surface.vertices * [0.0, 1.0, 1.0], skin.patches[0].surface.faces)
    upright = Skin((replace(skin.patches[0], surface=thin),))
    regular = TactileMap(upright, plane_map().charts, map_.layout)
    np.testing.assert_allclose(taxel_frames(regular)[:, 0], stated([1, 0, 0]), atol=1e-12)
    np.testing.assert_array_equal(map_directions(regular), np.broadcast_to(np.eye(2), (12, 2, 2)))


def test_frames_are_computed_once_for_a_map(three_patches):
    assert taxel_frames(three_patches) is taxel_frames(three_patches)
    assert not taxel_frames(three_patches).flags.writeable


def test_map_without_patches_has_no_frames():
    empty = TactileMap(Skin(()), (), MapLayout(()))
    assert taxel_frames(empty).shape == (0, 3, 3)
    assert map_directions(empty).shape == (0, 2, 2)
