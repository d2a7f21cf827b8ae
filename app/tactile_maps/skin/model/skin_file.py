"""Skins as files: npz with a version, checked when read so that nothing later needs to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import Finding, MeshError, SkinError
from tactile_maps.core.files import (
    MAX_UNPACKED_BYTES,
    pack_arrays,
    read_bounded_file,
    unpack_arrays,
    write_atomically,
)
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import IDENTITY_FIELDS, Patch, Quadrature, Skin, TaxelIdentity, Taxels

FORMAT = "tactile-maps-skin"
VERSION = 3
_READS = (1, 2, VERSION)
"""Version 1 had no identity of taxels, version 2 no names of them; where there are none, 2 is written."""
MAP_FORMAT = "tactile-maps-map"
"""Of the files of maps, which keep their skin as the bytes of a skin file."""
MAX_TAXELS = 1_000_000

# Columns, and what the integers index (None: any number); checked in this order.
_FLOATS = {
    "positions": 3, "normals": 3, "weights": 3, "areas": 1,
    "quadrature_positions": 3, "quadrature_normals": 3, "quadrature_areas": 1,
}  # fmt: skip
_INTEGERS = {"faces": (1, "face"), "neighbours": (2, "taxel"), "quadrature_taxel": (1, "taxel")}
_MAX_ROWS = dict.fromkeys(("positions", "normals", "weights", "areas", "faces", *IDENTITY_FIELDS), MAX_TAXELS)


def save_skin(skin: Skin, path: str | Path) -> None:
    """Write ``skin`` to ``path`` (usually ``.npz``), whole or not at all.

    Raises:
        SkinError: The file cannot be written.
    """
    write_atomically(Path(path), skin_to_bytes(skin), error=SkinError)


def load_skin(path: str | Path) -> Skin:
    """The skin that ``save_skin`` wrote to ``path``, or that a map file keeps beside its charts, which are not read.

    Raises:
        SkinError: There is no such file, or it is not a sound skin.
    """
    return skin_from_bytes(read_bounded_file(Path(path), error=SkinError, most=MAX_UNPACKED_BYTES), file=path)


def skin_to_bytes(skin: Skin) -> bytes:
    """``skin`` in the file's format; the same skin gives the same bytes."""
    arrays: dict[str, NDArray[Any]] = {}
    for i, patch in enumerate(skin.patches):
        taxels = patch.taxels
        quadrature = patch.taxels.quadrature
        fields: dict[str, NDArray[Any]] = {"surface_vertices": patch.surface.vertices}
        fields["surface_faces"] = patch.surface.faces
        for name in (*_FLOATS, *_INTEGERS):
            owner, part = (quadrature, name.removeprefix("quadrature_")) if "quadrature" in name else (taxels, name)
            fields[name] = getattr(owner, part)
        identity = {name: getattr(taxels.identity, name) for name in IDENTITY_FIELDS}
        fields |= {name: values for name, values in identity.items() if values is not None}
        arrays |= {f"{i}_{name}": values for name, values in fields.items()}
    patches = [_patch_header(patch) for patch in skin.patches]
    header = {
        "format": FORMAT,
        "version": VERSION if any("taxels" in patch for patch in patches) else VERSION - 1,
        "patches": patches,
        "findings": [[f.kind, f.where, f.action, f.count] for f in skin.findings],
    } | ({"bare_area": skin.bare_area} if skin.bare_area else {})
    return pack_arrays(header, arrays)


def _patch_header(patch: Patch) -> dict[str, Any]:
    names = patch.taxels.identity.names
    return {"name": patch.name, "link": patch.link} | ({} if names is None else {"taxels": list(names)})


def skin_from_bytes(data: bytes, *, file: str | Path | None = None) -> Skin:
    """The skin in ``data``.

    Args:
        data: From ``skin_to_bytes``, or from anyone.
        file: Where it came from, for errors.

    Raises:
        SkinError: Damaged, hostile, of another format or a later version, or not a sound skin.
    """
    header, arrays = unpack_arrays(data, file=file, error=SkinError, max_rows=_MAX_ROWS)
    if header.get("format") == MAP_FORMAT and "skin" in arrays and arrays["skin"].dtype == np.uint8:
        return skin_from_bytes(arrays["skin"].tobytes(), file=file)
    if header.get("format") != FORMAT:
        raise SkinError(
            "this is not a skin file", file=file, value=header.get("format"), remedy="Choose a file saved by Save skin"
        )
    if header.get("version") not in _READS:
        raise SkinError(
            "the skin file has an unknown version",
            file=file,
            value=header.get("version"),
            remedy=f"This program reads versions {_READS[0]} to {VERSION}",
        )
    stated, findings, bare_area = _header(header, file)
    patches = tuple(_patch(arrays, i, one, file) for i, one in enumerate(stated))
    if sum(len(patch.taxels) for patch in patches) > MAX_TAXELS:
        raise SkinError("the skin has too many taxels", file=file, remedy=f"The most is {MAX_TAXELS}")
    return Skin(patches, findings, bare_area)


@dataclass(frozen=True)
class _PatchHeader:
    """A patch's name and link, and its taxels' names, None where they have none."""

    name: str
    link: str
    taxels: tuple[str, ...] | None


