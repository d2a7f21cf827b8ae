"""The map's own pixels, handed from the map to the body, so that both show the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class SkinPicture:
    """The picture of a skin laid flat. Its pixels change in place with every frame.

    Attributes:
        pixels: (h, w) 0xffRRGGBB, row 0 at the top.
        extent: (2, 2) lower-left and upper-right corner [m].
        places: For each patch (k, 2) where the points of its chart lie in the picture [m]; not always where they lie on
            the map, since patches are moved over the map without another picture.
    """

    pixels: NDArray[np.uint32]
    extent: FloatArray
    places: tuple[FloatArray, ...]
