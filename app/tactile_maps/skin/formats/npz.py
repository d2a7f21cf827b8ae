"""Taxels as named arrays (npz): read from untrusted files, written for ``numpy.load``.

Names of one set: ``positions`` (n, 3) [m], and optionally ``numbers``, ``normals``, ``faces``, ``points``, ``ids``,
``modules``, ``channels``, ``axes`` and ``tangents``, as in ``TaxelSet``; without ``ids``, ``numbers`` are used. Files
of this program contain several sets, with the number of the set before each name, and a header.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import Finding, SkinError, errors_in_file
from tactile_maps.core.files import (
    pack_arrays,
    read_bounded_file,
    unpack_arrays,
    unpack_bare_arrays,
    write_atomically,
)
from tactile_maps.skin.model.skin import LARGEST_NUMBER
from tactile_maps.skin.model.taxel_axes import stated_frames
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, TaxelSet, distinct_numbers, unit_normals

FORMAT = "tactile-maps-taxels"
VERSION = 5
_READS = (1, 2, 3, 4, VERSION)
"""Version 1 had no ``ids`` and ``channels``, version 2 no names of taxels, version 3 neither aliases nor streams,
version 4 neither axes nor tangents; version 4 is written unless a set has them."""
# Columns and kinds of the arrays of a set.
_ARRAYS = {
    "positions": (3, "fiu"),
    "numbers": (1, "iu"),
    "normals": (3, "f"),
    "faces": (3, "iu"),
    "points": (2, "f"),
    "modules": (1, "iu"),
    "ids": (1, "iu"),
    "channels": (1, "iu"),
    "aliases": (2, "iu"),
    "axes": (1, "iu"),
    "tangents": (3, "f"),
}
_MAX_ROWS = dict.fromkeys(_ARRAYS, MAX_TAXELS) | {"faces": 10 * MAX_TAXELS}


def read_taxel_npz(path: str | Path) -> tuple[TaxelSet, ...]:
    """Return the taxels in an npz of this program, or in one with plain names.

    Raises:
        SkinError: The file is damaged, hostile, without positions, or its taxels are invalid.
    """
    path = Path(path)
    data = read_bounded_file(path, error=SkinError)
    with errors_in_file(path):
        bare = unpack_bare_arrays(data, error=SkinError, max_rows=_MAX_ROWS)
        if "header" not in bare:
            return (_taxel_set(bare, "", path.stem, None, path.name),)
        return _own_sets(*unpack_arrays(data, error=SkinError, max_rows=_MAX_ROWS), path.name)


def _own_sets(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], where: str) -> tuple[TaxelSet, ...]:
    if header.get("format") != FORMAT or header.get("version") not in _READS:
        found = f"{header.get('format')} {header.get('version')}"
        remedy = f"This program reads taxels of versions {_READS[0]} to {VERSION}; open skins and maps as such"
        raise SkinError("this is not a file of taxels", value=found, remedy=remedy)
    stated = header.get("sets")
    if not isinstance(stated, list) or not stated or not all(map(_is_name, stated)):
        raise SkinError("the header of the file is broken", place="sets")
    names = header.get("names", [None] * len(stated))
    if not isinstance(names, list) or len(names) != len(stated) or not all(map(_are_names, names)):
        raise SkinError("the header of the file is broken", place="names")
    streams = header.get("streams", [None] * len(stated))
    if not isinstance(streams, list) or len(streams) != len(stated) or not all(map(_is_stream, streams)):
        raise SkinError("the header of the file is broken", place="streams")
    return tuple(
        replace(_taxel_set(arrays, f"{i}_", name, link, where, names[i]), stream=streams[i])
        for i, (name, link) in enumerate(stated)
    )


def write_taxel_npz(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` without their findings.

    Raises:
        SkinError: The file cannot be written.
    """
    arrays = {
        f"{i}_{name}": getattr(taxels, name)
        for i, taxels in enumerate(sets)
        for name in _ARRAYS
        if getattr(taxels, name) is not None
    }
    header = {
        "format": FORMAT,
        "version": VERSION if any(one.axes is not None or one.tangents is not None for one in sets) else 4,
        "sets": [[taxels.name, taxels.link] for taxels in sets],
        "names": [None if taxels.names is None else list(taxels.names) for taxels in sets],
        "streams": [taxels.stream for taxels in sets],
    }
    write_atomically(Path(path), pack_arrays(header, arrays), error=SkinError)


def _is_name(entry: object) -> bool:
    return (
        isinstance(entry, list)
        and len(entry) == 2
        and isinstance(entry[0], str)
        and (entry[1] is None or isinstance(entry[1], str))
    )


def _is_stream(value: object) -> bool:
    return value is None or (type(value) is int and 0 < value <= LARGEST_NUMBER)


def _are_names(value: object) -> bool:
    return value is None or (isinstance(value, list) and all(isinstance(name, str) for name in value))


def _taxel_set(
    arrays: Mapping[str, NDArray[Any]],
    prefix: str,
    name: str,
    link: str | None,
    where: str,
    names: Sequence[str] | None = None,
) -> TaxelSet:
    own: dict[str, Any] = {field: _checked(arrays, prefix + field) for field in _ARRAYS}
    positions = own.pop("positions")
    numbers = own.pop("numbers")
    normals = own.pop("normals")
    if positions is None:
        remedy = f"Name the array of positions {prefix}positions"
        raise SkinError("the file has no positions", value=", ".join(arrays), remedy=remedy)
    findings = list[Finding]()
    if normals is not None:
        normals = unit_normals(normals, where, findings) if len(normals) else None
    if own["ids"] is None:
        own["ids"] = numbers
    numbers = np.arange(len(positions)) if numbers is None else distinct_numbers(numbers, where, findings)
    own["tangents"] = stated_frames(
        own["axes"],
        own["tangents"],
        None,
        normals,
        where=where,
        findings=findings,
        place=lambda row: f"{prefix}tangents, row {row}",
    )
    own["names"] = None if names is None else tuple(names)
    return TaxelSet(name, link, numbers, positions, normals, findings=tuple(findings), **own)


def _checked(arrays: Mapping[str, NDArray[Any]], name: str) -> NDArray[Any] | None:
    values = arrays.get(name)
    if values is None:
        return None
    columns, kinds = _ARRAYS[name.rpartition("_")[2]]
    if values.ndim == 0 or values.shape[1:] != (() if columns == 1 else (columns,)) or values.dtype.kind not in kinds:
        found = f"{values.shape} {values.dtype}"
        raise SkinError("an array has the wrong shape or type", place=name, value=found)
    if values.dtype.kind == "u" and values.size and int(values.max()) >= 2**63:
        raise SkinError("a number is implausibly large", place=name, value=values.max())
    return values.astype(np.float64 if "f" in kinds else np.int64)
