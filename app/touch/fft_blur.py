"""What is felt under a cover, on a regular grid: every cell at once by fast Fourier transform.

Skins are no grids, so the half-space model does not use this; a sheet of taxels or a reference on a fine grid may.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.fft import fftfreq, irfft2, next_fast_len, rfft2

from app.arrays import FloatArray
from app.touch.love import point_stress, rectangle_stress

Distance = Callable[[FloatArray, FloatArray], FloatArray]


class GridBlur:
    """Pressure at a depth from pressure at the surface of a grid. Built once.

    The grid is padded to twice its size, so nothing wraps: what is pressed at a border is not felt at the other.

    Args:
        shape: Cells up and across.
        pitch: Sides of a cell [m], up and across.
        depth: Of the taxels below the surface [m], > 0.
        distance: From steps up and across [m] to the distance through the body, where the grid is bent; cells then are
            taken for points, which is right to 1e-5 where a cell is no wider than half the depth. Flat if None.

    Cost: 60 ms for 450 × 450 cells, each time and to build.
    """

    def __init__(
        self, shape: tuple[int, int], pitch: tuple[float, float], depth: float, *, distance: Distance | None = None
    ) -> None:
        self._shape = shape
        self._size = (next_fast_len(2 * shape[0], real=True), next_fast_len(2 * shape[1], real=True))
        steps = [step * np.abs(fftfreq(size, 1 / size)) for step, size in zip(pitch, self._size, strict=True)]
        up, across = np.meshgrid(*steps, indexing="ij")
        if distance is None:
            kernel = rectangle_stress(up, across, depth, sides=(np.array(pitch[0]), np.array(pitch[1])))
        else:
            kernel = pitch[0] * pitch[1] * point_stress(distance(up, across), depth)
        self._symbol = rfft2(kernel)

    def felt(self, pressures: FloatArray) -> FloatArray:
        """Normal stress at the depth under every cell's middle, of ``pressures`` on the cells, both of the shape."""
        spread = irfft2(rfft2(pressures, self._size) * self._symbol, self._size)
        return np.asarray(spread[: self._shape[0], : self._shape[1]])
