"""Normals and triangles of taxels that come without a surface."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.skin.reconstruction.triangulation import estimate_normals, triangulate
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.surfaces import cap, frustum, sheet, sphere


def _taxels(surface, count=250):
    taxels = place_evenly(surface, min(count, len(surface.faces) // 3))
    return taxels.positions, taxels.normals


def _agreement(found, true):
    return (found.normals * true).sum(axis=1)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    "surface", [sphere(), frustum(), frustum(0.05, 0.02), cap(1.2)], ids=["ball", "tube", "cone", "cap"]
)
def test_outside_of_a_curved_surface_is_found_without_normals(surface):
    positions, true = _taxels(surface)
    found = estimate_normals(positions + 1.0)
    assert np.quantile(_agreement(found, true), 0.05) > np.cos(0.3)
    assert (_agreement(found, true) > 0).all()
    assert not found.findings
    assert np.linalg.norm(found.normals, axis=1) == pytest.approx(1)


def test_stated_normals_only_select_the_side():
    positions, true = _taxels(sphere())
    tilted = -true + 0.5 * np.array([0, 0, 1.0])
    tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
    inward = estimate_normals(positions, stated=tilted)
    assert np.array_equal(inward.normals, -estimate_normals(positions).normals)
    assert not inward.findings


def test_few_wrong_normals_are_outvoted():
    positions, true = _taxels(sheet(shape=lambda x, y: 2 * x * y))
    stated = np.where(np.arange(len(true))[:, None] % 5 == 0, -true, true)
    assert (_agreement(estimate_normals(positions, stated=stated), true) > 0).all()


@pytest.mark.parametrize(
    ("stated", "kind"),
    [
        (lambda true: np.zeros_like(true), "dummy-normals"),
        (lambda true: np.tile([0.0, 0.0, 1.0], (len(true), 1)), "dummy-normals"),
        (lambda true: np.roll(true, 1, axis=1), "foreign-normals"),
    ],
    ids=["zero", "one for all", "another frame"],
)
def test_implausible_normals_are_ignored_with_a_finding(stated, kind):
    positions, true = _taxels(frustum())
    found = estimate_normals(positions, stated=stated(true))
    assert [note.kind for note in found.findings] == [kind]
    assert np.array_equal(found.normals, estimate_normals(positions).normals)


def test_common_normal_is_correct_on_a_plane():
    positions, _ = _taxels(sheet())
    down = estimate_normals(positions, stated=np.tile([0.0, 0.0, -1.0], (len(positions), 1)))
    assert not down.findings
    assert down.normals == pytest.approx(np.tile([0, 0, -1.0], (len(positions), 1)), abs=1e-9)


def test_plane_far_from_the_link_faces_away_with_a_finding():
    positions, _ = _taxels(sheet())
    for lift in (0.1, -0.1):
        found = estimate_normals(positions + [0, 0, lift])
        assert (found.normals[:, 2] * lift > 0).all()
        assert [note.kind for note in found.findings] == ["guessed-outside"]


def test_separate_sheets_are_oriented_independently():
    near, _ = _taxels(sheet(), 60)
    two = np.concatenate([near + [0, 0, 0.2], near - [0, 0, 0.2]])
    assert np.array_equal(np.sign(estimate_normals(two).normals[:, 2]), np.repeat([1, -1], len(near)))


def test_row_of_taxels_uses_the_stated_normals():
    row = np.stack([0.01 * np.arange(5), np.zeros(5), np.full(5, 0.05)], axis=1)
    stated = np.tile([0.0, 1.0, 0.0], (5, 1))
    assert estimate_normals(row, stated=stated).normals == pytest.approx(stated)


def hexagonal(columns, rows, pitch=0.01):
    i, j = (part.ravel() for part in np.meshgrid(np.arange(columns), np.arange(rows)))
    return pitch * np.stack([i + 0.5 * (j % 2), np.sqrt(3) / 2 * j, np.zeros(i.size)], axis=1)


def test_random_points_of_the_plane_get_the_delaunay_triangles_away_from_the_border():
    random = np.random.default_rng(0)
    points = hexagonal(20, 20) + np.pad(random.uniform(-2e-3, 2e-3, (400, 2)), ((0, 0), (0, 1)))
    found = triangulate(points, normals=np.tile([0, 0, 1.0], (400, 1)))
    true = Delaunay(points[:, :2]).simplices
    middle = points[:, :2].mean(axis=0)

    def inner(faces):
        kept = (np.abs(points[faces][:, :, :2] - middle).max(axis=2) < 0.07).all(axis=1)
        return {tuple(sorted(face)) for face in faces[kept].tolist()}

    assert len(inner(true)) > 250
    assert inner(found.mesh.faces) == inner(true)
    assert (found.mesh.face_normals[:, 2] > 0).all()


@pytest.mark.parametrize("gap", [0.026, 0.05])
def test_gap_is_not_bridged(gap):
    patch = hexagonal(6, 6)
    shift = np.array([patch[:, 0].max() + gap, 0, 0])
    faces = triangulate(np.concatenate([patch, patch + shift])).mesh.faces
    assert (np.ptp(faces // len(patch), axis=1) == 0).all()
    assert Connectivity(faces).components.max() == 1


def test_sparse_and_dense_parts_with_a_gradual_transition_are_joined():
    x = 0.01 * np.cumsum(1.15 ** np.arange(12))
    points = np.stack([*np.meshgrid(x, 0.02 * np.arange(8)), np.zeros((8, 12))], axis=-1).reshape(-1, 3)
    found = triangulate(points)
    assert found.mesh.connectivity.components.max() == 0
    assert len(np.unique(found.mesh.faces)) == len(points)


def test_missing_taxel_is_bridged_and_a_real_hole_is_kept():
    points = hexagonal(9, 9)
    middle = np.linalg.norm(points - points.mean(axis=0), axis=1)
    one = triangulate(np.delete(points, middle.argmin(), axis=0)).mesh
    assert one.connectivity.euler_characteristic == 1
    hole = triangulate(points[middle > 0.022]).mesh
    assert hole.connectivity.euler_characteristic == 0
    assert len(hole.connectivity.boundary_loops) == 2


@pytest.mark.parametrize("seed", range(6))
def test_noisy_and_clustered_taxels_give_a_surface(seed):
    random = np.random.default_rng(seed)
    points = random.uniform(-0.05, 0.05, (150, 3)) * [1, 1, random.uniform(0, 1)]
    faces = triangulate(points).mesh.faces
    assert Connectivity(faces).face_count.max(initial=0) <= 2
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert not len(Connectivity(faces).bow_tie_vertices)


@pytest.mark.parametrize(
    ("positions", "problem"),
    [
        (np.zeros((0, 3)), "no taxels"),
        (np.array([[0, 0, np.nan]]), "not a finite"),
        (np.zeros((2, 3)), "one place"),
    ],
)
def test_invalid_positions_are_rejected(positions, problem):
    with pytest.raises(SkinError, match=problem):
        triangulate(positions)
