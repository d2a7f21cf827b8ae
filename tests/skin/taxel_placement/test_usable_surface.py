"""Surface usable for skin: visible from outside, clear of other links, in clean components."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.taxel_placement import usable_surface
from tactile_maps.skin.taxel_placement.usable_surface import (
    sample_surface,
    usable_components,
    vertices_clear_of,
    visible_from_outside,
)
from tests.hard_cases.meshes import HARD_MESHES

VOXEL = 0.008


def test_single_ball_is_visible_everywhere():
    ball = wrap_mesh(HARD_MESHES["sphere"], thickness=0.01, voxel=VOXEL).surface
    assert visible_from_outside(ball, [], voxel=VOXEL).all()


def test_middle_of_a_long_tube_is_visible_only_outside():
    tube = Mesh(HARD_MESHES["open tube"].vertices * [0.6, 0.6, 1], HARD_MESHES["open tube"].faces)
    surface = wrap_mesh(tube, thickness=0.004, voxel=0.006).surface
    seen = visible_from_outside(surface, [], voxel=0.006)
    radius = np.linalg.norm(surface.vertices[:, :2], axis=1)
    middle = np.abs(surface.vertices[:, 2] - 0.15) < 0.03
    inside = middle & (radius < 0.028)
    outside = middle & (radius > 0.032)
    assert inside.any()
    assert outside.any()
    assert not seen[inside].any()
    assert seen[outside].all()


@pytest.mark.long
def test_vertices_hidden_by_another_link_are_not_visible():
    ball = wrap_mesh(HARD_MESHES["sphere"], thickness=0.01, voxel=VOXEL).surface
    shell = wrap_mesh(HARD_MESHES["sphere"], thickness=0.1, voxel=VOXEL).surface
    half = Mesh(shell.vertices, shell.faces[shell.face_centres[:, 2] > 0])
    seen = visible_from_outside(ball, [sample_surface(half, VOXEL)], voxel=VOXEL)
    assert not seen[ball.vertices[:, 2] > 0.1].any()
    assert seen[ball.vertices[:, 2] < -0.03].all()


BALL = wrap_mesh(HARD_MESHES["sphere"], thickness=0.01, voxel=0.008).surface
HEIGHT = BALL.vertices[:, 2]


def test_clear_vertices_have_the_required_distance():
    post = Mesh(HARD_MESHES["cube"].vertices * 0.2 + [0, 0, 0.13], HARD_MESHES["cube"].faces)
    clear = vertices_clear_of(BALL, [(Pose.identity(), post)], distance=0.03)
    assert 0 < (~clear).sum() < len(clear) / 4
    assert HEIGHT[~clear].min() > 0.08


def test_vertices_deep_inside_another_link_are_not_clear():
    around = Mesh(HARD_MESHES["cube"].vertices * 10, HARD_MESHES["cube"].faces)
    assert not vertices_clear_of(BALL, [(Pose.identity(), around)], distance=0.001).any()


def test_belt_is_one_tube_with_smooth_borders():
    usable = np.abs(HEIGHT) < 0.05
    (belt,) = usable_components(BALL, usable, smallest=0.0, largest_hole=0.0)
    assert belt.connectivity.euler_characteristic == 0
    assert len(belt.connectivity.boundary_loops) == 2
    border = belt.vertices[np.unique(belt.connectivity.boundary_edges)]
    assert np.abs(border[:, 2]).std() < 0.003


def test_pieces_are_sorted_by_size_and_small_ones_dropped():
    usable = (HEIGHT > 0.06) | (HEIGHT < 0.0)
    both = usable_components(BALL, usable, smallest=0.0, largest_hole=0.0)
    assert len(both) == 2
    assert both[0].area > both[1].area
    (only,) = usable_components(BALL, usable, smallest=1.5 * both[1].area, largest_hole=0.0)
    assert only.area == both[0].area


def test_small_holes_are_filled_and_large_ones_kept():
    usable = HEIGHT < 0.105
    hole = BALL.face_areas[~usable[BALL.faces].all(axis=1)].sum()
    assert hole > 0
    (filled,) = usable_components(BALL, usable, smallest=0.0, largest_hole=1.1 * hole)
    (holed,) = usable_components(BALL, usable, smallest=0.0, largest_hole=0.5 * hole)
    assert filled.connectivity.euler_characteristic == 2
    assert holed.connectivity.euler_characteristic == 1


@pytest.mark.sampled(2)
@pytest.mark.parametrize("seed", range(5))
def test_ragged_selection_gives_simple_border_loops(seed):
    usable = np.random.default_rng(seed).random(len(BALL.vertices)) < 0.9
    pieces = usable_components(BALL, usable, smallest=0.0, largest_hole=0.0)
    assert pieces
    for piece in pieces:
        assert not len(piece.connectivity.bow_tie_vertices)
        _ = piece.connectivity.boundary_loops  # raises where they are not simple


def test_unusable_surface_gives_no_pieces():
    assert usable_components(BALL, np.zeros(len(HEIGHT), dtype=bool), smallest=0.0, largest_hole=0.0) == []


@pytest.mark.parametrize("most", [0, usable_surface._MOST_VOXELS], ids=["sorted", "by a table"])
def test_first_point_of_each_voxel_is_kept(monkeypatch, most):
    monkeypatch.setattr(usable_surface, "_MOST_VOXELS", most)
    points = np.random.default_rng(0).uniform(-1, 1, (3000, 3))
    found = usable_surface._one_point_per_voxel(points, 0.25)
    cells = np.floor((points - points.min(axis=0)) / 0.25).astype(int)
    first = {}
    for number, cell in enumerate(map(tuple, cells.tolist())):
        first.setdefault(cell, number)
    assert len(first) < len(points) / 2
    np.testing.assert_array_equal(found, points[[first[cell] for cell in sorted(first)]])
