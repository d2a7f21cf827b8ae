"""Skin files: npz with a version, checked completely when read."""

from __future__ import annotations

from collections.abc import Mapping, Sized
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import Finding, MeshError, SkinError, errors_in_file
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
VERSION = 5
_READS = (1, 2, 3, 4, VERSION)
"""Version 1 had no identity of taxels, version 2 no names, version 3 neither aliases nor streams, version 4 neither
axes nor tangents; the earliest version that has all of the skin is written."""
MAP_FORMAT = "tactile-maps-map"
"""Format of map files, which contain their skin as the bytes of a skin file."""
MAX_TAXELS = 1_000_000

# Columns, and what the integers index (None: any number); checked in this order.
_FLOATS = {
    "positions": 3,
    "normals": 3,
    "weights": 3,
    "areas": 1,
    "quadrature_positions": 3,
    "quadrature_normals": 3,
    "quadrature_areas": 1,
}
_INTEGERS = {"faces": (1, "face"), "neighbours": (2, "taxel"), "quadrature_taxel": (1, "taxel")}
_AXES_FIELDS = ("axes", "tangents")
_MAX_ROWS = dict.fromkeys(
    ("positions", "normals", "weights", "areas", "faces", "aliases", *_AXES_FIELDS, *IDENTITY_FIELDS), MAX_TAXELS
)


def save_skin(skin: Skin, path: str | Path) -> None:
    """Write ``skin`` to ``path`` (usually ``.npz``), completely or not at all.

    Raises:
        SkinError: The file cannot be written.
    """
    write_atomically(Path(path), skin_to_bytes(skin), error=SkinError)


def load_skin(path: str | Path) -> Skin:
    """Return the skin in a file of ``save_skin``, or in a map file, whose charts are not read.

    Raises:
        SkinError: The file does not exist, or is not a valid skin.
    """
    return skin_from_bytes(read_bounded_file(Path(path), error=SkinError, most=MAX_UNPACKED_BYTES), file=path)


@weak_cache
def skin_to_bytes(skin: Skin) -> bytes:
    """Return ``skin`` in the format of the file; equal skins give equal bytes."""
    arrays: dict[str, NDArray[Any]] = {}
    for i, patch in enumerate(skin.patches):
        taxels = patch.taxels
        quadrature = patch.taxels.quadrature
        fields: dict[str, NDArray[Any]] = {"surface_vertices": patch.surface.vertices}
        fields["surface_faces"] = patch.surface.faces
        for name in (*_FLOATS, *_INTEGERS):
            owner, part = (quadrature, name.removeprefix("quadrature_")) if "quadrature" in name else (taxels, name)
            fields[name] = getattr(owner, part)
        identity = {name: getattr(taxels.identity, name) for name in (*IDENTITY_FIELDS, "aliases")}
        stated = {name: getattr(taxels, name) for name in _AXES_FIELDS}
        fields |= {name: values for name, values in (identity | stated).items() if values is not None}
        arrays |= {f"{i}_{name}": values for name, values in fields.items()}
    patches = [_patch_header(patch) for patch in skin.patches]
    header = {
        "format": FORMAT,
        "version": _version(skin),
        "patches": patches,
        "findings": [[f.kind, f.where, f.action, f.count] for f in skin.findings],
    } | ({"bare_area": skin.bare_area} if skin.bare_area else {})
    return pack_arrays(header, arrays)


def _version(skin: Skin) -> int:
    if any(getattr(patch.taxels, name) is not None for patch in skin.patches for name in _AXES_FIELDS):
        return 5
    identities = [patch.taxels.identity for patch in skin.patches]
    if any(identity.aliases is not None or identity.stream is not None for identity in identities):
        return 4
    return 3 if any(identity.names is not None for identity in identities) else 2


def _patch_header(patch: Patch) -> dict[str, Any]:
    identity = patch.taxels.identity
    header: dict[str, Any] = {"name": patch.name, "link": patch.link}
    header |= {} if identity.names is None else {"taxels": list(identity.names)}
    return header | ({} if identity.stream is None else {"stream": identity.stream})


def skin_from_bytes(data: bytes, *, file: str | Path | None = None) -> Skin:
    """Return the skin in ``data``.

    Args:
        data: Bytes of ``skin_to_bytes``, or untrusted ones.
        file: Source of the data, for errors.

    Raises:
        SkinError: The data is damaged, hostile, of another format or a later version, or not a valid skin.
    """
    header, arrays = unpack_arrays(data, file=file, error=SkinError, max_rows=_MAX_ROWS)
    if header.get("format") == MAP_FORMAT and "skin" in arrays and arrays["skin"].dtype == np.uint8:
        return skin_from_bytes(arrays["skin"].tobytes(), file=file)
    with errors_in_file(file) if file else nullcontext():
        if header.get("format") != FORMAT:
            remedy = "Choose a file saved by Save skin"
            raise SkinError("this is not a skin file", value=header.get("format"), remedy=remedy)
        if header.get("version") not in _READS:
            remedy = f"This program reads versions {_READS[0]} to {VERSION}"
            raise SkinError("the skin file has an unknown version", value=header.get("version"), remedy=remedy)
        stated, findings, bare_area = _header(header)
        patches = tuple(_patch(arrays, i, one) for i, one in enumerate(stated))
        if sum(len(patch.taxels) for patch in patches) > MAX_TAXELS:
            raise SkinError("the skin has too many taxels", remedy=f"The maximum is {MAX_TAXELS}")
        return Skin(patches, findings, bare_area)


