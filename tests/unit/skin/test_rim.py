"""Rims: as wide as asked for, round at corners, never folded."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.skin.rim import grow_rim


def _mesh(positions, walk, width=0.005):
    positions = np.asarray(positions, dtype=float)
    up, widths = np.tile([0, 0, 1.0], (len(positions), 1)), np.full(len(positions), width)
    rim = grow_rim(positions, up, widths, np.asarray(walk), first=len(positions))
    return Mesh(np.concatenate([positions, rim.vertices]), rim.faces), rim


def test_a_lone_taxel_gets_a_hexagon():
    mesh, rim = _mesh([[0.1, 0.2, 0.3]], [0])
    assert len(rim.vertices) == 6
    assert np.linalg.norm(rim.vertices - [0.1, 0.2, 0.3], axis=1) == pytest.approx(0.005)
    assert mesh.area == pytest.approx(6 * np.sqrt(3) / 4 * 0.005**2)
    assert mesh.face_normals == pytest.approx(np.tile([0, 0, 1.0], (6, 1)))


def test_a_row_gets_a_strip_with_round_ends():
    row = [[0.01 * k, 0, 0] for k in range(4)]
    mesh, rim = _mesh(row, [0, 1, 2, 3, 2, 1])
    ends = 2 * 3 * np.sqrt(3) / 4 * 0.005**2
    assert mesh.area == pytest.approx(0.03 * 0.01 + ends)
    assert (mesh.face_normals[:, 2] > 0.999).all()
    assert np.bincount(rim.taxel).tolist() == [4, 2, 2, 4]


@pytest.mark.parametrize("up", [[0, 0, 1.0], [0, 0, -1.0], [-1, -1, -1.0], [1, 1, 1.0]])
def test_a_row_is_the_same_strip_whichever_way_it_lies(up):
    """Whether half a turn comes out as plus or minus pi is a matter of signed zeros."""
    normal = np.array(up) / np.linalg.norm(up)
    along = np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    row, width = 0.01 * np.outer(np.arange(3), along), np.full(3, 0.005)
    rim = grow_rim(row, np.tile(normal, (3, 1)), width, np.array([0, 1, 2, 1]), first=3)
    mesh = Mesh(np.concatenate([row, rim.vertices]), rim.faces)
    assert np.bincount(rim.taxel).tolist() == [4, 2, 4]
    assert mesh.area == pytest.approx(0.02 * 0.01 + 6 * np.sqrt(3) / 4 * 0.005**2)
    assert (mesh.face_normals @ normal).min() > 0.999


def test_a_square_grows_all_around():
    mesh, _ = _mesh([[0, 0, 0], [0.01, 0, 0], [0.01, 0.01, 0], [0, 0.01, 0]], [0, 1, 2, 3])
    corner = 2 * 0.5 * 0.005**2 * np.sin(np.pi / 4)  # two triangles between the spokes of a right angle
    assert mesh.area == pytest.approx(4 * (0.01 * 0.005 + corner))
    assert mesh.bounds[:, :2] == pytest.approx(np.array([[-0.005] * 2, [0.015] * 2]))


def test_a_hole_is_narrowed_from_inside():
    """Walked with the surface on the left, that is clockwise."""
    mesh, _ = _mesh([[0, 0, 0], [0, 0.04, 0], [0.04, 0.04, 0], [0.04, 0, 0]], [0, 1, 2, 3])
    assert (mesh.face_normals[:, 2] > 0).all()
    assert mesh.bounds[:, :2] == pytest.approx(np.array([[0, 0], [0.04, 0.04]]))
    assert 0 < mesh.area < 0.04**2


@pytest.mark.parametrize("angle", np.radians([5, 20, 60, 120, 170]))
def test_no_notch_folds_the_rim(angle):
    tip = 0.01 * np.array(
        [[np.sin(angle / 2), np.cos(angle / 2), 0], [0, 0, 0], [-np.sin(angle / 2), np.cos(angle / 2), 0]]
    )
    walk = [*tip[::-1], [-0.03, 0.01, 0], [-0.03, -0.03, 0], [0.03, -0.03, 0], [0.03, 0.01, 0]]
    mesh, _ = _mesh(walk, range(7))
    assert (mesh.face_normals[:, 2] > 0).all()


@pytest.mark.parametrize("width", [0.005, 0.02, 0.1])
def test_a_rim_wider_than_a_notch_is_drawn_in(width):
    """Spokes on the two sides of a narrow notch would cross."""
    x = np.array([0, 0, 1, 1.4, 1.5, 1.6, 2, 3, 3]) * 0.01
    y = np.array([0, 2, 2, 2, 1, 2, 2, 2, 0]) * 0.01
    mesh, _ = _mesh(np.stack([x, y, 0 * x], axis=1), range(8, -1, -1), width)
    assert (mesh.face_normals[:, 2] > 0).all()


def test_the_rim_follows_each_taxels_own_plane():
    positions = np.array([[0, 0, 0], [0.01, 0, 0.002], [0.005, 0.01, 0.001]])
    normals = np.array([[0, 0, 1.0], [0.6, 0, 0.8], [0, 0, 1.0]])
    rim = grow_rim(positions, normals, np.full(3, 0.004), np.array([0, 1, 2]), first=3)
    offset = rim.vertices - positions[rim.taxel]
    assert (offset * normals[rim.taxel]).sum(axis=1) == pytest.approx(0, abs=1e-12)
