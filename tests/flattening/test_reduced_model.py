"""The coarse cage carries the fine map exactly, and the reduced energy is the whole map's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity, kron, triu

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.cut import SeamPlan, shortest_edge_path
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.reduced_model import GalerkinProjection, ReducedEnergy, build_coarse_cage
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.mesh import Mesh
from tests.support.surfaces import cap, frustum, sheet, torus


def random_weights(fine, coarse, seed):
    rng = np.random.default_rng(seed)
    columns = np.sort(rng.permuted(np.tile(np.arange(coarse), (fine, 1)), axis=1)[:, :3], axis=1)
    weights = rng.uniform(-0.2, 1.0, (fine, 3))
    weights[::4] = [1.0, 0.0, 0.0]
    return csr_matrix((weights.ravel(), columns.ravel(), 3 * np.arange(fine + 1)), shape=(fine, coarse))


def expected(carried, hessian):
    whole = hessian + triu(hessian, 1).T
    spread = kron(carried, identity(2))
    return triu(spread.T @ whole @ spread).toarray()


@pytest.mark.parametrize("seed", range(3))
def test_projection_with_random_weights_equals_the_dense_product(seed):
    surface = cap(1.0, rings=3, radius=0.6)
    problem = SymmetricDirichlet(surface)
    carried = random_weights(len(surface.vertices), 9, seed)
    first = problem.derivatives(surface.vertices[:, :2])[1]
    subspace = GalerkinProjection(carried, first)
    for plane in (surface.vertices[:, :2], surface.vertices[:, :2] * [1.3, 0.7]):
        hessian = problem.derivatives(plane)[1]
        small = subspace.project(hessian)
        reference = expected(carried, hessian)
        np.testing.assert_allclose(small.toarray(), reference, atol=1e-12 * np.abs(reference).max())
        assert small.has_sorted_indices


def test_projection_with_cage_weights_equals_the_dense_product():
    surface = sheet(24, 18, shape=lambda x, y: 0.02 * np.sin(40 * x))
    chart = flatten(surface)
    carried = build_coarse_cage(surface, chart, faces=120).carried
    problem = SymmetricDirichlet(Mesh(surface.vertices[chart.vertex_of], chart.faces))
    hessian = problem.derivatives(chart.plane)[1]
    reference = expected(carried, hessian)
    small = GalerkinProjection(carried, hessian).project(hessian).toarray()
    np.testing.assert_allclose(small, reference, atol=1e-12 * np.abs(reference).max())


@pytest.fixture(scope="module")
def carried():
    surface = sheet(30, 20, shape=lambda x, y: 0.02 * np.sin(50 * x) * np.cos(40 * y))
    chart = flatten(surface)
    cage = build_coarse_cage(surface, chart, faces=150)
    problem = SymmetricDirichlet(Mesh(surface.vertices[chart.vertex_of], chart.faces))
    return problem, cage, ReducedEnergy(problem, cage.carried), cage.plane * [1.1, 0.95]


def test_reduced_energy_equals_that_of_the_whole_map(carried):
    problem, cage, energy, plane = carried
    step = 0.3 * plane[::-1]
    assert energy.energy(plane) == problem.energy(cage.carried @ plane)
    assert energy.largest_step(plane, step) == problem.largest_step(cage.carried @ plane, cage.carried @ step)
    assert energy.energy(-plane * [1, -1]) == np.inf


def test_gradient_equals_the_derivative_of_the_energy(carried):
    _, _, energy, plane = carried
    gradient = energy.gradient(plane)
    h = 1e-8
    np.testing.assert_array_equal(gradient, energy.derivatives(plane)[0])
    for k in range(0, plane.size, 9):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        slope = (energy.energy(plane + step) - energy.energy(plane - step)) / (2 * h)
        assert gradient[k] == pytest.approx(slope, rel=1e-4, abs=1e-3)


def test_hessian_is_positive_semidefinite_and_keeps_its_pattern(carried):
    _, _, energy, plane = carried
    first = energy.derivatives(plane)[1]
    second = energy.derivatives(1.2 * plane)[1]
    assert first.indices is second.indices or (first.indices == second.indices).all()
    values = np.linalg.eigvalsh(first.toarray(), UPLO="U")
    assert values.min() > -1e-9 * values.max()


def test_minimum_of_reduced_model_is_close_to_that_of_the_whole_map(carried):
    problem, cage, energy, plane = carried
    *_, few = minimise(energy, plane)
    *_, all_ = minimise(problem, cage.carried @ plane)
    assert energy.energy(plane) > all_.energy + 0.02
    assert all_.energy <= few.energy < all_.energy + 0.002


SURFACES = {
    "wavy sheet": lambda: sheet(50, 40, shape=lambda x, y: 0.01 * np.sin(60 * x) * np.cos(50 * y)),
    "tube": lambda: frustum(around=60, along=40),
    "deep cap": lambda: cap(2.4, rings=24),
    "torus": lambda: torus(around=60, across=30),
}


@pytest.fixture(scope="module", params=SURFACES)
def made(request):
    surface = SURFACES[request.param]()
    chart = flatten(surface)
    return surface, chart, build_coarse_cage(surface, chart, faces=400, name=request.param)


@pytest.mark.long
def test_cage_is_a_coarse_disk_without_flips(made):
    _, chart, cage = made
    assert 200 < len(cage.surface.faces) < 600 < len(chart.faces)
    assert cage.surface.connectivity.euler_characteristic == len(cage.surface.connectivity.boundary_loops) == 1
    assert not flipped(cage.plane, cage.surface.faces).any()


def test_reduced_model_reproduces_its_map_and_affine_maps_exactly(made):
    _, chart, cage = made
    size = np.abs(chart.plane).max()
    np.testing.assert_allclose(cage.carried @ cage.plane, chart.plane, atol=1e-12 * size)
    np.testing.assert_array_equal(cage.plane, chart.plane[cage.chosen])
    affine = np.array([[1.2, 0.3], [-0.4, 0.8]])
    np.testing.assert_allclose(
        cage.carried @ (cage.plane @ affine + 1.0), chart.plane @ affine + 1.0, atol=1e-12 * (1 + size)
    )


def test_cage_vertices_are_vertices_of_the_patch(made):
    surface, chart, cage = made
    np.testing.assert_array_equal(cage.surface.vertices, surface.vertices[chart.vertex_of[cage.chosen]])
    np.testing.assert_array_equal(cage.owners[cage.chosen], np.arange(len(cage.chosen)))


def test_pin_has_the_same_place_in_coarse_faces(made):
    _, chart, cage = made
    rng = np.random.default_rng(0)
    corners = chart.faces[rng.integers(len(chart.faces), size=50)]
    weights = rng.dirichlet(np.ones(3), 50)
    coarse, shares = cage.held(corners, weights)
    there = np.einsum("qc,qcd->qd", shares, cage.plane[coarse])
    here = np.einsum("qc,qcd->qd", weights, chart.plane[corners])
    np.testing.assert_allclose(there, here, atol=1e-12)
    assert cage.held(corners[:0], weights[:0])[0].shape == (0, 3)


@pytest.mark.long
def test_sides_of_a_slit_belong_to_different_cage_vertices():
    flat = sheet(40, 30)
    path = shortest_edge_path(flat, [int(np.argmin(np.linalg.norm(flat.vertices - p, axis=1))) for p in _SLIT])
    chart = flatten(flat, seams=SeamPlan(extra=0, drawn=path))
    doubled = np.flatnonzero(np.bincount(chart.vertex_of) == 2)
    assert len(doubled) > 10, "the slit has two sides"
    cage = build_coarse_cage(flat, chart, faces=300)
    owners = cage.owners[np.array([np.flatnonzero(chart.vertex_of == v) for v in doubled])]
    assert len(np.unique(owners[:, 0])) > 2
    assert not np.isin(owners[:, 0], owners[:, 1]).any()


_SLIT = ((0.06, 0.0, 0.0), (0.06, 0.05, 0.0))


def test_map_without_valid_cage_is_rejected():
    strip = sheet(300, 1, width=1.0, height=0.001)
    chart = Chart(strip.faces, strip.vertices[:, :2], np.arange(len(strip.vertices)), np.zeros((0, 2)), "by hand")
    with pytest.raises(MapError, match="no valid coarse cage"):
        build_coarse_cage(strip, chart, faces=50, name="strip")
