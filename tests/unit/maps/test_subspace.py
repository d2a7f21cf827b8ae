"""The projected Hessian is the product of three matrices, entry by entry."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix, identity, kron, triu

from app.maps.flatten import flatten
from app.maps.proxy import build_proxy
from app.maps.subspace import Subspace
from app.maps.symmetric_dirichlet import SymmetricDirichlet
from tests.numerics.map_surfaces import cap, sheet


def random_weights(fine, coarse, seed):
    rng = np.random.default_rng(seed)
    columns = np.sort(rng.permuted(np.tile(np.arange(coarse), (fine, 1)), axis=1)[:, :3], axis=1)
    weights = rng.uniform(-0.2, 1.0, (fine, 3))
    weights[::4] = [1.0, 0.0, 0.0]
    return csr_matrix((weights.ravel(), columns.ravel(), 3 * np.arange(fine + 1)), shape=(fine, coarse))


def expected(carried, hessian):
    whole, spread = hessian + triu(hessian, 1).T, kron(carried, identity(2))
    return triu(spread.T @ whole @ spread).toarray()


@pytest.mark.parametrize("seed", range(3))
def test_any_weights(seed):
    surface = cap(1.0, rings=3, radius=0.6)
    problem = SymmetricDirichlet(surface.vertices, surface.faces)
    carried = random_weights(len(surface.vertices), 9, seed)
    first = problem.derivatives(surface.vertices[:, :2])[1]
    subspace = Subspace(carried, first)
    for plane in (surface.vertices[:, :2], surface.vertices[:, :2] * [1.3, 0.7]):
        hessian = problem.derivatives(plane)[1]
        small = subspace.project(hessian)
        reference = expected(carried, hessian)
        np.testing.assert_allclose(small.toarray(), reference, atol=1e-12 * np.abs(reference).max())
        assert small.has_sorted_indices


def test_a_stand_ins_weights():
    surface = sheet(24, 18, shape=lambda x, y: 0.02 * np.sin(40 * x))
    chart = flatten(surface)
    carried = build_proxy(surface, chart, faces=120).carried
    problem = SymmetricDirichlet(surface.vertices[chart.vertex_of], chart.faces)
    hessian = problem.derivatives(chart.plane)[1]
    reference = expected(carried, hessian)
    small = Subspace(carried, hessian).project(hessian).toarray()
    np.testing.assert_allclose(small, reference, atol=1e-12 * np.abs(reference).max())
