"""Factorised systems: correct solution, reuse of the pattern, and a named error for singular systems."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_matrix, diags, random, triu

from tactile_maps.core import sparse_ldl
from tactile_maps.core.sparse_ldl import SparseLDL


@pytest.fixture(params=["by columns", "supernodal"], autouse=True)
def library(request, monkeypatch):
    """Every promise holds for both libraries, on small systems too."""
    monkeypatch.setattr(sparse_ldl, "SUPERNODAL_FROM", 1 if request.param == "supernodal" else 10**9)
    monkeypatch.setattr(sparse_ldl, "SUPERNODAL_FILL", 0.0)


def _upper(matrix) -> csc_matrix:
    upper = csc_matrix(triu(csc_matrix(matrix)))
    upper.sort_indices()
    return upper


@pytest.fixture
def positive():
    noise = random(40, 40, density=0.1, random_state=np.random.default_rng(0)).toarray()
    return noise @ noise.T + np.eye(40)


@pytest.mark.parametrize("columns", [(), (2,)])
def test_solution_equals_that_of_dense_algebra(positive, columns):
    right = np.random.default_rng(1).normal(size=(40, *columns))
    factor = SparseLDL()
    factor.update(_upper(positive))
    np.testing.assert_allclose(factor.solve(right), np.linalg.solve(positive, right), rtol=1e-10)


def test_new_values_in_the_same_pattern_are_used(positive):
    upper = _upper(positive)
    factor = SparseLDL()
    factor.update(upper)
    again = csc_matrix((3 * upper.data, upper.indices, upper.indptr), shape=upper.shape)
    factor.update(again)
    np.testing.assert_allclose(factor.solve(np.ones(40)), np.linalg.solve(3 * positive, np.ones(40)), rtol=1e-10)


def test_new_pattern_is_analysed_again(positive):
    factor = SparseLDL()
    factor.update(_upper(positive))
    factor.update(_upper(np.diag(np.arange(1.0, 5.0))))
    np.testing.assert_allclose(factor.solve(np.ones(4)), 1 / np.arange(1.0, 5.0))


@pytest.mark.parametrize("matrix", [np.ones((2, 2)), np.full((2, 2), np.nan), np.diag([1.0, np.inf])])
def test_singular_matrix_raises_arithmetic_error(matrix):
    with pytest.raises(ArithmeticError):
        SparseLDL().update(_upper(matrix))


def test_solving_without_factored_matrix_raises_arithmetic_error(positive):
    factor = SparseLDL()
    with pytest.raises(ArithmeticError, match="no factored matrix"):
        factor.solve(np.ones(40))
    factor.update(_upper(positive))
    with pytest.raises(ArithmeticError):
        factor.update(_upper(np.ones((2, 2))))
    with pytest.raises(ArithmeticError, match="no factored matrix"):
        factor.solve(np.ones(40))


@pytest.mark.parametrize(
    ("rows", "columns", "kind"),
    [(30, 30, "_ByColumns"), (120, 120, "_Supernodal"), (4, 3000, "_ByColumns")],
    ids=["small", "square", "strip"],
)
def test_supernodes_are_used_for_large_matrices_with_fill_in(monkeypatch, rows, columns, kind):
    monkeypatch.undo()
    factor = SparseLDL()
    matrix = _grid(rows, columns)
    factor.update(_upper(matrix))
    assert isinstance(factor._solver, getattr(sparse_ldl, kind))
    right = np.random.default_rng(2).normal(size=rows * columns)
    np.testing.assert_allclose(matrix @ factor.solve(right), right, atol=1e-9)


def _grid(rows, columns):
    """Springs along the sides and one diagonal of a grid, each vertex held a little."""
    number = np.arange(rows * columns).reshape(rows, columns)
    pairs = [(number[:, 1:], number[:, :-1]), (number[1:], number[:-1]), (number[1:, 1:], number[:-1, :-1])]
    first, second = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    springs = csc_matrix((np.ones(len(first)), (first, second)), shape=(rows * columns,) * 2)
    springs = springs + springs.T
    return csc_matrix(diags(np.asarray(springs.sum(axis=0)).ravel() + 0.1) - springs)
