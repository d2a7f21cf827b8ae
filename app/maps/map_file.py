"""Maps as files: one npz with skin, charts and layout, checked at the door; and OBJ with UV for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.array_file import MAX_BYTES, pack_arrays, unpack_arrays
from app.errors import Finding, MapError, MeshError
from app.geometry.topology import boundary_loops
from app.maps.bijective import flipped
from app.maps.chart import Chart
from app.maps.exchange.obj_uv import write_obj
from app.maps.layout import FARTHEST, LARGEST, SMALLEST, MapLayout, Placement
from app.maps.tactile_map import TactileMap
from app.skin.skin import Patch
from app.skin.skin_file import skin_from_bytes, skin_to_bytes

FORMAT, VERSION = "tactile-maps-map", 2
_READS = (1, VERSION)
"""Version 1 had no scale in a placement."""

# Angle, x, y, whether mirrored and, since version 2, scale.
_PLACEMENTS = ([float, float, float, bool], [float, float, float, bool, float])

# Columns and kinds of a chart's arrays.
_ARRAYS = {
    "faces": (3, "iu"), "plane": (2, "f"), "vertex_of": (1, "iu"), "seams": (2, "iu"),
    "energies": (1, "f"), "seconds": (1, "f"),
}  # fmt: skip


def save_map(map_: TactileMap, path: str | Path) -> None:
    """Write ``map_`` with its skin to ``path`` (usually ``.npz``), whole or not at all.

    Raises:
        MapError: The file cannot be written.
    """
    _write(Path(path), map_to_bytes(map_))


def load_map(path: str | Path) -> TactileMap:
    """The map that ``save_map`` wrote to ``path``.

    Raises:
        MapError: There is no such file, or it is not a sound map.
        SkinError: The skin in it is not sound.
    """
    path = Path(path)
    try:
        if path.stat().st_size > MAX_BYTES:
            raise MapError("the file is too large for a map", file=path, value=f"{path.stat().st_size} bytes")
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        raise MapError("the file cannot be read", file=path, value=error, remedy="Check the path") from error
    return map_from_bytes(data, file=path)


def map_to_bytes(map_: TactileMap) -> bytes:
    """``map_`` in the file's format; the same map gives the same bytes."""
    arrays: dict[str, NDArray[Any]] = {"skin": np.frombuffer(skin_to_bytes(map_.skin), np.uint8)}
    for i, chart in enumerate(map_.charts):
        arrays |= {f"{i}_{name}": np.asarray(getattr(chart, name)) for name in _ARRAYS}
    header = {
        "format": FORMAT,
        "version": VERSION,
        "methods": [chart.method for chart in map_.charts],
        "findings": [[[f.kind, f.where, f.action, f.count] for f in chart.findings] for chart in map_.charts],
        "placements": [
            [float(p.angle), *map(float, p.offset), p.mirrored, float(p.scale)] for p in map_.layout.placements
        ],
    }
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
    methods, findings, placements = _header(header, len(skin.patches), file)
    charts = tuple(_Door(arrays, i, patch, file).chart(methods[i], findings[i]) for i, patch in enumerate(skin.patches))
    return TactileMap(skin, charts, MapLayout(placements))


def save_obj(map_: TactileMap, path: str | Path) -> None:
    """Write the skin as OBJ with the map as texture coordinates; see ``exchange.obj_uv``.

    Raises:
        MapError: The file cannot be written.
    """
    write_obj(map_, path)


def _write(path: Path, data: bytes) -> None:
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(data)
        part.replace(path)
    except (OSError, ValueError) as error:
        raise MapError(
            "the map cannot be written",
            file=path,
            value=error,
            remedy="Choose a folder you may write to, with space left",
        ) from error


def _header(
    header: Mapping[str, Any], count: int, file: str | Path | None
) -> tuple[list[str], list[tuple[Finding, ...]], tuple[Placement, ...]]:
    parts: list[list[Any]] = []
    for key, sound in (("methods", _is_method), ("findings", _is_findings), ("placements", _is_placement)):
        values = header.get(key)
        if not isinstance(values, list) or len(values) != count or not all(sound(value) for value in values):
            raise MapError("the map file's header is broken", file=file, place=key, value=values)
        parts.append(values)
    methods, findings, placements = parts
    notes = [tuple(Finding(*entry) for entry in part) for part in findings]
    return methods, notes, tuple(Placement(a, (x, y), *rest) for a, x, y, *rest in placements)


def _is_method(value: object) -> bool:
    return isinstance(value, str)


def _is_findings(value: object) -> bool:
    return isinstance(value, list) and all(
        isinstance(entry, list) and [type(x) for x in entry] == [str, str, str, int] for entry in value
    )


def _is_placement(value: object) -> bool:
    if not isinstance(value, list) or [type(x) for x in value] not in _PLACEMENTS:
        return False
    return all(abs(x) < FARTHEST for x in value[:3]) and all(SMALLEST <= x <= LARGEST for x in value[4:])


class _Door:
    """Takes one patch's chart out of the file and lets only a sound one in."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], i: int, patch: Patch, file: str | Path | None) -> None:
        self._arrays, self._i, self._patch, self._file = arrays, i, patch, file

    def chart(self, method: str, findings: tuple[Finding, ...]) -> Chart:
        """The chart; every promise that the rest of the program builds on is checked."""
        take = {name: self._take(name, columns, kinds) for name, (columns, kinds) in _ARRAYS.items()}
        faces, vertex_of, surface = take["faces"], take["vertex_of"], self._patch.surface
        self._check_range("faces", faces, len(take["plane"]))
        for name in ("vertex_of", "seams"):
            self._check_range(name, take[name], len(surface.vertices))
        if len(vertex_of) != len(take["plane"]):
            raise self._refuse("points and vertices differ in number", "vertex_of", len(vertex_of))
        if faces.shape != surface.faces.shape or (vertex_of[faces] != surface.faces).any():
            raise self._refuse("the chart is not of this patch's surface", "faces", faces.shape)
        if flipped(take["plane"], faces).any():
            raise self._refuse("triangles are turned over", "plane", int(flipped(take["plane"], faces).sum()))
        try:
            loops = len(boundary_loops(faces))
        except MeshError as error:
            raise self._refuse("the chart is not a disk", "faces", error.problem) from error
        if loops != 1:
            raise self._refuse("the chart is not a disk", "faces", f"{loops} borders")
        times = {name: tuple(take[name].tolist()) for name in ("energies", "seconds")}
        return Chart(faces, take["plane"], vertex_of, take["seams"], method, findings=findings, **times)

    def _take(self, name: str, columns: int, kinds: str) -> NDArray[Any]:
        values = self._arrays.get(f"{self._i}_{name}")
        if values is None:
            raise self._refuse("an array is missing", name, None)
        if (
            values.ndim == 0
            or values.shape[1:] != (() if columns == 1 else (columns,))
            or values.dtype.kind not in kinds
        ):
            raise self._refuse("an array has the wrong shape or type", name, f"{values.shape} {values.dtype}")
        if kinds == "f" and not np.isfinite(values).all():
            raise self._refuse("a number is not finite", name, values[~np.isfinite(values)][0])
        return values.astype(np.float64 if kinds == "f" else np.int64)

    def _check_range(self, name: str, values: NDArray[Any], count: int) -> None:
        bad = (values < 0) | (values >= count)
        if bad.any():
            raise self._refuse("an index is out of range", name, values[bad][0])

    def _refuse(self, problem: str, name: str, value: object) -> MapError:
        return MapError(problem, file=self._file, place=f"patch {self._patch.name}, {name}", value=value)
