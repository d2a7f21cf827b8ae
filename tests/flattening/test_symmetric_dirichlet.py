"""The symmetric Dirichlet energy: rest shapes, derivatives by finite differences, the Hessian and its pattern."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.initial_map import tutte
from tactile_maps.flattening.symmetric_dirichlet import (
    HessianPattern,
    SymmetricDirichlet,
    rest_triangles,
    rotation_svd,
)
from tactile_maps.geometry.surface.connectivity import Connectivity
from tests.support.surfaces import cap, frustum, named, sheet


def _sides(rest):
    second = np.hypot(rest.along - rest.base, rest.across)
    return np.stack([rest.base, second, np.hypot(rest.along, rest.across)], axis=1)


def test_sides_and_areas_match_the_surface():
    surface = named("bumpy tube")
    rest = rest_triangles(surface.vertices, surface.faces)
    corners = surface.vertices[surface.faces]
    expected = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    np.testing.assert_allclose(_sides(rest), expected, rtol=1e-12)
    np.testing.assert_allclose(rest.areas, surface.face_areas, rtol=1e-12)
    assert rest.mollified == 0


@pytest.mark.parametrize(
    "corners",
    [
        [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        [[0, 0, 0], [0, 0, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 0]],
        [[1, 0, 0], [0, 0, 0], [0, 0, 0]],
        [[2, 2, 2], [2, 2, 2], [2, 2, 2]],
        [[0, 0, 0], [1, 0, 0], [0.5, 1e-9, 0]],
    ],
)
def test_face_with_zero_area_gets_a_small_area(corners):
    good = np.array([[0, 0, 1.0], [1, 0, 1], [0, 1, 1]])
    positions = np.concatenate([good, np.array(corners, dtype=float)])
    rest = rest_triangles(positions, np.array([[0, 1, 2], [3, 4, 5]]))
    assert rest.mollified == 1
    assert rest.areas[0] == 0.5, "its neighbours keep their shape"
    assert 0 < rest.areas[1] < 0.02
    assert np.isfinite([rest.base, rest.along, rest.across]).all()


@pytest.mark.parametrize("surface", [cap(1.0, rings=3), frustum(around=5, along=2)], ids=["disk", "tube"])
def test_assembled_matrix_equals_the_upper_triangle_of_the_dense_sum(surface):
    faces = surface.faces
    count = len(surface.vertices)
    generator = np.random.default_rng(0)
    local = generator.normal(size=(len(faces), 6, 6))
    local += local.swapaxes(1, 2)
    dense = np.zeros((2 * count, 2 * count))
    for face, block in zip(faces, local, strict=True):
        dofs = (2 * face[:, None] + np.arange(2)).ravel()
        dense[np.ix_(dofs, dofs)] += block
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    blocks = {(a, b): tuple(local[:, 2 * a + i, 2 * b + j] for i, j in product(range(2), repeat=2)) for a, b in pairs}
    matrix = HessianPattern(Connectivity(faces), count).matrix(blocks)
    np.testing.assert_allclose(matrix.toarray(), np.triu(dense), atol=1e-12)
    for column in range(matrix.shape[1]):
        rows = matrix.indices[matrix.indptr[column] : matrix.indptr[column + 1]]
        assert (np.diff(rows) > 0).all()
        assert rows[-1] == column


def test_every_matrix_shares_one_pattern():
    surface = cap(1.0, rings=2)
    pattern = HessianPattern(surface.connectivity, len(surface.vertices))
    ones = np.ones(len(surface.faces))
    blocks = dict.fromkeys(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)), (ones,) * 4)
    first = pattern.matrix(blocks)
    second = pattern.matrix(blocks)
    assert first.indices.ctypes.data == second.indices.ctypes.data


@pytest.fixture(params=[1.0, 0.3], ids=["lengths", "angles rather"])
def posed(request):
    surface = cap(1.0, rings=3, radius=1.0)
    problem = SymmetricDirichlet(surface, lengths=request.param)
    return problem, tutte(surface)


def full(upper):
    dense = upper.toarray()
    return dense + np.triu(dense, 1).T


def test_energy_is_four_for_an_isometry_and_follows_the_formula_for_stretch():
    flat = sheet(width=1.2, height=0.8)
    problem = SymmetricDirichlet(flat)
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    assert problem.energy(flat.vertices[:, :2] @ turn.T + 5) == pytest.approx(4, abs=1e-12)
    assert problem.energy(flat.vertices[:, :2] * [2, 0.5]) == pytest.approx(2 * (4 + 0.25), rel=1e-12)


def test_energy_of_angles_alone_is_independent_of_scale():
    flat = sheet()
    problem = SymmetricDirichlet(flat, lengths=0.0)
    assert problem.energy(7 * flat.vertices[:, :2]) == pytest.approx(4, abs=1e-12)
    assert problem.energy(flat.vertices[:, :2] * [2, 0.5]) == pytest.approx(2 * (4 + 0.25), rel=1e-12)


def test_flipped_triangle_has_infinite_energy():
    flat = sheet()
    problem = SymmetricDirichlet(flat)
    assert problem.energy(flat.vertices[:, :2] * [-1, 1]) == np.inf
    assert problem.energy(flat.vertices[:, :2] * [0, 1]) == np.inf


def test_gradient_equals_the_derivative_of_the_energy(posed):
    problem, plane = posed
    gradient, _ = problem.derivatives(plane)
    h = 1e-6
    differences = []
    for k in range(plane.size):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        differences.append((problem.energy(plane + step) - problem.energy(plane - step)) / (2 * h))
    np.testing.assert_allclose(gradient, differences, rtol=1e-6, atol=1e-8)


def test_hessian_without_negative_modes_equals_the_second_derivative_of_the_energy(posed):
    problem, plane = posed
    plane = 2.5 * plane  # stretched both ways, so that no mode needs to be set to zero
    assert np.linalg.svd(problem.jacobians(plane))[1].min() > 1
    _, hessian = problem.derivatives(plane)
    h = 1e-6
    rows = []
    for k in range(plane.size):
        step = np.zeros(plane.size)
        step[k] = h
        step = step.reshape(-1, 2)
        rows.append((problem.derivatives(plane + step)[0] - problem.derivatives(plane - step)[0]) / (2 * h))
    np.testing.assert_allclose(full(hessian), rows, atol=1e-6 * np.abs(rows).max())


def test_hessian_is_positive_semidefinite(posed):
    problem, plane = posed
    squeezed = plane * [0.3, 1.7]
    values = np.linalg.eigvalsh(full(problem.derivatives(squeezed)[1]))
    assert values.min() > -1e-10 * values.max()


def test_largest_step_ends_at_the_first_flip(posed):
    problem, plane = posed
    step = np.random.default_rng(1).normal(size=plane.shape)
    limit = problem.largest_step(plane, step)
    assert 0 < limit < np.inf
    assert not flipped(plane + 0.999999 * limit * step, problem.faces).any()
    assert flipped(plane + 1.000001 * limit * step, problem.faces).any()


def test_step_that_only_enlarges_triangles_has_no_limit(posed):
    problem, plane = posed
    assert problem.largest_step(plane, plane) == np.inf


def test_best_scale_minimizes_the_energy():
    surface = cap(1.0, rings=3, radius=1.0)
    problem = SymmetricDirichlet(surface)
    plane = tutte(surface)
    tried = min(problem.energy(scale * plane) for scale in np.linspace(0.2, 3, 2000))
    assert problem.energy_at_best_scale(plane) == pytest.approx(tried, rel=1e-6)
    assert problem.energy_at_best_scale(7 * plane) == pytest.approx(problem.energy_at_best_scale(plane), rel=1e-12)
    assert problem.energy_at_best_scale(plane * [-1, 1]) == np.inf


def test_gradient_without_hessian_equals_gradient_with_hessian(posed):
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
