"""Newton's method: the energy never increases, no triangle flips, it ends at a minimum and counts its work."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.initial_map import tutte
from tactile_maps.flattening.newton import DescentStopped, minimise
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tests.support.surfaces import cap, sheet


@pytest.fixture(params=[1.0, 0.1], ids=["lengths", "angles rather"])
def posed(request):
    surface = cap(1.0, rings=3, radius=1.0)
    problem = SymmetricDirichlet(surface, lengths=request.param)
    return problem, tutte(surface)


def test_energy_decreases_every_round_and_time_is_recorded(posed):
    problem, plane = posed
    ticks = iter(range(1000))
    rounds = list(minimise(problem, 0.3 * plane, clock=lambda: next(ticks)))
    energies = [r.energy for r in rounds]
    assert len(rounds) > 3
    assert all(b < a for a, b in pairwise(energies))
    assert [r.seconds for r in rounds] == sorted(r.seconds for r in rounds)
    assert np.abs(problem.derivatives(rounds[-1].plane)[0]).max() < 1e-4


def test_start_with_flips_is_rejected(posed):
    problem, plane = posed
    with pytest.raises(MapError, match="flipped"):
        next(minimise(problem, plane * [-1, 1]))


def test_descent_without_convergence_raises_after_its_last_map(posed):
    problem, plane = posed
    short = minimise(problem, 0.3 * plane, rounds=1)
    rounds = []

    def follow():
        for reached in short:
            rounds.append(reached.energy)  # noqa: PERF401, it ends by an error

    with pytest.raises(DescentStopped, match="1 factorisations"):
        follow()
    whole = [reached.energy for reached in minimise(problem, 0.3 * plane)]
    assert rounds == whole[: len(rounds)]
    assert 1 < len(rounds) < len(whole)


def test_values_of_very_different_size_raise_a_clear_error():
    flat = sheet(1, 1)

    class Singular(SymmetricDirichlet):
        def derivatives(self, plane):
            gradient, hessian = super().derivatives(plane)
            return gradient, 0 * hessian

    with pytest.raises(MapError, match="too distorted"):
        list(minimise(Singular(flat), 3 * flat.vertices[:, :2]))


def test_no_step_flips_a_triangle(posed):
    problem, plane = posed
    assert not any(flipped(r.plane, problem.faces).any() for r in minimise(problem, plane * [0.1, 1.0]))


def test_factorisation_is_reused_for_several_steps(posed):
    problem, plane = posed
    asked = []

    class Counted(SymmetricDirichlet):
        def derivatives(self, plane):
            asked.append(1)
            return problem.derivatives(plane)

    surface = cap(1.0, rings=3, radius=1.0)
    counted = Counted(surface)
    if problem.energy(2 * plane) == counted.energy(2 * plane):
        rounds = list(minimise(counted, 0.3 * plane))
        assert len(asked) < len(rounds) - 1
