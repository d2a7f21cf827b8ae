"""Flips and crossings are found, and the barrier keeps a border apart."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.flattening.bijectivity import BoundaryBarrier, crossings, flipped, signed_areas
from tactile_maps.flattening.initial_map import tutte
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.mesh import Mesh
from tests.support.surfaces import named, sheet

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])


def test_areas_are_signed():
    faces = np.array([[0, 1, 2], [0, 2, 1], [0, 0, 1]])
    np.testing.assert_allclose(signed_areas(SQUARE, faces), [0.5, -0.5, 0])
    assert flipped(SQUARE, faces).tolist() == [False, True, True]


def test_nan_counts_as_flipped():
    assert flipped(np.full((3, 2), np.nan), np.array([[0, 1, 2]])).all()


def test_simple_loops_do_not_cross():
    turn = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    star = (1 + 0.5 * np.cos(9 * turn))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert crossings(SQUARE) == 0
    assert crossings(star) == 0
    assert crossings(1e-9 * star + 1) == 0
    assert crossings(np.zeros((0, 2))) == 0


def test_each_crossing_counts_once():
    turn = np.linspace(0, 2 * np.pi, 201, endpoint=False)
    eight = np.stack([np.sin(turn + 0.01), np.sin(2 * turn + 0.02)], axis=1)
    assert crossings(eight) == 1
    assert crossings(SQUARE[[0, 2, 1, 3]]) == 1


def test_touching_counts_as_crossing():
    assert crossings(np.array([[0, 0], [2, 0], [2, 1], [1, 0], [0, 1.0]])) > 0


@pytest.mark.parametrize("gap", [1e-15, 1e-3])
def test_two_loops_side_by_side_do_not_cross(gap):
    assert crossings(SQUARE, SQUARE + [1 + gap, 0]) == 0


def test_two_loops_that_overlap_cross():
    assert crossings(SQUARE, SQUARE + [0.5, 0.5]) == 2


def test_crossing_count_equals_that_of_all_pairs():
    loop = np.random.default_rng(3).normal(size=(60, 2))
    expected = 0
    for i in range(60):
        for j in range(i + 2, 60 - (i == 0)):
            a = loop[i]
            b = loop[(i + 1) % 60]
            c = loop[j]
            d = loop[(j + 1) % 60]
            sides = [np.linalg.det([q - p, r - p]) for p, q, r in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))]
            expected += sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0
    assert expected > 100
    assert crossings(loop) == expected


@pytest.fixture
def bent():
    """A strip bent into a ring that nearly closes: its two ends are close to each other."""
    flat = sheet(24, 2, width=2.4, height=0.2)
    angle = flat.vertices[:, 0] * (2 * np.pi - 0.06) / 2.4
    radius = 0.4 - flat.vertices[:, 1]
    plane = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    problem = SymmetricDirichlet(flat)
    return problem, flat.connectivity.boundary_loops[0], plane


def test_barrier_is_zero_unless_parts_are_close():
    flat = sheet(24, 2, width=2.4, height=0.2)
    problem = SymmetricDirichlet(flat)
    plane = flat.vertices[:, :2]
    apart = BoundaryBarrier(problem, flat.connectivity.boundary_loops[0], plane)
    assert apart.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(apart.derivatives(plane)[0], problem.derivatives(plane)[0])


def test_barrier_of_close_parts_is_positive_and_has_the_correct_gradient(bent):
    problem, loop, plane = bent
    apart = BoundaryBarrier(problem, loop, plane)
    assert apart.energy(plane) > problem.energy(plane) + 1e-4
    gradient = apart.derivatives(plane)[0]
    h = 1e-7
    for k in range(0, plane.size, 5):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (apart.energy(plane + step) - apart.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-4, abs=1e-6)


def test_hessian_is_positive_semidefinite(bent):
    apart = BoundaryBarrier(*bent)
    values = np.linalg.eigvalsh(apart.derivatives(bent[2])[1].toarray(), UPLO="U")
    assert values.min() > -1e-10 * values.max()


def test_self_intersecting_border_has_infinite_energy(bent):
    problem, loop, plane = bent
    apart = BoundaryBarrier(problem, loop, plane)
    angle = np.arctan2(plane[:, 1], plane[:, 0]) % (2 * np.pi) * 1.05
    closed = np.linalg.norm(plane, axis=1)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.isfinite(problem.energy(closed))
    assert crossings(closed[loop]) > 0
    assert apart.energy(closed) == np.inf


@pytest.mark.long
def test_every_step_of_a_descent_has_no_overlap():
    surface = named("spiral")
    positions = (surface.vertices - surface.vertices.mean(axis=0)) / np.sqrt(surface.area)
    problem = SymmetricDirichlet(Mesh(positions, surface.faces))
    loop = surface.connectivity.boundary_loops[0]
    start = tutte(Mesh(positions, surface.faces)) / np.sqrt(np.pi)
    *_, free = minimise(problem, start)
    assert crossings(free.plane[loop]) > 0, "without the barrier this map overlaps itself"
    rounds = list(minimise(BoundaryBarrier(problem, loop, free.plane), start))
    assert len(rounds) > 5
    assert not any(crossings(r.plane[loop]) for r in rounds)
    assert problem.energy(rounds[-1].plane) < 4.02


def test_corner_within_rounding_of_a_side_counts_as_touching():
    """An hourglass with a waist of one rounding error, like the two sides of a seam in a plain tube."""
    tip = [-0.38232282140252394, 0.10407355315773271]
    a = [-0.3084796216698031, 0.2676116508481561]
    other = [tip[0], 0.10407355315773269]
    plane = np.array([a, tip, [-0.5, 0.3], [-0.5, -0.1], other, [-0.3, -0.1]])
    wide = plane + [[0, 0.1], [0, 0.1], [0, 0.1], [0, 0], [0, 0], [0, 0]]
    faces = np.array([[2, 3, 4], [2, 4, 1], [0, 1, 4], [0, 4, 5]])
    problem = SymmetricDirichlet(Mesh(np.column_stack([wide, np.zeros(6)]), faces))
    apart = BoundaryBarrier(problem, np.arange(6), wide)
    assert not apart.touches(wide)
    assert crossings(plane) == 0
    assert apart._close(plane)[1].min() == 0
    assert apart.touches(plane)
    assert apart.energy(plane) == np.inf
