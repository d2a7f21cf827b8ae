"""Patterns carried over a surface: steps and directions, the hexagonal lattice, triangular modules."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.distance import pdist

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.skin.taxel_placement.patterns import (
    BOARD_MARGIN,
    MODULE_PADS,
    TILE_SIDE,
    grow_lattice,
    place_lattice,
    place_modules,
    step_along_surface,
)
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.surfaces import cap, frustum, sheet


def test_step_over_the_border_is_rejected():
    flat = sheet()
    starts = np.tile(flat.vertices[flat.faces[0]].mean(axis=0), (2, 1))
    faces = np.zeros(2, dtype=int)
    steps = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    assert step_along_surface(flat, ClosestPoint(flat), starts, faces, steps, 0.02)[2].tolist() == [False, True]


def test_step_through_a_thin_wall_is_rejected():
    tube = frustum(0.004, 0.004, length=0.1)
    start = tube.vertices[tube.faces[700]].mean(axis=0)[None]
    across = -(start * [[1, 1, 0]]) / np.linalg.norm(start[0, :2])
    assert not step_along_surface(tube, ClosestPoint(tube), start, np.array([700]), across, np.array([0.008]))[2][0]


LATTICE_PITCH = 0.008


def _fine(surface):
    return subdivide(surface, longest=LATTICE_PITCH / 2.5).mesh


def _everywhere(surface):
    return np.ones(len(surface.faces), dtype=bool)


def test_pattern_on_a_plane_is_the_lattice():
    flat = _fine(sheet(width=0.2, height=0.15))
    points, faces = grow_lattice(flat, LATTICE_PITCH, np.random.default_rng(3), _everywhere(flat))
    assert len(points) == pytest.approx(0.03 / (LATTICE_PITCH**2 * np.sqrt(3) / 2), rel=0.05)
    inner = (points[:, :2] > 0.02).all(axis=1) & (points[:, :2] < [0.18, 0.13]).all(axis=1)
    away = cKDTree(points).query(points[inner], k=7)[0][:, 1:]
    assert inner.sum() > 200
    assert away == pytest.approx(LATTICE_PITCH, rel=1e-6)
    assert len(faces) == len(points)


def test_pattern_on_a_tube_has_one_seam():
    tube = _fine(frustum(around=72))
    points, _ = grow_lattice(tube, LATTICE_PITCH, np.random.default_rng(0), _everywhere(tube))
    away = cKDTree(points).query(points, k=2)[0][:, 1]
    assert (np.abs(away / LATTICE_PITCH - 1) < 0.03).mean() > 0.8
    assert away.min() > 0.7 * LATTICE_PITCH


@pytest.mark.sampled(1)
@pytest.mark.parametrize("shape", [frustum(around=72), sheet(shape=lambda x, y: 3 * x * y)], ids=["tube", "saddle"])
def test_hexagonal_pattern_has_more_taxels_with_six_neighbours_than_even_placement(shape):
    surface = _fine(shape)
    count = round(surface.area / (LATTICE_PITCH**2 * np.sqrt(3) / 2))
    lattice = place_lattice(surface, count, LATTICE_PITCH, allowed=_everywhere(surface), seed=1)
    inner = _from_border(surface, lattice.positions) > 1.5 * LATTICE_PITCH

    def six(taxels):
        inside = _from_border(surface, taxels.positions) > 1.5 * LATTICE_PITCH
        return (np.bincount(taxels.neighbours.ravel(), minlength=count)[inside] == 6).mean()

    assert len(lattice) == count
    assert inner.sum() > 50
    assert six(lattice) > 0.85
    assert six(place_evenly(surface, count)) < 0.75
    away = cKDTree(lattice.positions).query(lattice.positions[inner], k=2)[0][:, 1] / LATTICE_PITCH
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


PAD_PITCH = 0.0065


def _placed(surface, **more):
    surface = subdivide(surface, longest=PAD_PITCH / 2.5).mesh
    allowed = more.get("allowed", lambda centres: np.ones(len(centres), bool))(surface.face_centres)
    return surface, place_modules(surface, PAD_PITCH, allowed=allowed, seed=more.get("seed", 0))


def test_module_pattern_matches_icub():
    """The pads of iCubSkinGui's ``triangle_10pad``, in its units of about a fortieth of a millimetre."""
    x = np.array([257.2, 385.83, 128.62, 0, -128.62, -385.83, -257.2, -128.62, 0, 128.62])
    y = np.array([0, -222.83, -222.83, 0, -222.83, -222.83, 0, 222.83, 445.54, 222.83])
    assert np.abs(257.24 * MODULE_PADS - np.stack([x, y], axis=1)).max() < 0.3
    assert sorted(pdist(MODULE_PADS))[:18] == pytest.approx([1.0] * 18)


