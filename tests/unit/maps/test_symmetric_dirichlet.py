"""The energy: its values, its derivatives, and a descent that never turns a triangle over."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.bijective import flipped
from app.maps.methods.tutte import tutte
from app.maps.symmetric_dirichlet import SymmetricDirichlet, rotation_svd
from tests.numerics.map_surfaces import cap, sheet


@pytest.fixture(params=[1.0, 0.3], ids=["lengths", "angles rather"])
def posed(request):
    surface = cap(1.0, rings=3, radius=1.0)
    problem = SymmetricDirichlet(surface.vertices, surface.faces, lengths=request.param)
    return problem, tutte(surface.vertices, surface.faces)


def full(upper):
    dense = upper.toarray()
    return dense + np.triu(dense, 1).T


def test_an_isometry_costs_four_and_a_stretch_what_the_formula_says():
    flat = sheet(width=1.2, height=0.8)
    problem = SymmetricDirichlet(flat.vertices, flat.faces)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    assert problem.energy(flat.vertices[:, :2] @ turn.T + 5) == pytest.approx(4, abs=1e-12)
    assert problem.energy(flat.vertices[:, :2] * [2, 0.5]) == pytest.approx(2 * (4 + 0.25), rel=1e-12)


def test_angles_alone_do_not_mind_size():
    flat = sheet()
    problem = SymmetricDirichlet(flat.vertices, flat.faces, lengths=0.0)
    assert problem.energy(7 * flat.vertices[:, :2]) == pytest.approx(4, abs=1e-12)
    assert problem.energy(flat.vertices[:, :2] * [2, 0.5]) == pytest.approx(2 * (4 + 0.25), rel=1e-12)


def test_a_flip_costs_infinitely_much():
    flat = sheet()
    problem = SymmetricDirichlet(flat.vertices, flat.faces)
    assert problem.energy(flat.vertices[:, :2] * [-1, 1]) == np.inf
    assert problem.energy(flat.vertices[:, :2] * [0, 1]) == np.inf


def test_the_gradient_is_the_energys(posed):
    problem, plane = posed
    gradient, _ = problem.derivatives(plane)
    h, differences = 1e-6, []
    for k in range(plane.size):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        differences.append((problem.energy(plane + step) - problem.energy(plane - step)) / (2 * h))
    np.testing.assert_allclose(gradient, differences, rtol=1e-6, atol=1e-8)


def test_where_nothing_is_negative_the_hessian_is_the_energys(posed):
    problem, plane = posed
    plane = 2.5 * plane  # stretched both ways, so that no mode needs to be set to zero
    assert np.linalg.svd(problem.jacobians(plane))[1].min() > 1
    _, hessian = problem.derivatives(plane)
    h, rows = 1e-6, []
    for k in range(plane.size):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        rows.append((problem.derivatives(plane + step)[0] - problem.derivatives(plane - step)[0]) / (2 * h))
    np.testing.assert_allclose(full(hessian), rows, atol=1e-6 * np.abs(rows).max())


def test_the_hessian_is_never_negative(posed):
    problem, plane = posed
    squeezed = plane * [0.3, 1.7]
    values = np.linalg.eigvalsh(full(problem.derivatives(squeezed)[1]))
    assert values.min() > -1e-10 * values.max()


def test_the_largest_step_ends_at_the_first_flip(posed):
    problem, plane = posed
    step = np.random.default_rng(1).normal(size=plane.shape)
    limit = problem.largest_step(plane, step)
    assert 0 < limit < np.inf
    assert not flipped(plane + 0.999999 * limit * step, problem.faces).any()
    assert flipped(plane + 1.000001 * limit * step, problem.faces).any()


def test_a_step_that_only_grows_has_no_limit(posed):
    problem, plane = posed
    assert problem.largest_step(plane, plane) == np.inf


def test_the_best_scale_is_the_best():
    surface = cap(1.0, rings=3, radius=1.0)
    problem = SymmetricDirichlet(surface.vertices, surface.faces)
    plane = tutte(surface.vertices, surface.faces)
    tried = min(problem.energy(scale * plane) for scale in np.linspace(0.2, 3, 2000))
    assert problem.energy_at_best_scale(plane) == pytest.approx(tried, rel=1e-6)
    assert problem.energy_at_best_scale(7 * plane) == pytest.approx(problem.energy_at_best_scale(plane), rel=1e-12)
    assert problem.energy_at_best_scale(plane * [-1, 1]) == np.inf


def test_the_gradient_alone_is_the_same(posed):
    problem, plane = posed
    np.testing.assert_array_equal(problem.gradient(plane), problem.derivatives(plane)[0])


def test_rotation_svd_rebuilds_every_matrix():
    matrices = np.random.default_rng(0).normal(size=(500, 2, 2))
    matrices = np.concatenate([matrices, [np.eye(2), np.zeros((2, 2)), [[0, 1], [1, 0]], [[1, 1], [1, 1 + 1e-12]]]])
    u, s, vt = rotation_svd(matrices)
    np.testing.assert_allclose(np.einsum("fij,fj,fjk->fik", u, s, vt), matrices, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(u), 1, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.det(vt), 1, rtol=1e-12)
    assert (s[:, 0] >= np.abs(s[:, 1])).all()
    assert s[-1, 1] == pytest.approx(5e-13, rel=1e-3), "the small value keeps its digits"
