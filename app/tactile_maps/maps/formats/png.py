"""A picture of the map as PNG, coloured by distortion, with taxels as dots."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.files import write_atomically
from tactile_maps.maps.evaluation.distortion import distortion
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap

_INCH = 0.0254
"""[m]; a picture's density is written per inch."""


WIDTH = 1600
WORST = 2.0
"""Change of length at the end of the colour scale: twice or half the true length."""
_STOPS = np.array([[0xE8, 0xF1, 0xF7], [0x8F, 0xC1, 0xDD], [0xF2, 0xC1, 0x4E], [0xC0, 0x39, 0x2B]], dtype=float)
_TAXEL = np.array([0x1F, 0x2D, 0x3A])
_PAPER = 255
_DOT = 0.0035
"""Radius of a taxel's dot, relative to the width of the picture."""


def write_distortion_png(map_: TactileMap, path: str | Path) -> None:
    """Write the map as a coloured PNG, 1600 pixels on its longer side.

    Nearly white is true length, blue a small change, yellow 1.6 times, red twice or more; a text in the file says so.

    Raises:
        MapError: The file cannot be written.
    """
    image = TactileImage(map_, width=WIDTH, interpolation="nearest")  # the fastest; only its places are used
    patch, face, _ = image.places
    starts = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    worst = distortion(map_).isometry
    colours = np.full((len(face), 3), _PAPER, dtype=np.uint8)
    on = face >= 0
    colours[on] = _colours(worst[starts[patch[on]] + face[on]])
    picture = colours.reshape(*image.shape, 3)
    _draw_dots(picture, image, map_.taxel_points)
    info = PngInfo()
    info.add_text("Software", "Tactile Maps")
    info.add_text("Colour", f"largest change of a length, white 1, red {WORST:g} or more")
    x, y = (_INCH * np.array(image.shape[::-1]) / np.ptp(image.extent, axis=0)).tolist()
    data = BytesIO()
    Image.fromarray(picture).save(data, "PNG", pnginfo=info, dpi=(x, y))
    write_atomically(Path(path), data.getvalue(), error=MapError)


def _colours(isometry: FloatArray) -> np.ndarray:
    """Return colours (k, 3) red, green, blue."""
    place = np.clip(np.log(isometry) / np.log(WORST), 0, 1) * (len(_STOPS) - 1)
    columns = [np.interp(place, np.arange(len(_STOPS)), _STOPS[:, channel]) for channel in range(3)]
    return np.rint(np.stack(columns, axis=1)).astype(np.uint8)


def _draw_dots(picture: np.ndarray, image: TactileImage, points: FloatArray) -> None:
    """Draw a dot at each of ``points`` (n, 2) [m]."""
    rows, columns = image.shape
    reach = max(1, round(_DOT * max(rows, columns)))
    down, right = (part.ravel() for part in np.mgrid[-reach : reach + 1, -reach : reach + 1])
    round_ = down**2 + right**2 <= reach**2
    middle = np.floor((points - image.extent[0]) / image.resolution).astype(int)
    row = (rows - 1 - middle[:, 1])[:, None] + down[round_]
    column = middle[:, 0][:, None] + right[round_]
    inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
    picture[row[inside], column[inside]] = _TAXEL
