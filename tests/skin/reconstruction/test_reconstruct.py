"""A skin from taxels alone: the boundary's extension, and the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction import reconstruct
from tactile_maps.skin.reconstruction.reconstruct import (
    LONE_TAXEL_RADIUS,
    extend_boundary,
    reconstruct_skin,
    skin_from_taxels,
)
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.support.findings import kinds
from tests.support.surfaces import frustum, sphere


def _mesh(positions, walk, width=0.005):
    positions = np.asarray(positions, dtype=float)
    up = np.tile([0, 0, 1.0], (len(positions), 1))
    widths = np.full(len(positions), width)
    rim = extend_boundary(positions, up, widths, np.asarray(walk), first=len(positions))
    return Mesh(np.concatenate([positions, rim.vertices]), rim.faces), rim


@pytest.mark.parametrize("up", [[0, 0, 1.0], [0, 0, -1.0], [-1, -1, -1.0], [1, 1, 1.0]])
def test_row_is_the_same_strip_in_every_direction(up):
    """Signed zeros decide whether half a turn is plus or minus pi."""
    normal = np.array(up) / np.linalg.norm(up)
    along = np.array([1.0, -1.0, 0.0]) / np.sqrt(2)
    row = 0.01 * np.outer(np.arange(3), along)
    width = np.full(3, 0.005)
    rim = extend_boundary(row, np.tile(normal, (3, 1)), width, np.array([0, 1, 2, 1]), first=3)
    mesh = Mesh(np.concatenate([row, rim.vertices]), rim.faces)
    assert np.bincount(rim.taxel).tolist() == [4, 2, 4]
    assert mesh.area == pytest.approx(0.02 * 0.01 + 6 * np.sqrt(3) / 4 * 0.005**2)
    assert (mesh.face_normals @ normal).min() > 0.999


@pytest.mark.parametrize("width", [0.005, 0.02, 0.1])
def test_wide_rim_at_a_notch_does_not_fold_over(width):
    """Spokes on the two sides of a narrow notch would cross."""
    x = np.array([0, 0, 1, 1.4, 1.5, 1.6, 2, 3, 3]) * 0.01
    y = np.array([0, 2, 2, 2, 1, 2, 2, 2, 0]) * 0.01
    mesh, _ = _mesh(np.stack([x, y, 0 * x], axis=1), range(8, -1, -1), width)
    assert (mesh.face_normals[:, 2] > 0).all()


def test_rim_follows_each_taxels_own_plane():
    positions = np.array([[0, 0, 0], [0.01, 0, 0.002], [0.005, 0.01, 0.001]])
    normals = np.array([[0, 0, 1.0], [0.6, 0, 0.8], [0, 0, 1.0]])
    rim = extend_boundary(positions, normals, np.full(3, 0.004), np.array([0, 1, 2]), first=3)
    offset = rim.vertices - positions[rim.taxel]
    assert (offset * normals[rim.taxel]).sum(axis=1) == pytest.approx(0, abs=1e-12)


PITCH = 0.01


def taxel_set(positions, **more):
    positions = np.asarray(positions, dtype=float)
    return TaxelSet("pad", more.pop("link", None), np.arange(len(positions)), positions, **more)


def grid(columns, rows):
    x, y = np.meshgrid(PITCH * np.arange(columns), PITCH * np.arange(rows))
    return np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)


def check(taxels):
    """The laws that hold for any set; returns the skin."""
    built = reconstruct_skin(taxels)
    skin = built.skin
    at = np.concatenate([patch.taxels.positions for patch in skin.patches])
    assert at[built.taxel_of] == pytest.approx(taxels.positions, abs=2e-5)
    assert set(built.taxel_of.tolist()) == set(range(len(skin)))
    for patch in skin.patches:
        surface = patch.surface
        placed = patch.taxels
        assert surface.connectivity.face_count.max() <= 2
        assert not len(surface.connectivity.bow_tie_vertices)
        assert surface.connectivity.components.max() == 0
        assert surface.face_areas.min() > 0
        assert placed.areas.sum() == pytest.approx(surface.area, rel=1e-12)
        assert placed.areas.min() > 0
        assert surface.points(placed.faces, placed.weights) == pytest.approx(placed.positions, abs=1e-15)
        assert np.bincount(placed.quadrature.taxel, minlength=len(placed)).min() >= 6
    return skin


def test_grid_is_one_patch_with_equal_areas_also_for_border_taxels():
    skin = check(taxel_set(grid(6, 5), link="forearm"))
    (patch,) = skin.patches
    assert (patch.name, patch.link) == ("pad", "forearm")
    assert skin.areas == pytest.approx(PITCH**2, rel=0.2)
    assert patch.surface.area == pytest.approx(30 * PITCH**2, rel=0.02)
    assert patch.surface.bounds[:, :2] == pytest.approx(np.array([[-0.005, -0.005], [0.055, 0.045]]))


def test_neighbours_are_connected_by_triangle_sides():
    skin = check(taxel_set(grid(4, 4)))
    pairs = skin.neighbours
    apart = np.linalg.norm(np.diff(skin.patches[0].taxels.positions[pairs], axis=1)[:, 0], axis=1)
    assert (apart < 1.5 * PITCH).all()
    assert (np.isclose(apart, PITCH)).sum() == 2 * 4 * 3


def test_separate_parts_are_patches_sorted_by_size():
    skin = check(taxel_set(np.concatenate([grid(3, 3), grid(6, 5) + [0.2, 0, 0], grid(4, 4) - [0.2, 0, 0]])))
    assert [(patch.name, len(patch.taxels)) for patch in skin.patches] == [("pad", 30), ("pad 2", 16), ("pad 3", 9)]


def test_isolated_taxel_covers_a_small_disc():
    skin = check(taxel_set([[0, 0, 0.1]]))
    assert kinds(skin.findings) == {"lone-taxel": 1, "guessed-outside": 1}
    assert skin.areas == pytest.approx(6 * np.sqrt(3) / 4 * LONE_TAXEL_RADIUS**2)
    assert skin.patches[0].taxels.normals == pytest.approx(np.array([[0, 0, 1.0]]))


@pytest.mark.parametrize("count", [2, 3, 7])
def test_row_is_one_strip(count):
    skin = check(taxel_set(np.outer(np.arange(count), [PITCH, 0, 0]) + [0, 0, 0.1]))
    assert len(skin.patches) == 1
    assert kinds(skin.findings)["taxel-row"] == 1
    assert skin.patches[0].surface.area == pytest.approx((count - 1) * PITCH**2 + 6 * np.sqrt(3) / 4 * 0.25 * PITCH**2)


def test_row_next_to_a_patch_and_distant_taxel_are_kept():
    row = np.outer(np.arange(4), [PITCH, 0, 0]) + [0, 0.2, 0]
    skin = check(taxel_set(np.concatenate([grid(5, 5), row, [[0.5, 0.5, 0]]])))
    assert sorted(len(patch.taxels) for patch in skin.patches) == [1, 4, 25]
    assert kinds(skin.findings)["taxel-row"] == 1
    assert kinds(skin.findings)["lone-taxel"] == 1


def test_coincident_taxels_are_merged_and_counted():
    points = grid(5, 5)
    taxels = taxel_set(np.concatenate([points, points[:7] + 4e-6]))
    skin = check(taxels)
    assert len(skin) == 25
    assert kinds(skin.findings)["duplicate-taxel"] == 7
    assert np.array_equal(reconstruct_skin(taxels).taxel_of[25:], reconstruct_skin(taxels).taxel_of[:7])
    assert len(check(taxel_set(np.zeros((5, 3))))) == 1


def test_findings_of_the_file_are_passed_on():
    noticed = Finding("thermal-pad", "file", "left out", 3)
    assert noticed in skin_from_taxels(taxel_set(grid(3, 3), findings=(noticed,))).findings


def test_valid_faces_of_the_file_are_kept():
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    # These would not be joined by default: the sides are far longer than their distances to others.
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 0.01, 0], [0, 0.01, 0.0]])
    skin = check(taxel_set(corners, faces=faces))
    sides = {(0, 1), (1, 2), (2, 3), (0, 3)}
    # The cells of all four meet in the middle.
    assert {tuple(pair) for pair in skin.neighbours.tolist()} == sides | {(0, 2), (1, 3)}
    assert (skin.patches[0].surface.face_normals[:, 2] > 0).all()


@pytest.mark.parametrize(
    ("faces", "problem"),
    [
        ([[0, 1, 4], [0, 1, 5], [1, 0, 6]], "more than two"),
        ([[0, 1, 4], [0, 1, 5]], "oriented inconsistently"),
        ([[0, 1, 2]], "no area"),
        ([[5, 6, 11], [5, 0, 1]], "several fans"),
    ],
)
def test_invalid_faces_are_replaced_with_a_finding(faces, problem):
    points = grid(4, 4)
    skin = check(taxel_set(points, faces=np.array(faces)))
    note = next(note for note in skin.findings if note.kind == "unsound-faces")
    assert problem in note.action
    assert np.array_equal(skin.neighbours, check(taxel_set(points)).neighbours)


def test_faces_are_oriented_along_the_normals():
    down = np.tile([0, 0, -1.0], (4, 1))
    faces = np.array([[0, 1, 3], [0, 3, 2]])
    skin = check(taxel_set(grid(2, 2), faces=faces, normals=down))
    assert kinds(skin.findings) == {"turned-face": 2}
    assert skin.patches[0].taxels.normals == pytest.approx(down)


def test_taxels_missing_in_the_faces_of_the_file_are_kept():
    skin = check(taxel_set(np.concatenate([grid(2, 2), [[0.05, 0, 0]]]), faces=np.array([[0, 1, 3], [0, 3, 2]])))
    assert sorted(len(patch.taxels) for patch in skin.patches) == [1, 4]


def test_inward_normals_of_a_file_are_kept():
    placed = place_evenly(sphere(), 200)
    outward = check(taxel_set(placed.positions))
    inward = check(taxel_set(placed.positions, normals=-placed.normals))
    assert (outward.patches[0].taxels.normals * outward.patches[0].taxels.positions).sum(axis=1).min() > 0
    assert (inward.patches[0].taxels.normals * inward.patches[0].taxels.positions).sum(axis=1).max() < 0


def test_reconstruction_is_deterministic_and_invariant_to_scale_and_position():
    placed = place_evenly(frustum(), 150)
    taxels = taxel_set(placed.positions)
    one = skin_from_taxels(taxels)
    again = skin_from_taxels(taxels)
    assert np.array_equal(one.patches[0].surface.vertices, again.patches[0].surface.vertices)
    other = skin_from_taxels(replace(taxels, positions=3 * placed.positions + 1))
    assert np.array_equal(other.neighbours, one.neighbours)
    assert other.areas == pytest.approx(9 * one.areas, rel=1e-6)


def test_too_many_separate_pieces_are_rejected(monkeypatch):
    positions = 0.5 * np.random.default_rng(0).random((40, 3))
    taxels = TaxelSet("far", None, np.arange(40), positions)
    pieces = len(reconstruct_skin(taxels).skin.patches)
    assert pieces > 2
    monkeypatch.setattr(reconstruct, "MAX_PIECES", pieces)
    assert len(reconstruct_skin(taxels).skin.patches) == pieces
    monkeypatch.setattr(reconstruct, "MAX_PIECES", pieces - 1)
    with pytest.raises(SkinError, match=f"separate pieces.*found: {pieces}.*The maximum is {pieces - 1}"):
        reconstruct_skin(taxels)
