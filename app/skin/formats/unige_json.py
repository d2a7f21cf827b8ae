"""Skins and their maps as the robot skin library of the University of Genoa keeps them (JSON, file version 2).

``skin`` holds ``taxels`` (id, place x [m], normal n, type, cut; module and channel where known) and ``faces`` over
them; each of ``tactile_maps`` holds its own taxels (id, place x on the map [m], type, cut) and faces. Identity numbers
repeat in real files, so a taxel is known by its index; a map's taxel is the skin's with the same index if their numbers
agree throughout, else the next one with its number.
"""

from __future__ import annotations

import json
from collections import defaultdict, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.core.arrays import FloatArray, IntArray, freeze_arrays
from app.core.codec import parse_json
from app.core.errors import Finding, SkinError, add_finding, errors_in_file
from app.core.files import read_bounded_text, write_atomically
from app.skin.formats.taxel_set import MAX_COORDINATE, MAX_TAXELS, TaxelSet, distinct_numbers, unit_normals

FILE_VERSION = 2
_LARGEST_NUMBER = 2**31
_PRESSURE = "pressure"
_NO_ID = -1
"""What real files write for a taxel that no board reads."""


@dataclass(frozen=True, eq=False)
class UnigeMap:
    """One flat map in such a file.

    Attributes:
        name: For people.
        taxels: (k,) indices of the skin's taxels; one may come twice, on both sides of a cut.
        points: (k, 2) where they lie on the map [m].
        faces: (f, 3) triangles over the map's own taxels.
        description: For people.
    """

    name: str
    taxels: IntArray
    points: FloatArray
    faces: IntArray
    description: str = ""

    def __post_init__(self) -> None:
        freeze_arrays(self, "points")
        freeze_arrays(self, "taxels", "faces", dtype=np.int64)


@dataclass(frozen=True, eq=False)
class UnigeFile:
    """A skin and its maps.

    Attributes:
        taxels: With faces; its link is the parent frame's name, its findings are those of the whole file.
        maps: In the file's order.
    """

    taxels: TaxelSet
    maps: tuple[UnigeMap, ...] = ()

    def with_points(self, map_number: int = 0) -> TaxelSet:
        """The taxels with their places on one of the maps; at a cut, the first place is taken."""
        chosen = self.maps[map_number]
        points = np.full((len(self.taxels), 2), np.nan)
        points[chosen.taxels[::-1]] = chosen.points[::-1]
        taxels = replace(self.taxels, points=points)
        missing = int((~taxels.mapped).sum())
        where = f"map {chosen.name}"
        notes = (Finding("not-on-map", where, "the taxel has no place on the map", missing),) if missing else ()
        return taxels.with_findings(*notes)


def read_unige(path: str | Path) -> UnigeFile:
    """The skin and the maps in the file at ``path``.

    Raises:
        SkinError: It cannot be read, or something in it is not what it should be; names the place.
    """
    path = Path(path)
    document = _object(_parse(path), "the file", path)
    reader = _Reader(path)
    skin = _object(document.get("skin"), "skin", path)
    with errors_in_file(path):
        taxels, ids = reader.skin(skin, document)
        maps = tuple(
            reader.map(_object(entry, f"tactile_maps {k}", path), k, ids)
            for k, entry in enumerate(_list(document.get("tactile_maps", []), "tactile_maps", path))
        )
        return UnigeFile(taxels.with_findings(*reader.findings), maps)


def write_unige(file: UnigeFile, path: str | Path) -> None:
    """Write ``file`` with the taxels' ids, or else their numbers, and their modules and channels where known.

    Raises:
        SkinError: The file cannot be written.
    """
    taxels = file.taxels
    ids = taxels.stated_ids.tolist()
    cut = [np.bincount(map_.taxels, minlength=len(taxels))[map_.taxels] > 1 for map_ in file.maps]
    frame = {"key": 0, "id": 0, "type": "ROS", "name": taxels.link or "", "tf_matrix": np.eye(4).tolist()}
    document = {
        "info": {"file_version": FILE_VERSION, "type": "rigid_body", "name": taxels.name},
        "skin": {
            "n_taxels": len(taxels),
            "n_faces": 0 if taxels.faces is None else len(taxels.faces),
            "parent_frames": [frame],
            "taxels": _skin_entries(taxels),
            "faces": [] if taxels.faces is None else taxels.faces.tolist(),
        },
        "tactile_maps": [
            {
                "key": k, "name": map_.name, "type": "2D", "description": map_.description,
                "n_taxels": len(map_.taxels), "n_faces": len(map_.faces),
                "taxels": _taxel_entries([ids[i] for i in map_.taxels.tolist()], map_.points, cut[k]),
                "faces": map_.faces.tolist(),
            }
            for k, map_ in enumerate(file.maps)
        ],
    }  # fmt: skip
    text = json.dumps(document, ensure_ascii=False, indent=1)
    write_atomically(Path(path), text.encode("utf-8", errors="replace"), error=SkinError)


