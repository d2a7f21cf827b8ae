"""Map files: one npz with skin, charts and layout, validated when read; and edits of a map as bytes.

Charts and layout are converted to and from named arrays first: a recording stores the edits of a map without the map.
An edit is the difference from another map of the same skin, so that moving a patch is small. If the assumed taxel
positions of the skin differ, the edit is a whole map.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import Finding, MapError, MeshError
from tactile_maps.core.files import (
    MAX_UNPACKED_BYTES,
    pack_arrays,
    read_bounded_file,
    unpack_arrays,
    write_atomically,
)
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.maps.model.layout import FARTHEST_OFFSET, LARGEST_SCALE, SMALLEST_SCALE, MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin, same_triangles
from tactile_maps.skin.model.skin_file import MAP_FORMAT, skin_from_bytes, skin_to_bytes

# Angle, x, y, whether mirrored and, since version 2 of the map file, scale.
_PLACEMENTS = ([float, float, float, bool], [float, float, float, bool, float])

# Columns and kinds of a chart's arrays.
_ARRAYS = {
    "faces": (3, "iu"),
    "plane": (2, "f"),
    "vertex_of": (1, "iu"),
    "seams": (2, "iu"),
    "energies": (1, "f"),
    "seconds": (1, "f"),
}


def chart_arrays(number: int, chart: Chart) -> dict[str, NDArray[Any]]:
    """Return the arrays of patch ``number``'s chart by name."""
    return {f"{number}_{name}": np.asarray(getattr(chart, name)) for name in _ARRAYS}


def charts_header(charts: Sequence[Chart]) -> dict[str, Any]:
    """Return the fields of ``charts`` that are not arrays, for a JSON header."""
    return {
        "methods": [chart.method for chart in charts],
        "findings": [[[f.kind, f.where, f.action, f.count] for f in chart.findings] for chart in charts],
    }


def layout_header(layout: MapLayout) -> dict[str, Any]:
    """Return a layout for a JSON header."""
    rows = [[float(p.angle), *map(float, p.offset), p.mirrored, float(p.scale)] for p in layout.placements]
    return {"placements": rows}


def read_layout(header: Mapping[str, Any], count: int, file: str | Path | None) -> MapLayout:
    """Read the layout of ``count`` patches from ``layout_header``. Raises MapError if it is invalid."""
    rows = _list(header, "placements", count, _is_placement, file)
    return MapLayout(tuple(Placement(a, (x, y), *rest) for a, x, y, *rest in rows))


def read_charts(
    header: Mapping[str, Any],
    arrays: Mapping[str, NDArray[Any]],
    patches: Mapping[int, Patch],
    file: str | Path | None,
) -> dict[int, Chart]:
    """Read the charts of these patches by number; the header's lists are in the same order.

    Raises:
        MapError: Data are missing, damaged, or not a valid chart of their patch.
    """
    methods = _list(header, "methods", len(patches), _is_method, file)
    notes = _list(header, "findings", len(patches), _is_findings, file)
    return {
        i: _ChartReader(arrays, i, patch, file).chart(method, tuple(Finding(*entry) for entry in found))
        for (i, patch), method, found in zip(patches.items(), methods, notes, strict=True)
    }


def _list(header: Mapping[str, Any], key: str, count: int, sound: Any, file: str | Path | None) -> list[Any]:
    values = header.get(key)
    if not isinstance(values, list) or len(values) != count or not all(sound(value) for value in values):
        raise MapError("the map file's header is broken", file=file, place=key, value=values)
    return values


def _is_method(value: object) -> bool:
    return isinstance(value, str)


def _is_findings(value: object) -> bool:
    return isinstance(value, list) and all(
        isinstance(entry, list) and [type(x) for x in entry] == [str, str, str, int] for entry in value
    )


