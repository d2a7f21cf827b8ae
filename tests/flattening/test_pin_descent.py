"""Pins as springs, their moves spread over the map, and rounds that never go uphill or over a flip."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import triu

from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.pin_descent import STIFFNESS, PinDescent, PinnedEnergy, Springs, shepard_warp
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tests.support.surfaces import cap

SPRING_SURFACE = cap(1.0, rings=4, radius=0.6)
FACES = [0, 20, 60]
SPRING_WEIGHTS = np.array([[0.2, 0.3, 0.5], [1.0, 0.0, 0.0], [0.0, 0.5, 0.5]])


@pytest.fixture
def pinned():
    problem = SymmetricDirichlet(SPRING_SURFACE)
    plane = 1.1 * SPRING_SURFACE.vertices[:, :2]
    springs = Springs(SPRING_SURFACE.faces[FACES], SPRING_WEIGHTS)
    here = np.einsum("pc,pcd->pd", SPRING_WEIGHTS, plane[SPRING_SURFACE.faces[FACES]])
    return problem, PinnedEnergy(problem, springs, here + [[0.01, 0.0], [0.0, -0.02], [0.03, 0.01]]), plane


def test_pin_at_its_target_has_zero_energy(pinned):
    problem, energy, plane = pinned
    home = energy.towards(energy.places(plane))
    assert home.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(home.gradient(plane), problem.gradient(plane))


def test_spring_energy_is_quadratic_in_its_length(pinned):
    problem, energy, plane = pinned
    drawn = STIFFNESS * (0.01**2 + 0.02**2 + 0.03**2 + 0.01**2)
    assert energy.energy(plane) - problem.energy(plane) == pytest.approx(drawn)


def test_gradient_equals_the_derivative_of_the_energy(pinned):
    _, energy, plane = pinned
    gradient = energy.gradient(plane)
    h = 1e-6
    np.testing.assert_array_equal(gradient, energy.derivatives(plane)[0])
    touched = np.unique(SPRING_SURFACE.faces[FACES])
    for k in [*(2 * touched), *(2 * touched + 1), 1, 40]:
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (energy.energy(plane + step) - energy.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-5, abs=1e-4)


def test_springs_change_hessian_values_but_not_its_pattern(pinned):
    problem, energy, plane = pinned
    alone = problem.derivatives(plane)[1]
    held = energy.derivatives(plane)[1]
    np.testing.assert_array_equal(alone.indices, held.indices)
    np.testing.assert_array_equal(alone.indptr, held.indptr)
    expected = np.zeros(alone.shape)
    for corners, weights in zip(SPRING_SURFACE.faces[FACES], SPRING_WEIGHTS, strict=True):
        for axis in range(2):
            at = 2 * corners + axis
            expected[np.ix_(at, at)] += 2 * STIFFNESS * np.outer(weights, weights)
    np.testing.assert_allclose((held - alone).toarray(), triu(expected).toarray(), atol=1e-9)


def test_hessian_is_independent_of_pin_targets(pinned):
    _, energy, plane = pinned
    elsewhere = energy.towards(energy.goals + 0.1)
    np.testing.assert_array_equal(energy.derivatives(plane)[1].data, elsewhere.derivatives(plane)[1].data)
    assert (energy.goals + 0.1 == elsewhere.goals).all()


def test_pins_are_close_to_their_targets_at_the_minimum(pinned):
    _, energy, plane = pinned
    *_, last = minimise(energy, plane)
    assert np.abs(energy.places(last.plane) - energy.goals).max() < 1e-3
    assert np.abs(energy.places(plane) - energy.goals).max() > 1e-2


def test_pinned_energy_without_pins_equals_the_energy(pinned):
    problem, _, plane = pinned
    none = PinnedEnergy(problem, Springs(np.zeros((0, 3), dtype=int), np.zeros((0, 3))), np.zeros((0, 2)))
    assert none.energy(plane) == problem.energy(plane)
    np.testing.assert_array_equal(none.derivatives(plane)[1].data, problem.derivatives(plane)[1].data)
    assert none.largest_step(plane, -plane) == problem.largest_step(plane, -plane)


PLANE = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 2))


def test_pins_move_independently():
    places = PLANE[[3, 50, 120]]
    moves = np.array([[0.1, 0.0], [0.0, -0.2], [0.0, 0.0]])
    np.testing.assert_allclose(shepard_warp(PLANE, places, moves)[[3, 50, 120]], moves, atol=1e-9)


def test_common_move_of_all_pins_moves_every_point():
    np.testing.assert_allclose(shepard_warp(PLANE, PLANE[:4], np.full((4, 2), 0.3)), 0.3)


def test_no_point_moves_farther_than_the_pin_that_moves_most():
    moves = np.random.default_rng(1).normal(size=(5, 2))
    gone = shepard_warp(PLANE, PLANE[:5], moves)
    assert (gone <= moves.max(axis=0) + 1e-12).all()
    assert (gone >= moves.min(axis=0) - 1e-12).all()


def test_near_a_pin_the_map_moves_rigidly():
    near = PLANE[3] + [[1e-3, 0.0], [0.0, -1e-3]]
    gone = shepard_warp(near, PLANE[[3, 50]], np.array([[0.1, 0.0], [0.0, 0.0]]))
    np.testing.assert_allclose(gone, [[0.1, 0.0]] * 2, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("turn", [0.3, 2.0])
def test_rotated_map_moves_in_the_same_way(turn):
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    moves = np.array([[0.1, 0.2], [-0.1, 0.0]])
    straight = shepard_warp(PLANE, PLANE[:2], moves) @ rotation
    np.testing.assert_allclose(
        shepard_warp(PLANE @ rotation, PLANE[:2] @ rotation, moves @ rotation), straight, atol=1e-12
    )


SURFACE = cap(1.0, rings=8, radius=0.6)
CORNERS = SURFACE.faces[[0, 200, 320]]
WEIGHTS = np.full((3, 3), 1 / 3)


@pytest.fixture(scope="module")
def rest():
    problem = SymmetricDirichlet(SURFACE)
    *_, last = minimise(problem, SURFACE.vertices[:, :2])
    return problem, last.plane


def target(rest, *moves):
    problem, plane = rest
    here = np.einsum("pc,pcd->pd", WEIGHTS, plane[CORNERS])
    return PinnedEnergy(problem, Springs(CORNERS, WEIGHTS), here + np.array(moves))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("far", [0.01, 0.1, 0.4, 5.0])
def test_every_round_lowers_the_energy_without_flips(rest, far):
    energy = target(rest, (far, 0.0), (0.0, 0.0), (0.0, 0.0))
    descent = PinDescent(rest[1])
    before = energy.energy(descent.plane)
    for _ in range(30):
        gain = descent.round(energy)
        after = energy.energy(descent.plane)
        assert gain == pytest.approx(before - after, abs=1e-9 * before)
        assert gain >= 0
        assert not flipped(descent.plane, SURFACE.faces).any()
        before = after
    assert before < energy.energy(rest[1])


def test_descent_ends_at_the_minimum_of_newtons_method(rest):
    energy = target(rest, (0.2, 0.1), (0.0, 0.0), (0.0, 0.0))
    descent = PinDescent(rest[1])
    *_, best = minimise(energy, rest[1], tolerance=1e-10)
    for _ in range(40):
        descent.round(energy)
    assert energy.energy(descent.plane) == pytest.approx(best.energy, rel=1e-6)


def test_distant_pin_is_followed_in_steps_of_the_reach(rest):
    energy = target(rest, (0.4, 0.0), (0.0, 0.0), (0.0, 0.0))
    descent = PinDescent(rest[1])
    reach = descent._reach
    before = energy.places(descent.plane)[0]
    descent.round(energy)
    gone = np.linalg.norm(energy.places(descent.plane)[0] - before)
    assert 0 < gone < 1.5 * reach < 0.4


@pytest.mark.parametrize("slant", [0.0, 0.3, 1.1])
def test_moving_a_converged_map_does_not_shorten_the_reach(rest, slant):
    """All that a step could still gain is rounding there: luck of the last digits must not slow the pins."""
    descent = PinDescent(rest[1])
    reach = PinDescent(rest[1])._reach
    for step in range(1, 41):
        way = 0.03 * step * np.array([np.cos(slant), np.sin(slant)])
        energy = target(rest, way, way, way)
        descent.round(energy)
        assert descent._reach >= reach
    assert np.abs(energy.places(descent.plane) - energy.goals).max() < 1e-3


def test_factorisation_is_reused_for_several_steps(rest):
    asked = []

    class Counted(SymmetricDirichlet):
        def derivatives(self, plane):
            asked.append(1)
            return super().derivatives(plane)

    counted = Counted(SURFACE)
    descent = PinDescent(rest[1])
    for step in range(20):
        descent.round(target((counted, rest[1]), (0.002 * step, 0.0), (0.0, 0.0), (0.0, 0.0)))
    assert 1 <= len(asked) < 8
    descent.forget()
    known = len(asked)
    descent.round(target((counted, rest[1]), (0.05, 0.0), (0.0, 0.0), (0.0, 0.0)))
    assert len(asked) == known + 1


def test_map_is_unchanged_if_no_step_is_possible(rest):
    class Singular(SymmetricDirichlet):
        def derivatives(self, plane):
            gradient, hessian = super().derivatives(plane)
            return gradient, 0 * hessian

    singular = Singular(SURFACE)
    energy = PinnedEnergy(singular, Springs(CORNERS[:0], WEIGHTS[:0]), np.zeros((0, 2)))
    descent = PinDescent(1.2 * rest[1])
    assert descent.round(energy) == 0.0
    np.testing.assert_array_equal(descent.plane, 1.2 * rest[1])


def test_descent_does_not_cross_a_barrier(rest):
    class Wall:
        def __init__(self, energy):
            self._inner = energy
            self.gradient = energy.gradient
            self.derivatives = energy.derivatives
            self.largest_step = energy.largest_step

        def energy(self, plane):
            return self._inner.energy(plane) if plane[:, 0].max() < 0.62 else np.inf

    assert rest[1][:, 0].max() < 0.62
    all_right = target(rest, (0.4, 0.0), (0.4, 0.0), (0.4, 0.0))
    free = PinDescent(rest[1])
    held = PinDescent(rest[1], barrier=Wall)
    for _ in range(20):
        free.round(all_right)
        held.round(all_right)
    assert free.plane[:, 0].max() > 0.7
    assert held.plane[:, 0].max() < 0.62
