"""A surface through taxels: what is laid fits, what is a gap stays one. How close to the truth: test_taxels_alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from app.errors import SkinError
from app.geometry.topology import boundary_loops, bow_tie_vertices, edge_table, euler_characteristic, face_components
from app.skin.triangulate import spacings, triangulate


def hexagonal(columns, rows, pitch=0.01):
    i, j = (part.ravel() for part in np.meshgrid(np.arange(columns), np.arange(rows)))
    return pitch * np.stack([i + 0.5 * (j % 2), np.sqrt(3) / 2 * j, np.zeros(i.size)], axis=1)


def test_a_lattice_gets_its_triangles():
    points = hexagonal(7, 6)
    found = triangulate(points)
    sides = np.linalg.norm(np.diff(points[found.mesh.edges], axis=1)[:, 0], axis=1)
    along = np.isclose(sides, 0.01)
    assert sides[~along] == pytest.approx(0.01 * np.sqrt(3))  # only where they close the zigzag of the border
    assert along.sum() == 6 * 6 + 5 * 13
    assert found.spacing == pytest.approx(0.0112, rel=0.3)


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


def test_a_square_grid_has_no_overlap_though_both_diagonals_are_as_good():
    points = np.stack([*np.meshgrid(np.arange(8.0), np.arange(6.0)), np.zeros((6, 8))], axis=-1).reshape(-1, 3) * 0.01
    mesh = triangulate(points).mesh
    assert mesh.area == pytest.approx(7 * 5 * 1e-4)
    assert len(mesh.faces) == 2 * 7 * 5


@pytest.mark.parametrize("gap", [0.026, 0.05])
def test_a_gap_is_not_bridged(gap):
    patch = hexagonal(6, 6)
    shift = np.array([patch[:, 0].max() + gap, 0, 0])
    faces = triangulate(np.concatenate([patch, patch + shift])).mesh.faces
    assert (np.ptp(faces // len(patch), axis=1) == 0).all()
    assert face_components(faces).max() == 1


def test_a_sparse_and_a_dense_part_join_where_they_grade_into_each_other():
    x = 0.01 * np.cumsum(1.15 ** np.arange(12))
    points = np.stack([*np.meshgrid(x, 0.02 * np.arange(8)), np.zeros((8, 12))], axis=-1).reshape(-1, 3)
    found = triangulate(points)
    assert face_components(found.mesh.faces).max() == 0
    assert len(np.unique(found.mesh.faces)) == len(points)


def test_a_missing_taxel_is_spanned_and_a_real_hole_is_left():
    points = hexagonal(9, 9)
    middle = np.linalg.norm(points - points.mean(axis=0), axis=1)
    one = triangulate(np.delete(points, middle.argmin(), axis=0)).mesh
    assert euler_characteristic(one.faces) == 1
    hole = triangulate(points[middle > 0.022]).mesh
    assert euler_characteristic(hole.faces) == 0
    assert len(boundary_loops(hole.faces)) == 2


def test_two_walls_of_a_thin_plate_stay_apart():
    front = hexagonal(8, 8)
    behind = front + [0.003, 0.002, -0.004]
    both = np.concatenate([front, behind])
    stated = np.repeat([[0, 0, 1.0], [0, 0, -1.0]], len(front), axis=0)
    faces = triangulate(both, normals=stated).mesh.faces
    assert edge_table(faces).face_count.max() <= 2  # whatever it makes of this, it is a surface


@pytest.mark.parametrize("seed", range(6))
def test_noise_and_clumps_still_give_a_surface(seed):
    random = np.random.default_rng(seed)
    points = random.uniform(-0.05, 0.05, (150, 3)) * [1, 1, random.uniform(0, 1)]
    faces = triangulate(points).mesh.faces
    assert edge_table(faces).face_count.max(initial=0) <= 2
    directed = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    assert len(np.unique(directed, axis=0)) == len(directed)
    assert not len(bow_tie_vertices(faces))


@pytest.mark.parametrize("count", [1, 2, 8])
def test_a_row_has_no_faces(count):
    row = np.outer(np.arange(count), [0.01, 0.002, 0.0])
    assert len(triangulate(row).mesh.faces) == 0
    assert len(spacings(row)) == count


@pytest.mark.parametrize(
    ("positions", "problem"),
    [
        (np.zeros((0, 3)), "no taxels"),
        (np.array([[0, 0, np.nan]]), "not a finite"),
        (np.zeros((2, 3)), "one place"),
    ],
)
def test_what_cannot_be_joined_is_refused(positions, problem):
    with pytest.raises(SkinError, match=problem):
        triangulate(positions)
