"""Springs: right derivatives, in the pattern that the Hessian has anyway."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import triu

from app.maps.newton import minimise
from app.maps.pinned_energy import STIFFNESS, PinnedEnergy, Springs
from app.maps.symmetric_dirichlet import SymmetricDirichlet
from tests.numerics.map_surfaces import cap

SURFACE = cap(1.0, rings=4, radius=0.6)
FACES = [0, 20, 60]
WEIGHTS = np.array([[0.2, 0.3, 0.5], [1.0, 0.0, 0.0], [0.0, 0.5, 0.5]])


@pytest.fixture
def pinned():
    problem, plane = SymmetricDirichlet(SURFACE.vertices, SURFACE.faces), 1.1 * SURFACE.vertices[:, :2]
    springs = Springs(SURFACE.faces[FACES], WEIGHTS)
    here = np.einsum("pc,pcd->pd", WEIGHTS, plane[SURFACE.faces[FACES]])
    return problem, PinnedEnergy(problem, springs, here + [[0.01, 0.0], [0.0, -0.02], [0.03, 0.01]]), plane


def test_in_its_place_a_pin_costs_nothing(pinned):
    problem, energy, plane = pinned
    home = energy.towards(energy.places(plane))
    assert home.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(home.gradient(plane), problem.gradient(plane))


def test_a_spring_costs_the_square_of_how_far_it_is_drawn(pinned):
    problem, energy, plane = pinned
    drawn = STIFFNESS * (0.01**2 + 0.02**2 + 0.03**2 + 0.01**2)
    assert energy.energy(plane) - problem.energy(plane) == pytest.approx(drawn)


def test_the_gradient_is_the_energys(pinned):
    _, energy, plane = pinned
    gradient, h = energy.gradient(plane), 1e-6
    np.testing.assert_array_equal(gradient, energy.derivatives(plane)[0])
    touched = np.unique(SURFACE.faces[FACES])
    for k in [*(2 * touched), *(2 * touched + 1), 1, 40]:
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (energy.energy(plane + step) - energy.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-5, abs=1e-4)


def test_the_hessian_gains_the_springs_and_no_entry(pinned):
    problem, energy, plane = pinned
    alone, held = problem.derivatives(plane)[1], energy.derivatives(plane)[1]
    np.testing.assert_array_equal(alone.indices, held.indices)
    np.testing.assert_array_equal(alone.indptr, held.indptr)
    expected = np.zeros(alone.shape)
    for corners, weights in zip(SURFACE.faces[FACES], WEIGHTS, strict=True):
        for axis in range(2):
            at = 2 * corners + axis
            expected[np.ix_(at, at)] += 2 * STIFFNESS * np.outer(weights, weights)
    np.testing.assert_allclose((held - alone).toarray(), triu(expected).toarray(), atol=1e-9)


def test_where_pins_are_wanted_changes_no_hessian(pinned):
    _, energy, plane = pinned
    elsewhere = energy.towards(energy.goals + 0.1)
    np.testing.assert_array_equal(energy.derivatives(plane)[1].data, elsewhere.derivatives(plane)[1].data)
    assert (energy.goals + 0.1 == elsewhere.goals).all()


def test_at_the_least_energy_pins_are_close_to_their_goals(pinned):
    _, energy, plane = pinned
    *_, last = minimise(energy, plane)
    assert np.abs(energy.places(last.plane) - energy.goals).max() < 1e-3
    assert np.abs(energy.places(plane) - energy.goals).max() > 1e-2


def test_without_pins_it_is_the_energy_alone(pinned):
    problem, _, plane = pinned
    none = PinnedEnergy(problem, Springs(np.zeros((0, 3), dtype=int), np.zeros((0, 3))), np.zeros((0, 2)))
    assert none.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(none.derivatives(plane)[1].data, problem.derivatives(plane)[1].data)
    assert none.largest_step(plane, -plane) == problem.largest_step(plane, -plane)
