from __future__ import annotations

import numpy as np
import pytest

from app.skin.taxels import Quadrature, Taxels


def test_arrays_are_read_only_and_counted() -> None:
    one = np.array([[0.0, 0, 1]])
    quadrature = Quadrature(one, one, np.ones(1), np.zeros(1))
    taxels = Taxels(one, one, np.zeros(1), one, np.ones(1), np.zeros((0, 2)), quadrature)
    assert len(taxels) == 1
    assert taxels.faces.dtype == np.int64
    with pytest.raises(ValueError, match="read-only"):
        taxels.areas[0] = 2
    with pytest.raises(ValueError, match="read-only"):
        quadrature.areas[0] = 2
