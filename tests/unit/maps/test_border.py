"""The barrier: right derivatives, and no map ever lies on itself."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings
from app.maps.border import ApartBorder
from app.maps.methods.tutte import tutte
from app.maps.newton import minimise
from app.maps.symmetric_dirichlet import SymmetricDirichlet
from tests.numerics.map_surfaces import named, sheet


@pytest.fixture
def bent():
    """A strip bent into a ring that nearly closes: its two ends are close to each other."""
    flat = sheet(24, 2, width=2.4, height=0.2)
    angle, radius = flat.vertices[:, 0] * (2 * np.pi - 0.06) / 2.4, 0.4 - flat.vertices[:, 1]
    plane = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    problem = SymmetricDirichlet(flat.vertices, flat.faces)
    return problem, boundary_loops(flat.faces)[0], plane


def test_apart_from_close_parts_it_costs_nothing():
    flat = sheet(24, 2, width=2.4, height=0.2)
    problem, plane = SymmetricDirichlet(flat.vertices, flat.faces), flat.vertices[:, :2]
    apart = ApartBorder(problem, boundary_loops(flat.faces)[0], plane)
    assert apart.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(apart.derivatives(plane)[0], problem.derivatives(plane)[0])


def test_closeness_costs_and_the_gradient_is_the_energys(bent):
    problem, loop, plane = bent
    apart = ApartBorder(problem, loop, plane)
    assert apart.energy(plane) > problem.energy(plane) + 1e-4
    gradient, h = apart.derivatives(plane)[0], 1e-7
    for k in range(0, plane.size, 5):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (apart.energy(plane + step) - apart.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-4, abs=1e-6)


def test_the_hessian_is_never_negative(bent):
    apart = ApartBorder(*bent)
    values = np.linalg.eigvalsh(apart.derivatives(bent[2])[1].toarray(), UPLO="U")
    assert values.min() > -1e-10 * values.max()


def test_a_border_that_meets_itself_costs_infinitely_much(bent):
    problem, loop, plane = bent
    apart = ApartBorder(problem, loop, plane)
    angle = np.arctan2(plane[:, 1], plane[:, 0]) % (2 * np.pi) * 1.05
    closed = np.linalg.norm(plane, axis=1)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    assert np.isfinite(problem.energy(closed))
    assert crossings(closed[loop]) > 0
    assert apart.energy(closed) == np.inf


def test_every_round_of_a_descent_stays_off_itself():
    surface = named("spiral")
    positions = (surface.vertices - surface.vertices.mean(axis=0)) / np.sqrt(surface.area)
    problem, loop = SymmetricDirichlet(positions, surface.faces), boundary_loops(surface.faces)[0]
    start = tutte(positions, surface.faces) / np.sqrt(np.pi)
    *_, free = minimise(problem, start)
    assert crossings(free.plane[loop]) > 0, "without the barrier this surface does lie on itself"
    rounds = list(minimise(ApartBorder(problem, loop, free.plane), start))
    assert len(rounds) > 5
    assert not any(crossings(r.plane[loop]) for r in rounds)
    assert problem.energy(rounds[-1].plane) < 4.02


def test_a_corner_that_misses_a_side_by_the_last_bit_touches():
    """An hourglass whose waist is one rounding wide, as the two sides of a seam in a plain tube come to lie."""
    tip, a = [-0.38232282140252394, 0.10407355315773271], [-0.3084796216698031, 0.2676116508481561]
    other = [tip[0], 0.10407355315773269]
    plane = np.array([a, tip, [-0.5, 0.3], [-0.5, -0.1], other, [-0.3, -0.1]])
    wide = plane + [[0, 0.1], [0, 0.1], [0, 0.1], [0, 0], [0, 0], [0, 0]]
    faces = np.array([[2, 3, 4], [2, 4, 1], [0, 1, 4], [0, 4, 5]])
    problem = SymmetricDirichlet(np.column_stack([wide, np.zeros(6)]), faces)
    apart = ApartBorder(problem, np.arange(6), wide)
    assert not apart.touches(wide)
    assert crossings(plane) == 0
    assert apart._close(plane)[1].min() == 0
    assert apart.touches(plane)
    assert apart.energy(plane) == np.inf