def _header(
    header: Mapping[str, Any], file: str | Path | None
) -> tuple[list[_PatchHeader], tuple[Finding, ...], float]:
    """The headers of the patches, the findings and the bare area."""
    patches = header.get("patches")
    findings = header.get("findings")
    bare_area = header.get("bare_area", 0.0)
    sound = (
        isinstance(patches, list)
        and all(isinstance(p, dict) and all(isinstance(p.get(k), str) for k in ("name", "link")) for p in patches)
        and all(_are_names(p.get("taxels", [])) for p in patches)
        and isinstance(findings, list)
        and all(isinstance(f, list) and [type(x) for x in f] == [str, str, str, int] for f in findings)
        and type(bare_area) in (int, float)
        and 0 <= bare_area < np.inf
    )
    if not sound or not isinstance(patches, list) or not isinstance(findings, list):
        raise SkinError("the skin file's header is broken", file=file)
    stated = [_PatchHeader(p["name"], p["link"], tuple(p["taxels"]) if "taxels" in p else None) for p in patches]
    if len({one.name for one in stated}) < len(stated):
        raise SkinError("two patches have the same name", file=file, value=[one.name for one in stated])
    return stated, tuple(Finding(*f) for f in findings), float(bare_area)


def _are_names(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(name, str) for name in value)


def _patch(arrays: Mapping[str, NDArray[Any]], i: int, stated: _PatchHeader, file: str | Path | None) -> Patch:
    name = stated.name
    link = stated.link
    door = _Door(arrays, i, name, file)
    try:
        surface = Mesh(door.floats("surface_vertices", 3), door.integers("surface_faces", 3))
    except MeshError as error:
        problem = f"the patch's surface is broken: {error.problem}"
        raise error.at(kind=SkinError, problem=problem, file=file, place=name) from error
    values: dict[str, NDArray[Any]] = {key: door.floats(key, columns) for key, columns in _FLOATS.items()}
    values |= {key: door.integers(key, columns) for key, (columns, _) in _INTEGERS.items()}
    counts = {"face": len(surface.faces), "taxel": len(values["positions"])}
    door.check(values, counts)
    points = {key: values.pop(f"quadrature_{key}") for key in ("positions", "normals", "areas", "taxel")}
    quadrature = Quadrature(**points)
    identity = door.identity(counts["taxel"], stated.taxels)
    return Patch(name, link, surface, Taxels(**values, quadrature=quadrature, identity=identity))


class _Door:
    """Takes one patch's arrays out of the file and lets only sound ones in."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], i: int, name: str, file: str | Path | None) -> None:
        self._arrays = arrays
        self._i = i
        self._name = name
        self._file = file

    def floats(self, key: str, columns: int) -> NDArray[Any]:
        """Finite numbers, (n,) for one column, else (n, columns)."""
        values = self._take(key, columns).astype(np.float64)
        if not np.isfinite(values).all():
            raise self._refuse("a number is not finite", key, values[~np.isfinite(values)][0])
        return values

    def integers(self, key: str, columns: int) -> NDArray[Any]:
        """Whole numbers, (n,) for one column, else (n, columns)."""
        values = self._take(key, columns)
        if values.dtype.kind not in "iu":
            raise self._refuse("an index is not a whole number", key, values.dtype)
        return values.astype(np.int64)

    def identity(self, count: int, names: tuple[str, ...] | None) -> TaxelIdentity:
        """What the file states of it, in as many rows as there are taxels."""
        if names is not None and len(names) != count:
            raise self._refuse(f"{count} rows expected", "taxels", len(names))
        stated = [key for key in IDENTITY_FIELDS if f"{self._i}_{key}" in self._arrays]
        arrays = {key: self.integers(key, 1) for key in stated}
        for key, values in arrays.items():
            if len(values) != count:
                raise self._refuse(f"{count} rows expected", key, len(values))
        try:
            return TaxelIdentity(**arrays, names=names)
        except SkinError as error:
            raise error.at(file=self._file, place=f"patch {self._name}, {error.place}") from error

    def check(self, values: Mapping[str, NDArray[Any]], counts: Mapping[str, int]) -> None:
        """Counts that agree, indices in range, areas above zero."""
        for key, (_, what) in _INTEGERS.items():
            bad = (values[key] < 0) | (values[key] >= counts[what])
            if bad.any():
                raise self._refuse(f"there is no such {what}", key, values[key][bad][0])
        for key, rows in {key: len(part) for key, part in values.items() if key != "neighbours"}.items():
            expected = len(values["quadrature_positions"]) if "quadrature" in key else counts["taxel"]
            if rows != expected:
                raise self._refuse(f"{expected} rows expected", key, rows)
        for key in ("areas", "quadrature_areas"):
            if (values[key] <= 0).any():
                raise self._refuse("an area is not above zero", key, values[key].min())
        summed = np.bincount(values["quadrature_taxel"], values["quadrature_areas"], minlength=counts["taxel"])
        if not np.allclose(summed, values["areas"], rtol=1e-9, atol=0):
            raise self._refuse("the areas are not the sums of their quadrature points", "areas", None)
        if (values["weights"] < 0).any() or not np.allclose(values["weights"].sum(axis=1), 1, rtol=0, atol=1e-9):
            raise self._refuse("barycentric weights must not be negative and sum to one", "weights", None)

    def _take(self, key: str, columns: int) -> NDArray[Any]:
        values = self._arrays.get(f"{self._i}_{key}")
        if values is None:
            raise self._refuse("an array is missing", key, None)
        if values.shape[1:] != (() if columns == 1 else (columns,)) or values.ndim == 0:
            raise self._refuse("an array has the wrong shape", key, values.shape)
        return values

    def _refuse(self, problem: str, key: str, value: object) -> SkinError:
        return SkinError(problem, file=self._file, place=f"patch {self._name}, {key}", value=value)
