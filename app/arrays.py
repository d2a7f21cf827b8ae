"""Named array types, and the one way a value makes its arrays its own."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray: TypeAlias = NDArray[np.float64]
IntArray: TypeAlias = NDArray[np.int64]
BoolArray: TypeAlias = NDArray[np.bool_]


def readonly(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """Return a contiguous, read-only array of its own; an array that already is one is passed through."""
    if (
        isinstance(values, np.ndarray)
        and values.dtype == np.dtype(dtype)
        and values.flags.c_contiguous
        and not values.flags.writeable
        and values.base is None
    ):
        return values
    own = np.array(values, dtype=dtype, order="C", copy=True)
    own.flags.writeable = False
    return own
