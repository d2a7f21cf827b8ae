"""Rounds after moving pins: downhill, valid, in reaches, and to the same end as Newton's minimiser."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.bijective import flipped
from app.maps.newton import minimise
from app.maps.pin_descent import PinDescent
from app.maps.pinned_energy import PinnedEnergy, Springs
from app.maps.symmetric_dirichlet import SymmetricDirichlet
from tests.numerics.map_surfaces import cap

SURFACE = cap(1.0, rings=8, radius=0.6)
CORNERS = SURFACE.faces[[0, 200, 320]]
WEIGHTS = np.full((3, 3), 1 / 3)


@pytest.fixture(scope="module")
def rest():
    problem = SymmetricDirichlet(SURFACE.vertices, SURFACE.faces)
    *_, last = minimise(problem, SURFACE.vertices[:, :2])
    return problem, last.plane


def wanted(rest, *moves):
    problem, plane = rest
    here = np.einsum("pc,pcd->pd", WEIGHTS, plane[CORNERS])
    return PinnedEnergy(problem, Springs(CORNERS, WEIGHTS), here + np.array(moves))


@pytest.mark.parametrize("far", [0.01, 0.1, 0.4, 5.0])
def test_every_round_goes_downhill_and_flips_nothing(rest, far):
    energy, descent = wanted(rest, (far, 0.0), (0.0, 0.0), (0.0, 0.0)), PinDescent(rest[1])
    before = energy.energy(descent.plane)
    for _ in range(30):
        gain = descent.round(energy)
        after = energy.energy(descent.plane)
        assert gain == pytest.approx(before - after, abs=1e-9 * before)
        assert gain >= 0
        assert not flipped(descent.plane, SURFACE.faces).any()
        before = after
    assert before < energy.energy(rest[1])


def test_it_ends_where_newtons_minimiser_does(rest):
    energy, descent = wanted(rest, (0.2, 0.1), (0.0, 0.0), (0.0, 0.0)), PinDescent(rest[1])
    *_, best = minimise(energy, rest[1], tolerance=1e-10)
    for _ in range(40):
        descent.round(energy)
    assert energy.energy(descent.plane) == pytest.approx(best.energy, rel=1e-6)


def test_a_far_pin_is_followed_in_reaches(rest):
    energy, descent = wanted(rest, (0.4, 0.0), (0.0, 0.0), (0.0, 0.0)), PinDescent(rest[1])
    reach, before = descent.reach, energy.places(descent.plane)[0]
    descent.round(energy)
    gone = np.linalg.norm(energy.places(descent.plane)[0] - before)
    assert 0 < gone < 1.5 * reach < 0.4


def test_one_factorisation_serves_several_rounds(rest):
    asked = []

    class Counted(SymmetricDirichlet):
        def derivatives(self, plane):
            asked.append(1)
            return super().derivatives(plane)

    counted = Counted(SURFACE.vertices, SURFACE.faces)
    descent = PinDescent(rest[1])
    for step in range(20):
        descent.round(wanted((counted, rest[1]), (0.002 * step, 0.0), (0.0, 0.0), (0.0, 0.0)))
    assert 1 <= len(asked) < 8
    descent.forget()
    known = len(asked)
    descent.round(wanted((counted, rest[1]), (0.05, 0.0), (0.0, 0.0), (0.0, 0.0)))
    assert len(asked) == known + 1


def test_where_no_step_is_possible_the_map_stays(rest):
    class Singular(SymmetricDirichlet):
        def derivatives(self, plane):
            gradient, hessian = super().derivatives(plane)
            return gradient, 0 * hessian

    singular = Singular(SURFACE.vertices, SURFACE.faces)
    energy = PinnedEnergy(singular, Springs(CORNERS[:0], WEIGHTS[:0]), np.zeros((0, 2)))
    descent = PinDescent(1.2 * rest[1])
    assert descent.round(energy) == 0.0
    np.testing.assert_array_equal(descent.plane, 1.2 * rest[1])


def test_a_barrier_is_minded(rest):
    class Wall:
        def __init__(self, energy):
            self._inner = energy
            self.gradient, self.derivatives, self.largest_step = (
                energy.gradient, energy.derivatives, energy.largest_step,
            )  # fmt: skip

        def energy(self, plane):
            return self._inner.energy(plane) if plane[:, 0].max() < 0.62 else np.inf

    assert rest[1][:, 0].max() < 0.62
    all_right = wanted(rest, (0.4, 0.0), (0.4, 0.0), (0.4, 0.0))
    free, held = PinDescent(rest[1]), PinDescent(rest[1], barrier=Wall)
    for _ in range(20):
        free.round(all_right)
        held.round(all_right)
    assert free.plane[:, 0].max() > 0.7
    assert held.plane[:, 0].max() < 0.62
