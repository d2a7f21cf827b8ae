"""Maps as files: one npz with skin, charts and layout, checked at the door; and OBJ with UV for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.array_file import MAX_BYTES, pack_arrays, unpack_arrays
from app.errors import MapError
from app.maps.chart_file import chart_arrays, charts_header, layout_header, read_charts, read_layout
from app.maps.exchange.obj_uv import write_obj
from app.maps.tactile_map import TactileMap
from app.skin.skin_file import skin_from_bytes, skin_to_bytes
from app.whole_file import read_whole, write_whole

FORMAT, VERSION = "tactile-maps-map", 2
_READS = (1, VERSION)
"""Version 1 had no scale in a placement."""


def save_map(map_: TactileMap, path: str | Path) -> None:
    """Write ``map_`` with its skin to ``path`` (usually ``.npz``), whole or not at all.

    Raises:
        MapError: The file cannot be written.
    """
    write_whole(Path(path), map_to_bytes(map_), error=MapError)


def load_map(path: str | Path) -> TactileMap:
    """The map that ``save_map`` wrote to ``path``.

    Raises:
        MapError: There is no such file, or it is not a sound map.
        SkinError: The skin in it is not sound.
    """
    return map_from_bytes(read_whole(Path(path), error=MapError, most=MAX_BYTES), file=path)


def map_to_bytes(map_: TactileMap) -> bytes:
    """``map_`` in the file's format; the same map gives the same bytes."""
    arrays: dict[str, NDArray[Any]] = {"skin": np.frombuffer(skin_to_bytes(map_.skin), np.uint8)}
    for i, chart in enumerate(map_.charts):
        arrays |= chart_arrays(i, chart)
    header = {"format": FORMAT, "version": VERSION, **charts_header(map_.charts), **layout_header(map_.layout)}
    return pack_arrays(header, arrays)


def map_from_bytes(data: bytes, *, file: str | Path | None = None) -> TactileMap:
    """The map in ``data``.

    Args:
        data: From ``map_to_bytes``, or from anyone.
        file: Where it came from, for errors.

    Raises:
        MapError: Damaged, hostile, of another format or a later version, or not a sound map.
        SkinError: The skin in it is not sound.
    """
    header, arrays = unpack_arrays(data, file=file, error=MapError)
    if header.get("format") != FORMAT:
        raise MapError(
            "this is not a map file", file=file, value=header.get("format"), remedy="Choose a file saved by Save map"
        )
    if header.get("version") not in _READS:
        raise MapError(
            "the map file has an unknown version",
            file=file,
            value=header.get("version"),
            remedy=f"This program reads versions {_READS[0]} to {VERSION}",
        )
    if "skin" not in arrays or arrays["skin"].dtype != np.uint8:
        raise MapError("the map file has no skin", file=file)
    skin = skin_from_bytes(arrays["skin"].tobytes(), file=file)
    layout = read_layout(header, len(skin.patches), file)
    charts = read_charts(header, arrays, dict(enumerate(skin.patches)), file)
    return TactileMap(skin, tuple(charts.values()), layout)


def save_obj(map_: TactileMap, path: str | Path) -> None:
    """Write the skin as OBJ with the map as texture coordinates; see ``exchange.obj_uv``.

    Raises:
        MapError: The file cannot be written.
    """
    write_obj(map_, path)