def _is_placement(value: object) -> bool:
    if not isinstance(value, list) or [type(x) for x in value] not in _PLACEMENTS:
        return False
    return all(abs(x) < FARTHEST_OFFSET for x in value[:3]) and all(
        SMALLEST_SCALE <= x <= LARGEST_SCALE for x in value[4:]
    )


class _ChartReader:
    """Reads and validates the chart of one patch."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], i: int, patch: Patch, file: str | Path | None) -> None:
        self._arrays = arrays
        self._i = i
        self._patch = patch
        self._file = file

    def chart(self, method: str, findings: tuple[Finding, ...]) -> Chart:
        """Return the chart, with every property checked that the rest of the program relies on."""
        take = {name: self._take(name, columns, kinds) for name, (columns, kinds) in _ARRAYS.items()}
        faces = take["faces"]
        vertex_of = take["vertex_of"]
        surface = self._patch.surface
        self._check_range("faces", faces, len(take["plane"]))
        for name in ("vertex_of", "seams"):
            self._check_range(name, take[name], len(surface.vertices))
        if len(vertex_of) != len(take["plane"]):
            raise self._refuse("points and vertices differ in number", "vertex_of", len(vertex_of))
        if faces.shape != surface.faces.shape or (vertex_of[faces] != surface.faces).any():
            raise self._refuse("the chart is not of this patch's surface", "faces", faces.shape)
        if flipped(take["plane"], faces).any():
            raise self._refuse("triangles are flipped", "plane", int(flipped(take["plane"], faces).sum()))
        try:
            loops = len(Connectivity(faces).boundary_loops)
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


MAP_VERSION = 2
_READS = (1, MAP_VERSION)
"""Supported versions; version 1 has no scale in a placement."""


def save_map(map_: TactileMap, path: str | Path, *, overwrite: bool = False) -> None:
    """Write a map with its skin to a file atomically.

    Args:
        map_: The map.
        path: The file, usually ``.npz``; it must not exist.
        overwrite: Replace an existing file.

    Raises:
        MapError: The file exists or cannot be written.

    Example:
        >>> tm.save_map(tactile_map, "hand.npz", overwrite=True)
    """
    write_atomically(Path(path), map_to_bytes(map_), error=MapError, overwrite=overwrite)


def load_map(path: str | Path) -> TactileMap:
    """Load the map that ``save_map`` wrote to ``path``.

    Raises:
        MapError: The file does not exist or is not a valid map.
        SkinError: Its skin is not valid.

    Example:
        >>> tm.save_map(tactile_map, "hand.npz", overwrite=True)
        >>> len(tm.load_map("hand.npz").skin)
        60
    """
    return map_from_bytes(read_bounded_file(Path(path), error=MapError, most=MAX_UNPACKED_BYTES), file=path)


def map_to_bytes(map_: TactileMap) -> bytes:
    """Return ``map_`` in the file format; equal maps give equal bytes."""
    arrays: dict[str, NDArray[Any]] = {"skin": np.frombuffer(skin_to_bytes(map_.skin), np.uint8)}
    for i, chart in enumerate(map_.charts):
        arrays |= chart_arrays(i, chart)
    header = {"format": MAP_FORMAT, "version": MAP_VERSION, **charts_header(map_.charts), **layout_header(map_.layout)}
    return pack_arrays(header, arrays)


def map_from_bytes(data: bytes, *, file: str | Path | None = None) -> TactileMap:
    """Return the map in ``data``.

    Args:
        data: Bytes of ``map_to_bytes``, or untrusted ones.
        file: Origin of the data, for errors.

    Raises:
        MapError: The data are damaged, malicious, of another format or version, or not a valid map.
        SkinError: Its skin is not valid.
    """
    header, arrays = unpack_arrays(data, file=file, error=MapError)
    if header.get("format") != MAP_FORMAT:
        raise MapError(
            "this is not a map file", file=file, value=header.get("format"), remedy="Choose a file saved by Save map"
        )
    if header.get("version") not in _READS:
        raise MapError(
            "the map file has an unknown version",
            file=file,
            value=header.get("version"),
            remedy=f"This program reads versions {_READS[0]} to {MAP_VERSION}",
        )
    if "skin" not in arrays or arrays["skin"].dtype != np.uint8:
        raise MapError("the map file has no skin", file=file)
    skin = skin_from_bytes(arrays["skin"].tobytes(), file=file)
    layout = read_layout(header, len(skin.patches), file)
    charts = read_charts(header, arrays, dict(enumerate(skin.patches)), file)
    return TactileMap(skin, tuple(charts.values()), layout)


EDIT_FORMAT = "tactile-maps-edit"


def edit_to_bytes(map_: TactileMap, base: TactileMap) -> bytes:
    """Return ``map_`` as a difference from ``base``: its layout and the charts that are other objects.

    With another skin than that of ``base``, the whole map is returned.

    Cost: 0.2 ms, and 40 ms per 10,000 faces of changed charts, nearly all of it compression; a whole map about 0.1 s
        for
    1,000 taxels.
    """
    if not _same_skin(map_.skin, base.skin):
        return map_to_bytes(map_)
    pairs = enumerate(zip(map_.charts, base.charts, strict=True))
    changed = {number: chart for number, (chart, old) in pairs if chart is not old}
    arrays: dict[str, NDArray[Any]] = {}
    for number, chart in changed.items():
        arrays |= chart_arrays(number, chart)
    header = {"format": EDIT_FORMAT, "changed": list(changed), **charts_header(list(changed.values()))}
    return pack_arrays(header | layout_header(map_.layout), arrays)


def _same_skin(one: Skin, other: Skin) -> bool:
    """Return whether two skins of the same patches have equal surfaces and taxels in equal positions."""
    return one is other or all(map(_same_patch, one.patches, other.patches))


def _same_patch(one: Patch, other: Patch) -> bool:
    names = ("positions", "normals", "faces", "weights", "areas")
    pairs = [(getattr(one.taxels, name), getattr(other.taxels, name)) for name in names]
    return same_triangles(one, other) and all(
        np.array_equal(a, b) for a, b in [(one.surface.vertices, other.surface.vertices), *pairs]
    )


def edit_from_bytes(data: bytes, base: TactileMap) -> TactileMap:
    """Return the map of ``edit_to_bytes``.

    Args:
        data: The bytes, possibly untrusted.
        base: The map from which the edit is a difference.

    Raises:
        MapError: The data are damaged, malicious, or not an edit of this map.
        SkinError: It contains an invalid skin.
    """
    header, arrays = unpack_arrays(data, error=MapError)
    if header.get("format") == MAP_FORMAT:
        return _whole_map(data, base)
    numbers = header.get("changed")
    patches = base.skin.patches
    known = range(len(patches))
    if header.get("format") != EDIT_FORMAT or not isinstance(numbers, list):
        raise MapError("this is not an edit of a map", value=header.get("format"))
    if any(type(number) is not int or number not in known for number in numbers) or len(set(numbers)) < len(numbers):
        raise MapError("the edit is of another map", value=numbers)
    charts = dict(enumerate(base.charts)) | read_charts(header, arrays, {k: patches[k] for k in numbers}, None)
    return replace(base, charts=tuple(charts.values()), layout=read_layout(header, len(patches), None))


def _whole_map(data: bytes, base: TactileMap) -> TactileMap:
    """Return the map of a skin with the patches, triangles and taxels of the skin of ``base``."""
    map_ = map_from_bytes(data)
    mine, expected = ([(patch.name, patch.link, len(patch.taxels)) for patch in m.skin.patches] for m in (map_, base))
    if mine != expected or not all(map(same_triangles, map_.skin.patches, base.skin.patches)):
        raise MapError("the edit is of another skin's map", place="skin", value=f"{len(map_.skin)} taxels")
    return map_
