"""Any surface becomes a disk, its faces keep their numbers, and the seams are short."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.cut import SeamPlan, cut_to_disk, far_points, farthest_from_border
from tactile_maps.geometry.surface.mesh import Mesh
from tests.support.surfaces import SURFACES, cap, frustum, named, sheet, sphere, torus

WHOLE = [name for name in SURFACES if name != "deep cup"]


@pytest.mark.parametrize("name", WHOLE)
def test_every_surface_becomes_a_disk_with_its_own_faces(name):
    surface = named(name)
    cut = cut_to_disk(surface)
    assert cut.connectivity.euler_characteristic == 1
    assert len(cut.connectivity.boundary_loops) == 1
    np.testing.assert_array_equal(cut.vertex_of[cut.faces], surface.faces)


@pytest.mark.parametrize("name", WHOLE)
def test_seams_are_edges_with_a_face_on_both_sides(name):
    surface = named(name)
    cut = cut_to_disk(named(name))
    edges = {tuple(edge) for edge in surface.edges.tolist()}
    inner = edges - {
        tuple(sorted((a, b)))
        for loop in surface.connectivity.boundary_loops
        for a, b in zip(loop.tolist(), np.roll(loop, -1).tolist(), strict=True)
    }
    assert {tuple(sorted(seam)) for seam in cut.seams.tolist()} <= inner


def test_disk_is_not_cut():
    assert len(cut_to_disk(sheet()).seams) == 0


def test_tube_is_cut_along_a_straight_line():
    surface = frustum(length=0.2)
    seams = surface.vertices[cut_to_disk(surface).seams]
    assert np.linalg.norm(seams[:, 0] - seams[:, 1], axis=1).sum() == pytest.approx(0.2, rel=1e-12)


def test_ball_is_cut_from_one_side_to_the_other():
    ball = sphere(radius=0.05)
    seams = ball.vertices[cut_to_disk(ball).seams]
    length = np.linalg.norm(seams[:, 0] - seams[:, 1], axis=1).sum()
    assert np.pi * 0.05 * 0.95 < length < np.pi * 0.05 * 1.2


def test_torus_is_cut_around_both_ways():
    surface = torus(major=0.06, minor=0.02)
    seams = surface.vertices[cut_to_disk(surface).seams]
    length = np.linalg.norm(seams[:, 0] - seams[:, 1], axis=1).sum()
    shortest = 2 * np.pi * (0.06 - 0.02) + 2 * np.pi * 0.02
    assert 0.95 * shortest < length < 1.3 * shortest


def test_seam_reaches_the_terminal():
    surface = cap(1.0)
    cut = cut_to_disk(surface, terminals=[0])
    assert 0 in cut.seams
    assert (cut.vertex_of == 0).sum() == 1, "the tip of a slit is one point"
    assert cut.connectivity.euler_characteristic == 1


def test_pole_is_farthest_from_the_border():
    surface = cap(1.0)
    assert farthest_from_border(surface, cut_to_disk(surface)) == 0


def test_farthest_points_of_a_needle_are_its_ends():
    ball = sphere()
    stretched = Mesh(ball.vertices * [1, 1, 5], ball.faces)
    heights = stretched.vertices[far_points(stretched), 2]
    assert sorted(heights) == pytest.approx([-0.25, 0.25], rel=0.05)


def test_cut_does_not_depend_on_the_position_of_the_surface():
    surface = named("sieve")
    moved = Mesh(surface.vertices + [3.0, -2.0, 1.0], surface.faces)
    np.testing.assert_array_equal(cut_to_disk(surface).seams, cut_to_disk(moved).seams)


def _two_sheets():
    one = sheet()
    return Mesh(
        np.concatenate([one.vertices, one.vertices + 1]), np.concatenate([one.faces, one.faces + len(one.vertices)])
    )


def _fin():
    one = sheet()
    return Mesh(np.concatenate([one.vertices, [[0.0, 0.0, 0.1]]]), [*one.faces.tolist(), [0, len(one.vertices), 10]])


def _turned():
    one = sheet()
    faces = one.faces.copy()
    faces[30] = faces[30, ::-1]
    return Mesh(one.vertices, faces)


def _moebius():
    turn = np.arange(24) * 2 * np.pi / 24
    low = np.stack([np.cos(turn), np.sin(turn), -0.2 * np.cos(turn / 2)], axis=1)
    high = np.stack([np.cos(turn), np.sin(turn), 0.2 * np.cos(turn / 2)], axis=1)
    rails = [(k, k + 24) for k in range(24)] + [(24, 0)]
    faces = [f for (a, b), (c, d) in pairwise(rails) for f in ((a, c, d), (a, d, b))]
    return Mesh(np.concatenate([low, high]), faces)


@pytest.mark.parametrize(
    ("surface", "says"),
    [
        (Mesh(np.zeros((0, 3)), np.zeros((0, 3))), "no faces"),
        (_two_sheets(), "not in one piece"),
        (_fin(), "more than two faces|disagree|piece"),
        (_turned(), "oriented inconsistently"),
        (_moebius(), "oriented inconsistently"),
    ],
)
def test_surface_that_cannot_be_cut_is_rejected_by_name(surface, says):
    with pytest.raises(MapError, match=says):
        cut_to_disk(surface)


@pytest.mark.parametrize("extra", [-1, 101, 10**30])
def test_number_of_extra_seams_is_limited(extra):
    assert SeamPlan(extra=100).extra == 100
    with pytest.raises(MapError, match="seams: the number of seams is out of range.*Choose 0 to 100"):
        SeamPlan(extra=extra)
