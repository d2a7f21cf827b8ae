"""Pixels of the live image: one buffer that Qt draws without a copy, filled in place from the pressure scale."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QImage

from tactile_maps.core.arrays import IntArray
from tactile_widgets.common.colours import PressureScale


class LiveImage:
    """32-bit image over an array; ``fill`` repaints it in place.

    Args:
        shape: Rows and columns.
        halo: (j,) flat indices of the pixels just outside the patches.
        source: (j,) flat index of the pixel that each of them copies.

    Attributes:
        background: (h, w) 0xffRRGGBB shown instead of the scale below ``touch_from``; None for the scale everywhere.
        touch_from: Pressure from which touch is shown over a background [kPa]; infinite for never.
    """

    def __init__(self, shape: tuple[int, int], halo: IntArray, source: IntArray) -> None:
        height, width = shape
        self._level = np.empty(shape, np.float32)
        self._index = np.zeros(shape, np.uint16)
        self._pixels = np.zeros(shape, np.uint32)
        self._halo = halo
        self._source = source
        self.background: NDArray[np.uint32] | None = None
        self.touch_from: float = 0.0
        self.image = QImage(self._pixels.data, width, height, 4 * width, QImage.Format.Format_RGB32)

    @property
    def pixels(self) -> NDArray[np.uint32]:
        """(h, w) 0xffRRGGBB, row 0 at the top; changes in place."""
        return self._pixels

    def fill(self, kilopascals: NDArray[Any], scale: PressureScale, *, changed: IntArray | None = None) -> None:
        """Colour the image by ``kilopascals`` (h, w) [kPa].

        Args:
            kilopascals: Pressure at each pixel.
            scale: Colour scale.
            changed: (k,) flat indices of the pixels that have changed; None for all.

        Cost: about 1 ms for 512² pixels.
        """
        colours = scale.lut
        top = len(colours) - 1
        flat = self._pixels.reshape(-1)
        if changed is None:
            np.multiply(kilopascals, top / scale.maximum, out=self._level, casting="unsafe")
            np.clip(self._level, 0, top, out=self._level)
            np.copyto(self._index, self._level, casting="unsafe")
            np.take(colours, self._index, out=self._pixels, mode="clip")
            if self.background is not None:
                np.copyto(self._pixels, self.background, where=np.asarray(kilopascals) < self.touch_from)
        else:
            values = kilopascals.reshape(-1)[changed]
            level = np.clip(values * np.float32(top / scale.maximum), 0, top)
            found = colours[level.astype(np.uint16)]
            if self.background is not None:
                found = np.where(values < self.touch_from, self.background.reshape(-1)[changed], found)
            flat[changed] = found
        flat[self._halo] = flat[self._source]
