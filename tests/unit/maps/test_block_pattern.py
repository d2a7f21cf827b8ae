"""Blocks of faces summed into a sparse matrix, against a dense sum by hand."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from app.maps.block_pattern import BlockPattern
from tests.numerics.map_surfaces import cap, frustum


@pytest.mark.parametrize("surface", [cap(1.0, rings=3), frustum(around=5, along=2)], ids=["disk", "tube"])
def test_the_sum_is_the_dense_sums_upper_triangle(surface):
    faces, count = surface.faces, len(surface.vertices)
    generator = np.random.default_rng(0)
    local = generator.normal(size=(len(faces), 6, 6))
    local += local.swapaxes(1, 2)
    dense = np.zeros((2 * count, 2 * count))
    for face, block in zip(faces, local, strict=True):
        dofs = (2 * face[:, None] + np.arange(2)).ravel()
        dense[np.ix_(dofs, dofs)] += block
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
    blocks = {(a, b): tuple(local[:, 2 * a + i, 2 * b + j] for i, j in product(range(2), repeat=2)) for a, b in pairs}
    matrix = BlockPattern(faces, count).matrix(blocks)
    np.testing.assert_allclose(matrix.toarray(), np.triu(dense), atol=1e-12)
    for column in range(matrix.shape[1]):
        rows = matrix.indices[matrix.indptr[column] : matrix.indptr[column + 1]]
        assert (np.diff(rows) > 0).all()
        assert rows[-1] == column


def test_every_matrix_shares_one_pattern():
    surface = cap(1.0, rings=2)
    pattern, ones = BlockPattern(surface.faces, len(surface.vertices)), np.ones(len(surface.faces))
    blocks = dict.fromkeys(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)), (ones,) * 4)
    first, second = pattern.matrix(blocks), pattern.matrix(blocks)
    assert first.indices.ctypes.data == second.indices.ctypes.data
