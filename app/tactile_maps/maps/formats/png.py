"""Pictures of a map as PNG: the tactile image in grey, with its scale in the file, and the map coloured by distortion.

The tactile image has eight or sixteen bits. The other picture colours each place by how much it is stretched or
squeezed, taxels as dots.
"""

from __future__ import annotations

from collections.abc import Mapping
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


def write_image_png(
    image: TactileImage, pressures: FloatArray, path: str | Path, *, full_scale: float | None = None, bits: int = 16
) -> None:
    """Write the image of ``pressures``: zero is black and ``full_scale`` white; what is above is white too.

    Texts in the file say the full scale [kPa], the map coordinates of the lower-left and the upper-right corner [m],
    and how many pixels were above full scale.

    Args:
        image: Of the size wanted.
        pressures: (taxels,) [Pa].
        path: Usually ``.png``.
        full_scale: [kPa]; None for the largest of this image.
        bits: 8 or 16 a pixel.

    Raises:
        MapError: A depth that PNG does not have here, a full scale that is not above zero, or no file can be written.
    """
    if bits not in (8, 16):
        raise MapError("a grey image has 8 or 16 bits a pixel", value=bits)
    values = image.render(pressures).astype(np.float64)
    scale = float(values.max(initial=0.0)) or 1.0 if full_scale is None else float(full_scale)
    if not (np.isfinite(scale) and scale > 0):
        raise MapError("the full scale must be above zero", value=full_scale)
    largest = 2**bits - 1
    levels = np.rint(np.clip(values / scale, 0, 1) * largest).astype(f"u{bits // 8}")
    texts = {
        "Software": "Tactile Maps",
        "Full scale kPa": repr(scale),
        "Extent m": " ".join(map(repr, np.asarray(image.extent).ravel().tolist())),
        "Pixels above full scale": str(int((values > scale).sum())),
    }
    density = np.array(levels.shape[::-1]) / np.ptp(image.extent, axis=0)
    write_atomically(Path(path), png_bytes(levels, texts, density), error=MapError)


def png_bytes(levels: np.ndarray, texts: Mapping[str, str], density: FloatArray) -> bytes:
    """A picture in PNG's own form.

    Args:
        levels: (rows, columns) grey, of 8 or 16 bits, or (rows, columns, 3) red, green, blue of 8 bits.
        texts: Put into the file under their names.
        density: (2,) pixels a metre across and up.
    """
    info = PngInfo()
    for key, text in texts.items():
        info.add_text(key, text)
    data = BytesIO()
    x, y = (_INCH * density).tolist()
    Image.fromarray(levels).save(data, "PNG", pnginfo=info, dpi=(x, y))
    return data.getvalue()


WIDTH = 1600
WORST = 2.0
"""Change of a length that has the last colour: drawn twice as long or half as long as it is."""
_STOPS = np.array([[0xE8, 0xF1, 0xF7], [0x8F, 0xC1, 0xDD], [0xF2, 0xC1, 0x4E], [0xC0, 0x39, 0x2B]], dtype=float)
_TAXEL = np.array([0x1F, 0x2D, 0x3A])
_PAPER = 255
_DOT = 0.0035
"""Radius of a taxel's dot, in widths of the picture."""


def write_distortion_png(map_: TactileMap, path: str | Path) -> None:
    """Write the map as a coloured PNG, 1600 pixels on its longer side.

    Nearly white is true to length, blue a little off, yellow 1.6 times, red twice or more; a text in the file says so.

    Raises:
        MapError: The file cannot be written.
    """
    image = TactileImage(map_, width=WIDTH, interpolation="nearest")  # the cheapest: only its places are shown
    patch, face, _ = image.places
    starts = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    worst = distortion(map_).isometry
    colours = np.full((len(face), 3), _PAPER, dtype=np.uint8)
    on = face >= 0
    colours[on] = _colours(worst[starts[patch[on]] + face[on]])
    picture = colours.reshape(*image.shape, 3)
    _draw_dots(picture, image, map_.taxel_points)
    texts = {"Software": "Tactile Maps", "Colour": f"largest change of a length, white 1, red {WORST:g} or more"}
    density = np.array(image.shape[::-1]) / np.ptp(image.extent, axis=0)
    write_atomically(Path(path), png_bytes(picture, texts, density), error=MapError)


def _colours(isometry: FloatArray) -> np.ndarray:
    """(k, 3) red, green, blue."""
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
