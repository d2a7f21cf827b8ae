"""Taxels as named arrays (npz): read from anyone without trust, written so that ``numpy.load`` opens them.

Names of one set: ``positions`` (n, 3) [m], and where known ``numbers``, ``normals``, ``faces``, ``points``, ``ids``,
``modules`` and ``channels``, as in ``TaxelSet``; where there are no ``ids``, ``numbers`` are. Files of this program
hold several sets, each name with its set's number before it, and a header.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
from tactile_maps.skin.model.taxel_set import MAX_TAXELS, TaxelSet, distinct_numbers, unit_normals

FORMAT = "tactile-maps-taxels"
VERSION = 3
_READS = (1, 2, VERSION)
"""Version 1 had no ``ids`` and ``channels``, version 2 no names of taxels."""
# Columns and kinds of a set's arrays.
_ARRAYS = {
    "positions": (3, "fiu"), "numbers": (1, "iu"), "normals": (3, "f"),
    "faces": (3, "iu"), "points": (2, "f"), "modules": (1, "iu"),
    "ids": (1, "iu"), "channels": (1, "iu"),
}  # fmt: skip
_MAX_ROWS = dict.fromkeys(_ARRAYS, MAX_TAXELS) | {"faces": 10 * MAX_TAXELS}


def read_taxel_npz(path: str | Path) -> tuple[TaxelSet, ...]:
    """The taxels in the npz at ``path``, by this program or with plain names.

    Raises:
        SkinError: Damaged, hostile, without positions, or not sound taxels.
    """
    path = Path(path)
    data = read_bounded_file(path, error=SkinError)
    bare = unpack_bare_arrays(data, file=path, error=SkinError, max_rows=_MAX_ROWS)
    if "header" not in bare:
        return (_taxel_set(bare, "", path.stem, None, path),)
    header, arrays = unpack_arrays(data, file=path, error=SkinError, max_rows=_MAX_ROWS)
    if header.get("format") != FORMAT or header.get("version") not in _READS:
        found = f"{header.get('format')} {header.get('version')}"
        remedy = f"This program reads taxels of versions {_READS[0]} to {VERSION}; open skins and maps as such"
        raise SkinError("this is not a file of taxels", file=path, value=found, remedy=remedy)
    stated = header.get("sets")
    if not isinstance(stated, list) or not stated or not all(_is_name(entry) for entry in stated):
        raise SkinError("the file's header is broken", file=path, place="sets")
    names = header.get("names", [None] * len(stated))
    if not isinstance(names, list) or len(names) != len(stated) or not all(_are_names(own) for own in names):
        raise SkinError("the file's header is broken", file=path, place="names")
    return tuple(_taxel_set(arrays, f"{i}_", name, link, path, names[i]) for i, (name, link) in enumerate(stated))


def write_taxel_npz(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` with all they know but their findings.

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
        "version": VERSION,
        "sets": [[taxels.name, taxels.link] for taxels in sets],
        "names": [None if taxels.names is None else list(taxels.names) for taxels in sets],
    }
    write_atomically(Path(path), pack_arrays(header, arrays), error=SkinError)


def _is_name(entry: object) -> bool:
    return (
        isinstance(entry, list)
        and len(entry) == 2
        and isinstance(entry[0], str)
        and (entry[1] is None or isinstance(entry[1], str))
    )


def _are_names(value: object) -> bool:
    return value is None or (isinstance(value, list) and all(isinstance(name, str) for name in value))


def _taxel_set(
    arrays: Mapping[str, NDArray[Any]],
    prefix: str,
    name: str,
    link: str | None,
    path: Path,
    names: Sequence[str] | None = None,
) -> TaxelSet:
    take = {field: _take(arrays, prefix + field, path) for field in _ARRAYS}
    positions = take.pop("positions")
    numbers = take.pop("numbers")
    normals = take.pop("normals")
    if positions is None:
        remedy = f"Name the array of places {prefix}positions"
        raise SkinError("the file has no positions", file=path, value=", ".join(arrays), remedy=remedy)
    findings: list[Finding] = []
    with errors_in_file(path):
        if normals is not None:
            normals = unit_normals(normals, path.name, findings) if len(normals) else None
        if take["ids"] is None:
            take["ids"] = numbers
        numbers = np.arange(len(positions)) if numbers is None else distinct_numbers(numbers, path.name, findings)
        return TaxelSet(
            name,
            link,
            numbers,
            positions,
            normals,
            findings=tuple(findings),
            names=None if names is None else tuple(names),
            faces=take["faces"],
            points=take["points"],
            modules=take["modules"],
            ids=take["ids"],
            channels=take["channels"],
        )


def _take(arrays: Mapping[str, NDArray[Any]], name: str, path: Path) -> NDArray[Any] | None:
    values = arrays.get(name)
    if values is None:
        return None
    columns, kinds = _ARRAYS[name.rpartition("_")[2]]
    if values.ndim == 0 or values.shape[1:] != (() if columns == 1 else (columns,)) or values.dtype.kind not in kinds:
        raise SkinError(
            "an array has the wrong shape or type", file=path, place=name, value=f"{values.shape} {values.dtype}"
        )
    if values.dtype.kind == "u" and values.size and int(values.max()) >= 2**63:
        raise SkinError("a number is implausibly large", file=path, place=name, value=values.max())
    return values.astype(np.float64 if "f" in kinds else np.int64)