def _header(header: Mapping[str, Any]) -> tuple[list[dict[str, Any]], tuple[Finding, ...], float]:
    """Return the headers of the patches, the findings and the bare area."""
    patches = header.get("patches")
    findings = header.get("findings")
    bare_area = header.get("bare_area", 0.0)
    valid = (
        isinstance(patches, list)
        and all(isinstance(p, dict) and all(isinstance(p.get(k), str) for k in ("name", "link")) for p in patches)
        and all(_are_names(p.get("taxels", [])) and type(p.get("stream", 0)) is int for p in patches)
        and isinstance(findings, list)
        and all(isinstance(f, list) and [type(x) for x in f] == [str, str, str, int] for f in findings)
        and type(bare_area) in (int, float)
        and 0 <= bare_area < np.inf
    )
    if not valid or not isinstance(patches, list) or not isinstance(findings, list):
        raise SkinError("the header of the skin file is broken")
    names = [patch["name"] for patch in patches]
    if len(set(names)) < len(names):
        raise SkinError("two patches have the same name", value=names)
    return patches, tuple(Finding(*f) for f in findings), float(bare_area)


def _are_names(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(name, str) for name in value)


def _patch(arrays: Mapping[str, NDArray[Any]], i: int, stated: Mapping[str, Any]) -> Patch:
    name = stated["name"]
    own = _PatchArrays(arrays, i, name)
    try:
        surface = Mesh(own.floats("surface_vertices", 3), own.integers("surface_faces", 3))
    except MeshError as error:
        problem = f"the surface of the patch is broken: {error.problem}"
        raise error.at(kind=SkinError, problem=problem, place=name) from error
    values: dict[str, NDArray[Any]] = {key: own.floats(key, columns) for key, columns in _FLOATS.items()}
    values |= {key: own.integers(key, columns) for key, (columns, _) in _INTEGERS.items()}
    count = len(values["positions"])
    own.check(values, {"face": len(surface.faces), "taxel": count})
    points = {key: values.pop(f"quadrature_{key}") for key in ("positions", "normals", "areas", "taxel")}
    names = tuple(stated["taxels"]) if "taxels" in stated else None
    identity = own.identity(count, names, stated.get("stream"))
    quadrature = Quadrature(**points)
    try:
        taxels = Taxels(**values, quadrature=quadrature, identity=identity, **own.axes())
    except SkinError as error:
        raise error.at(place=f"patch {name}, {error.place}") from error
    return Patch(name, stated["link"], surface, taxels)


class _PatchArrays:
    """Arrays of one patch in a file, checked when they are taken."""

    def __init__(self, arrays: Mapping[str, NDArray[Any]], i: int, name: str) -> None:
        self._arrays = arrays
        self._i = i
        self._name = name

    def floats(self, key: str, columns: int) -> NDArray[Any]:
        """Return finite numbers, (n,) for one column, else (n, columns)."""
        values = self._take(key, columns).astype(np.float64)
        if not np.isfinite(values).all():
            raise self._refuse("a number is not finite", key, values[~np.isfinite(values)][0])
        return values

    def integers(self, key: str, columns: int) -> NDArray[Any]:
        """Return whole numbers, (n,) for one column, else (n, columns)."""
        values = self._take(key, columns)
        if values.dtype.kind not in "iu":
            raise self._refuse("an index is not a whole number", key, values.dtype)
        return values.astype(np.int64)

    def identity(self, count: int, names: tuple[str, ...] | None, stream: int | None) -> TaxelIdentity:
        """Return the stated identity of ``count`` taxels."""
        arrays = {key: self.integers(key, 1) for key in IDENTITY_FIELDS if f"{self._i}_{key}" in self._arrays}
        self._check_rows({**arrays, **({} if names is None else {"taxels": names})}, count)
        aliases = self.integers("aliases", 2) if f"{self._i}_aliases" in self._arrays else None
        try:
            return TaxelIdentity(**arrays, names=names, aliases=aliases, stream=stream)
        except SkinError as error:
            raise error.at(place=f"patch {self._name}, {error.place}") from error

    def axes(self) -> dict[str, NDArray[Any]]:
        """Return the stated axes and tangents, which ``Taxels`` checks."""
        own = {key: f"{self._i}_{key}" in self._arrays for key in _AXES_FIELDS}
        found = {"axes": self.integers("axes", 1)} if own["axes"] else {}
        return found | ({"tangents": self._take("tangents", 3)} if own["tangents"] else {})

    def _check_rows(self, columns: Mapping[str, Sized], count: int) -> None:
        for key, values in columns.items():
            if len(values) != count:
                raise self._refuse(f"{count} rows expected", key, len(values))

    def check(self, values: Mapping[str, NDArray[Any]], counts: Mapping[str, int]) -> None:
        """Check that counts agree, indices are in range, areas are above zero and sums are right."""
        for key, (_, what) in _INTEGERS.items():
            bad = (values[key] < 0) | (values[key] >= counts[what])
            if bad.any():
                raise self._refuse(f"there is no such {what}", key, values[key][bad][0])
        points = {key: part for key, part in values.items() if "quadrature" in key}
        self._check_rows(points, len(values["quadrature_positions"]))
        own = {key: part for key, part in values.items() if key not in (*points, "neighbours")}
        self._check_rows(own, counts["taxel"])
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
        return SkinError(problem, place=f"patch {self._name}, {key}", value=value)