@pytest.mark.parametrize(
    "plane",
    [sheet(4, 3, width=0.045, height=0.027), pytest.param(sheet(width=0.3, height=0.2), marks=pytest.mark.long)],
    ids=["two modules", "hundred modules"],
)
def test_modules_on_a_plane_keep_their_shape_and_do_not_overlap(plane):
    surface, taxels = _placed(plane)
    modules = taxels.positions.reshape(-1, 10, 3)
    tiles = surface.area / (np.sqrt(3) / 4 * (TILE_SIDE * PAD_PITCH) ** 2)
    assert 0.6 * tiles < len(modules) <= tiles
    for module in modules:
        assert pdist(module) == pytest.approx(PAD_PITCH * pdist(MODULE_PADS), abs=1e-9)
    apart = 2 * BOARD_MARGIN * PAD_PITCH
    for k, module in enumerate(modules):
        hull = ConvexHull(module[:, :2]).equations
        others = np.delete(modules, k, axis=0).reshape(-1, 3)[:, :2]
        assert (others @ hull[:, :2].T + hull[:, 2]).max(axis=1).min() > 0.9 * apart
    assert (taxels.positions[:, :2] > 0.4 * BOARD_MARGIN * PAD_PITCH).all()


@pytest.mark.long
@pytest.mark.parametrize("surface", [frustum(around=72, length=0.15), cap(1.2, radius=0.1)], ids=["tube", "cap"])
def test_pads_on_a_curved_surface_do_not_overlap_and_cover_three_quarters(surface):
    surface, taxels = _placed(surface)
    away = cKDTree(taxels.positions).query(taxels.positions, k=2)[0][:, 1]
    assert away.min() > 0.7 * PAD_PITCH
    assert np.median(away) == pytest.approx(PAD_PITCH, rel=0.1)
    assert len(taxels) / 10 > 0.7 * surface.area / (np.sqrt(3) / 4 * (TILE_SIDE * PAD_PITCH) ** 2)
    assert taxels.areas.sum() < surface.area
    assert taxels.areas.min() > 0


@pytest.mark.long
def test_no_pad_is_on_an_excluded_face():
    _, taxels = _placed(
        sheet(width=0.2, height=0.15), allowed=lambda c: np.linalg.norm(c - [0.1, 0.07, 0], axis=1) > 0.02
    )
    assert len(taxels) >= 100
    assert np.linalg.norm(taxels.positions - [0.1, 0.07, 0], axis=1).min() > 0.018
    assert np.linalg.norm(taxels.quadrature.positions - [0.1, 0.07, 0], axis=1).min() > 0.02


@pytest.mark.long
def test_same_seed_gives_the_same_modules():
    one, two, other = (_placed(sheet(), seed=seed)[1].positions for seed in (4, 4, 5))
    assert np.array_equal(one, two)
    assert one.shape != other.shape or not np.array_equal(one, other)


@pytest.mark.parametrize("surface", [sheet(width=0.03, height=0.015), frustum(0.004, 0.004)], ids=["small", "thin"])
def test_surface_without_room_for_a_module_is_rejected(surface):
    with pytest.raises(SkinError, match="no module fits"):
        _placed(surface)
