"""The whole map's energy, seen from few vertices: the same numbers, the same derivatives, the same last step."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.carried_energy import CarriedEnergy
from app.maps.flatten import flatten
from app.maps.newton import minimise
from app.maps.proxy import build_proxy
from app.maps.symmetric_dirichlet import SymmetricDirichlet
from tests.numerics.map_surfaces import sheet


@pytest.fixture(scope="module")
def carried():
    surface = sheet(30, 20, shape=lambda x, y: 0.02 * np.sin(50 * x) * np.cos(40 * y))
    chart = flatten(surface)
    proxy = build_proxy(surface, chart, faces=150)
    problem = SymmetricDirichlet(surface.vertices[chart.vertex_of], chart.faces)
    return problem, proxy, CarriedEnergy(problem, proxy.carried), proxy.plane * [1.1, 0.95]


def test_it_is_the_whole_maps(carried):
    problem, proxy, energy, plane = carried
    step = 0.3 * plane[::-1]
    assert energy.energy(plane) == problem.energy(proxy.carried @ plane)
    assert energy.largest_step(plane, step) == problem.largest_step(proxy.carried @ plane, proxy.carried @ step)
    assert energy.energy(-plane * [1, -1]) == np.inf


def test_the_gradient_is_the_energys(carried):
    _, _, energy, plane = carried
    gradient, h = energy.gradient(plane), 1e-8
    np.testing.assert_array_equal(gradient, energy.derivatives(plane)[0])
    for k in range(0, plane.size, 9):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (energy.energy(plane + step) - energy.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-4, abs=1e-3)


def test_the_hessian_is_never_negative_and_keeps_its_pattern(carried):
    _, _, energy, plane = carried
    first, second = energy.derivatives(plane)[1], energy.derivatives(1.2 * plane)[1]
    assert first.indices is second.indices or (first.indices == second.indices).all()
    values = np.linalg.eigvalsh(first.toarray(), UPLO="U")
    assert values.min() > -1e-9 * values.max()


def test_its_least_is_close_to_the_whole_maps(carried):
    problem, proxy, energy, plane = carried
    *_, few = minimise(energy, plane)
    *_, all_ = minimise(problem, proxy.carried @ plane)
    assert energy.energy(plane) > all_.energy + 0.02
    assert all_.energy <= few.energy < all_.energy + 0.002
