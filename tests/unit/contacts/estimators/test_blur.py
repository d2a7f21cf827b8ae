"""A matrix with its decomposition."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.blur import Blur


@pytest.mark.parametrize("shape", [(5, 5), (6, 4), (1, 1)])
def test_its_parts_make_it_up(shape):
    matrix = np.random.default_rng(0).normal(size=shape)
    blur = Blur.of(matrix)
    np.testing.assert_allclose(blur.left * blur.values @ blur.right, matrix, atol=1e-12)
    assert (np.diff(blur.values) <= 0).all()
    assert not blur.matrix.flags.writeable
