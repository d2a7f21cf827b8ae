"""The map as a picture: each place coloured by how much it is stretched or squeezed, taxels as dots."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from app.arrays import FloatArray
from app.errors import MapError
from app.maps.distortion import distortion
from app.maps.exchange.png import png_bytes
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.skin.exchange.foreign_file import write_bytes

WIDTH = 1600
WORST = 2.0
"""Change of a length that has the last colour: drawn twice as long or half as long as it is."""
_STOPS = np.array([[0xE8, 0xF1, 0xF7], [0x8F, 0xC1, 0xDD], [0xF2, 0xC1, 0x4E], [0xC0, 0x39, 0x2B]], dtype=float)
_TAXEL, _PAPER = np.array([0x1F, 0x2D, 0x3A]), 255
_DOT = 0.0035
"""Radius of a taxel's dot, in widths of the picture."""


def write_picture(map_: TactileMap, path: str | Path) -> None:
    """Write the map as a coloured PNG, 1600 pixels on its longer side.

    Nearly white is true to length, blue a little off, yellow 1.6 times, red twice or more; a text in the file says so.

    Raises:
        MapError: The file cannot be written.
    """
    image = TactileImage(map_, width=WIDTH)
    patch, face, _ = map_.to_body_many(image.centres())
    starts = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    worst = distortion(map_).isometry
    colours = np.full((len(face), 3), _PAPER, dtype=np.uint8)
    on = face >= 0
    colours[on] = _colours(worst[starts[patch[on]] + face[on]])
    picture = colours.reshape(*image.shape, 3)
    _dot(picture, image, map_.taxel_points)
    texts = {"Software": "Tactile Maps", "Colour": f"largest change of a length, white 1, red {WORST:g} or more"}
    density = np.array(image.shape[::-1]) / np.ptp(image.extent, axis=0)
    write_bytes(Path(path), png_bytes(picture, texts, density), error=MapError)


def _colours(isometry: FloatArray) -> np.ndarray:
    """(k, 3) red, green, blue."""
    place = np.clip(np.log(isometry) / np.log(WORST), 0, 1) * (len(_STOPS) - 1)
    columns = [np.interp(place, np.arange(len(_STOPS)), _STOPS[:, channel]) for channel in range(3)]
    return np.rint(np.stack(columns, axis=1)).astype(np.uint8)


def _dot(picture: np.ndarray, image: TactileImage, points: FloatArray) -> None:
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