def _skin_entries(taxels: TaxelSet) -> list[dict[str, Any]]:
    ids, uncut = taxels.stated_ids.tolist(), np.zeros(len(taxels))
    entries = _taxel_entries(ids, taxels.positions, uncut, normals=taxels.normals)
    for key, values in (("module", taxels.modules), ("channel", taxels.channels)):
        if values is not None:
            for entry, number in zip(entries, values.tolist(), strict=True):
                entry[key] = number
    return entries


def _taxel_entries(
    ids: Sequence[int], places: FloatArray, cut: NDArray[Any], *, normals: FloatArray | None = None
) -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = [
        {"id": number, "x": place, "type": _PRESSURE, "cut": int(flag)}
        for number, place, flag in zip(ids, places.tolist(), cut.tolist(), strict=True)
    ]
    if normals is not None:
        for entry, normal in zip(entries, normals.tolist(), strict=True):
            entry["n"] = normal
    return entries


class _Reader:
    """Reads the parts of one file and gathers what is noticed."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.findings: list[Finding] = []
        self._row_of: IntArray = np.zeros(0, dtype=np.int64)

    def skin(self, skin: Mapping[str, Any], document: Mapping[str, Any]) -> tuple[TaxelSet, IntArray]:
        """The taxels that have an identity number, and (n,) the number that the file gives each, -1 for none."""
        where = self._path.name
        entries = self._taxels(skin, "skin")
        ids = self._ids(entries, "skin")
        kept = np.flatnonzero(ids != _NO_ID)
        add_finding(self.findings, "taxel-without-id", where, "left out: its id is -1", len(ids) - len(kept))
        if not len(kept):
            raise self._refuse("no taxel has an id", "skin", len(ids))
        self._row_of = np.full(len(ids), -1)
        self._row_of[kept] = np.arange(len(kept))
        normals = None
        if all("n" in entry for entry in entries):
            normals = unit_normals(self._vectors(entries, "n", 3, "skin")[kept], where, self.findings)
        faces = self._faces(skin, "skin")
        unknown = (faces >= len(ids)).any(axis=1)
        if unknown.any():
            row = int(unknown.argmax())
            raise self._refuse("a face names a taxel that does not exist", f"faces, row {row}", faces[row].tolist())
        faces = self._row_of[faces]
        faces = faces[(faces >= 0).all(axis=1)]
        odd = sum(entry.get("type", _PRESSURE) != _PRESSURE for entry in entries)
        add_finding(self.findings, "not-pressure", where, "kept, though the taxel's type is another", odd)
        info = document.get("info")
        name = info.get("name") if isinstance(info, dict) else None
        taxels = TaxelSet(
            name=name if isinstance(name, str) and name.strip() else self._path.stem,
            link=self._link(skin),
            numbers=distinct_numbers(ids[kept], where, self.findings),
            ids=ids[kept],
            modules=self._optional(entries, kept, "module"),
            channels=self._optional(entries, kept, "channel"),
            positions=self._vectors(entries, "x", 3, "skin")[kept],
            normals=normals,
            faces=faces if len(faces) else None,
        )
        return taxels, ids

    def map(self, entry: Mapping[str, Any], key: int, skin_ids: IntArray) -> UnigeMap:
        """One of the maps."""
        place = f"tactile_maps {key}"
        entries = self._taxels(entry, place)
        points, faces = self._vectors(entries, "x", 2, place), self._faces(entry, place)
        if not (np.abs(points) <= MAX_COORDINATE).all():
            raise self._refuse(f"a map point is not within {MAX_COORDINATE:g} m", place, float(np.abs(points).max()))
        if ((faces < 0) | (faces >= len(points))).any():
            raise self._refuse("a face names a taxel that the map does not have", place, int(np.abs(faces).max()))
        taxels = self._indices(self._ids(entries, place), skin_ids, place)
        taxels = np.where(taxels >= 0, self._row_of[taxels], -1)
        known = taxels >= 0
        if not known.all():
            add_finding(
                self.findings,
                "unknown-taxel",
                place,
                "left out: the skin has no taxel of its number",
                int((~known).sum()),
            )
            renumbered = np.cumsum(known) - 1
            faces = renumbered[faces[known[faces].all(axis=1)]]
            taxels, points = taxels[known], points[known]
        if not len(taxels):
            raise self._refuse("the map shows none of the skin's taxels", place, None)
        name, description = (entry.get(field) for field in ("name", "description"))
        return UnigeMap(str(name or place), taxels, points, faces.reshape(-1, 3), str(description or ""))

    def _indices(self, ids: IntArray, skin_ids: IntArray, place: str) -> IntArray:
        """(k,) index of the skin's taxel behind each of the map's; -1 for none."""
        if len(ids) <= len(skin_ids) and (ids == skin_ids[: len(ids)]).all():
            return np.arange(len(ids))
        waiting: dict[int, deque[int]] = defaultdict(deque)
        for index, number in enumerate(skin_ids.tolist()):
            waiting[number].append(index)
        found = []
        for number in ids.tolist():
            queue = waiting.get(number)
            # The last taxel of its number stays: a cut shows it again.
            found.append(-1 if not queue else queue.popleft() if len(queue) > 1 else queue[0])
        indices = np.array(found, dtype=np.int64)
        again = len(indices) - len(np.unique(indices))
        add_finding(self.findings, "shown-twice", place, "the map shows a taxel at several places", again)
        return indices

    def _taxels(self, part: Mapping[str, Any], place: str) -> list[Mapping[str, Any]]:
        """The entries; older files hold one list a parent frame."""
        entries: list[Any] = []
        for entry in _list(part.get("taxels"), f"{place}, taxels", self._path):
            entries += entry if isinstance(entry, list) else [entry]
        if not 1 <= len(entries) <= MAX_TAXELS:
            raise self._refuse(f"there must be 1 to {MAX_TAXELS} taxels", place, len(entries))
        self._compare(part, "n_taxels", len(entries), place)
        return [_object(entry, f"{place}, taxel {k}", self._path) for k, entry in enumerate(entries)]

    def _faces(self, part: Mapping[str, Any], place: str) -> IntArray:
        faces = _list(part.get("faces", []), f"{place}, faces", self._path)
        for k, face in enumerate(faces):
            if not (isinstance(face, list) and len(face) == 3 and all(_is_whole(i) for i in face)):
                raise self._refuse("a face must be three indices", f"{place}, face {k}", face)
        self._compare(part, "n_faces", len(faces), place)
        return np.array(faces, dtype=np.int64).reshape(-1, 3)

    def _compare(self, part: Mapping[str, Any], field: str, count: int, place: str) -> None:
        stated = part.get(field, count)
        if stated != count:
            self.findings.append(Finding("count-mismatch", place, f"{field} says {stated}, there are {count}"))

    def _ids(self, entries: Sequence[Mapping[str, Any]], place: str) -> IntArray:
        ids = [entry.get("id") for entry in entries]
        for k, number in enumerate(ids):
            if not (_is_whole(number) or (type(number) is int and number == _NO_ID)):
                raise self._refuse("id must be a whole number, -1 for none", f"{place}, taxel {k}", number)
        return np.array(ids, dtype=np.int64)

    def _optional(self, entries: Sequence[Mapping[str, Any]], kept: IntArray, key: str) -> IntArray | None:
        """Whole numbers that every taxel may state; None where one of those ``kept`` does not."""
        values = [entries[k].get(key) for k in kept.tolist()]
        if not all(_is_whole(value) for value in values):
            some = sum(value is not None for value in values)
            add_finding(self.findings, f"{key}-unknown", "skin", "not used: not a whole number of every taxel", some)
            return None
        return np.array(values, dtype=np.int64)

    def _vectors(self, entries: Sequence[Mapping[str, Any]], field: str, count: int, place: str) -> FloatArray:
        for k, entry in enumerate(entries):
            value = entry.get(field)
            if not (isinstance(value, list) and len(value) == count and all(_is_finite(x) for x in value)):
                raise self._refuse(f"{field} must be {count} finite numbers", f"{place}, taxel {k}", value)
        return np.array([entry[field] for entry in entries], dtype=np.float64)

    def _link(self, skin: Mapping[str, Any]) -> str | None:
        """The parent frame's name."""
        frames = skin.get("parent_frames", skin.get("parent_frame", []))
        frames = [
            _object(f, "skin, parent_frames", self._path) for f in (frames if isinstance(frames, list) else [frames])
        ]
        more = "only the first is used; positions are taken as stated"
        add_finding(self.findings, "several-frames", self._path.name, more, max(len(frames) - 1, 0))
        if not frames:
            return None
        matrix = frames[0].get("tf_matrix", np.eye(4).tolist())
        if matrix != np.eye(4).tolist():
            self.findings.append(Finding("frame-transform", self._path.name, "tf_matrix is not applied to the taxels"))
        return str(frames[0].get("name") or "").strip() or None

    def _refuse(self, problem: str, place: str, value: object) -> SkinError:
        return SkinError(problem, file=self._path, place=place, value=value)


def _parse(path: Path) -> object:
    try:
        document: object = parse_json(read_bounded_text(path, error=SkinError), constants=True)
    except (ValueError, RecursionError) as error:
        remedy = "Open it in an editor at that line, or export it again"
        raise SkinError("the file is not valid JSON", file=path, value=error, remedy=remedy) from error
    return document


def _object(value: object, place: str, path: Path) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise SkinError("an object is missing or of another kind", file=path, place=place, value=type(value).__name__)
    return value


def _list(value: object, place: str, path: Path) -> list[Any]:
    if not isinstance(value, list):
        raise SkinError("a list is missing or of another kind", file=path, place=place, value=type(value).__name__)
    return value


def _is_whole(value: object) -> bool:
    return type(value) is int and 0 <= value < _LARGEST_NUMBER


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
