"""The tactile image as a grey PNG of eight or sixteen bits, with its scale in the file.

The format is that of the PNG specification (W3C, third edition): signature, then chunks of length, name, data and CRC.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from app.arrays import FloatArray
from app.errors import MapError
from app.maps.tactile_image import TactileImage
from app.skin.exchange.foreign_file import write_bytes

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_GREY, _COLOUR = 0, 2


def write_png(
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
    levels = np.rint(np.clip(values / scale, 0, 1) * largest).astype(f">u{bits // 8}")
    texts = {
        "Software": "Tactile Maps",
        "Full scale kPa": repr(scale),
        "Extent m": " ".join(map(repr, np.asarray(image.extent).ravel().tolist())),
        "Pixels above full scale": str(int((values > scale).sum())),
    }
    density = np.array(levels.shape[::-1]) / np.ptp(image.extent, axis=0)
    write_bytes(Path(path), png_bytes(levels, texts, density), error=MapError)


def png_bytes(levels: np.ndarray, texts: Mapping[str, str], density: FloatArray) -> bytes:
    """A picture in PNG's own form.

    Args:
        levels: (rows, columns) grey, 8 or 16 bits big-endian, or (rows, columns, 3) red, green, blue of 8 bits.
        texts: Put into the file under their names.
        density: (2,) pixels a metre across and up.
    """
    height, width = levels.shape[:2]
    kind = _GREY if levels.ndim == 2 else _COLOUR
    values = np.ascontiguousarray(levels).view(np.uint8).reshape(height, -1)
    rows = np.pad(values, ((0, 0), (1, 0)))  # each row begins with its filter, none
    x, y = np.rint(density).clip(1, 2**31 - 1).astype(int).tolist()
    chunks = [
        _chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8 * levels.itemsize, kind, 0, 0, 0)),
        _chunk(b"pHYs", struct.pack(">IIB", x, y, 1)),
        *(_chunk(b"tEXt", key.encode() + b"\0" + text.encode()) for key, text in texts.items()),
        _chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)),
        _chunk(b"IEND", b""),
    ]
    return _SIGNATURE + b"".join(chunks)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
