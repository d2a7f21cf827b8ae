"""Skins and their maps as the robot skin library of the University of Genoa keeps them (JSON, file version 2).

``skin`` holds ``taxels`` (id, place x [m], normal n, type, cut; module, channel, name where known) and ``faces`` over
them; each of ``tactile_maps``, a list or a single map, holds its own taxels (id, place x on the map [m], type, cut)
and faces. Identity numbers repeat in real files, so a taxel is known by its index; a map's taxel is the skin's with the
same index if their numbers agree throughout, else the next one with its number.

Real files also state places in millimetres, and the pose of the skin in its parent frame (``tf_matrix``, 16 numbers by
columns). Some hold a map alone. Where their taxels are on a body nobody knows, but all that is asked of a map has an
answer without: such a file is read as a flat skin in the plane of its map, whose lengths are the map's, and says so.
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

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import Finding, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text, write_atomically
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.taxel_set import (
    MAX_COORDINATE,
    MAX_TAXELS,
    TaxelSet,
    distinct_numbers,
    length_unit,
    unit_normals,
)

FILE_VERSION = 2
_LARGEST_NUMBER = 2**31
_PRESSURE = "pressure"
_NO_ID = -1
"""What real files write for a taxel that no board reads."""
_ROUNDED = 1e-3
"""A rotation is written with four digits; more than this off is none."""


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
    """The skin and the maps in the file at ``path``; of a file with maps alone, the skin is its first map, flat.

    Raises:
        SkinError: It cannot be read, or something in it is not what it should be; names the place.
    """
    path = Path(path)
    document = _object(_parse(path), "the file", path)
    reader = _Reader(path, _stated_unit(document))
    maps = _maps(document, path)
    with errors_in_file(path):
        if "skin" not in document and not maps:
            remedy = "Write the points as CSV with the columns x_mm, y_mm, z_mm (and nx, ny, nz), or Genoa's JSON"
            found = ", ".join(document) or "an empty object"
            raise SkinError("this JSON has no skin and no map of Genoa's format", file=path, value=found, remedy=remedy)
        if "skin" in document:
            taxels, ids = reader.skin(_object(document.get("skin"), "skin", path), document)
        else:
            taxels, ids = reader.flat_skin(maps[0])
        drawn = tuple(reader.map(entry, k, ids) for k, entry in enumerate(maps))
        return UnigeFile(taxels.with_findings(*reader.findings), drawn)


def _maps(document: Mapping[str, Any], path: Path) -> list[Mapping[str, Any]]:
    """The maps, of which some files hold a single one without a list."""
    stated = document.get("tactile_maps", [])
    entries = [stated] if isinstance(stated, dict) and stated else _list(stated, "tactile_maps", path)
    return [_object(entry, f"tactile_maps {k}", path) for k, entry in enumerate(entries)]


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
        "info": {"file_version": FILE_VERSION, "type": "rigid_body", "name": taxels.name, "unit": "m"},
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
    ids = taxels.stated_ids.tolist()
    uncut = np.zeros(len(taxels))
    entries = _taxel_entries(ids, taxels.positions, uncut, normals=taxels.normals)
    numbers = ((key, values) for key, values in (("module", taxels.modules), ("channel", taxels.channels)))
    known = [(key, values.tolist()) for key, values in numbers if values is not None]
    for key, column in (*known, *(() if taxels.names is None else (("name", list(taxels.names)),))):
        for entry, value in zip(entries, column, strict=True):
            entry[key] = value
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

    def __init__(self, path: Path, unit: float | None) -> None:
        self._path = path
        self._unit = unit
        self.findings: list[Finding] = []
        self._row_of: IntArray = np.zeros(0, dtype=np.int64)

    def skin(self, skin: Mapping[str, Any], document: Mapping[str, Any]) -> tuple[TaxelSet, IntArray]:
        """The taxels that have an identity number, and (n,) the number that the file gives each, -1 for none."""
        where = self._path.name
        entries = self._taxels(skin, "skin")
        ids = self._ids(entries, "skin")
        kept = self._identified(ids, "skin")
        normals = None
        if all("n" in entry for entry in entries):
            normals = unit_normals(self._vectors(entries, "n", 3, "skin")[kept], where, self.findings)
        faces = self._kept_faces(skin, len(ids), "skin")
        odd = sum(entry.get("type", _PRESSURE) != _PRESSURE for entry in entries)
        add_finding(self.findings, "not-pressure", where, "kept, though the taxel's type is another", odd)
        info = document.get("info")
        name = info.get("name") if isinstance(info, dict) else None
        link, pose = self._frame(skin)
        positions = self._places(entries, 3, "skin")[kept]
        taxels = TaxelSet(
            name=name if isinstance(name, str) and name.strip() else self._path.stem,
            link=link,
            numbers=distinct_numbers(ids[kept], where, self.findings),
            ids=ids[kept],
            modules=self._optional(entries, kept, "module"),
            channels=self._optional(entries, kept, "channel"),
            names=_names([entries[row] for row in kept.tolist()]),
            positions=pose.points(positions),
            normals=None if normals is None else pose.directions(normals),
            faces=faces if len(faces) else None,
        )
        return taxels, ids

    def flat_skin(self, map_: Mapping[str, Any]) -> tuple[TaxelSet, IntArray]:
        """The taxels of a map that comes without a skin, in its plane, and (n,) the number the file gives each."""
        place = "tactile_maps 0"
        name = str(map_.get("name") or self._path.stem)
        entries = self._taxels(map_, place)
        ids = self._ids(entries, place)
        kept = self._identified(ids, place)
        faces = self._kept_faces(map_, len(ids), place)
        told = len(self.findings)
        points = self._places(entries, 2, place)[kept]
        del self.findings[told:]  # the map itself is read after, and tells again
        action = f"the file has no places on a body: its taxels lie in the plane of the map {name!r}, as lengths do"
        self.findings.append(Finding("map-only", self._path.name, action, len(kept)))
        taxels = TaxelSet(
            name=self._path.stem,
            link=None,
            numbers=distinct_numbers(ids[kept], self._path.name, self.findings),
            ids=ids[kept],
            positions=np.column_stack([points, np.zeros(len(points))]),
            normals=np.tile([0.0, 0.0, 1.0], (len(points), 1)),
            faces=_upward(points, faces) if len(faces) else None,
        )
        return taxels, ids

    def _identified(self, ids: IntArray, place: str) -> IntArray:
        """(k,) rows of the taxels that have an id; where they go is remembered for faces and maps."""
        kept = np.flatnonzero(ids != _NO_ID)
        add_finding(self.findings, "taxel-without-id", self._path.name, "left out: its id is -1", len(ids) - len(kept))
        if not len(kept):
            raise self._refuse("no taxel has an id", place, len(ids))
        self._row_of = np.full(len(ids), -1)
        self._row_of[kept] = np.arange(len(kept))
        return kept

    def _kept_faces(self, part: Mapping[str, Any], count: int, place: str) -> IntArray:
        """(f, 3) faces over the taxels that have an id, of ``count`` in all."""
        faces = self._faces(part, place)
        unknown = ((faces < 0) | (faces >= count)).any(axis=1)
        if unknown.any():
            row = int(unknown.argmax())
            raise self._refuse("a face names a taxel that does not exist", f"faces, row {row}", faces[row].tolist())
        faces = self._row_of[faces]
        return faces[(faces >= 0).all(axis=1)]

    def _places(self, entries: Sequence[Mapping[str, Any]], count: int, place: str) -> FloatArray:
        """(n, count) in metres."""
        stated = self._vectors(entries, "x", count, place)
        if self._unit is not None:
            return self._unit * stated
        return length_unit(stated, f"{self._path.name}, {place}", self.findings) * stated

    def map(self, entry: Mapping[str, Any], key: int, skin_ids: IntArray) -> UnigeMap:
        """One of the maps."""
        place = f"tactile_maps {key}"
        entries = self._taxels(entry, place)
        points = self._places(entries, 2, place)
        faces = self._faces(entry, place)
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
            taxels = taxels[known]
            points = points[known]
        if not len(taxels):
            raise self._refuse("the map shows none of the skin's taxels", place, None)
        name = entry.get("name")
        description = entry.get("description") or ""
        text = " ".join(map(str, description)) if isinstance(description, list) else str(description)
        return UnigeMap(str(name or place), taxels, points, faces.reshape(-1, 3), text)

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

    def _frame(self, skin: Mapping[str, Any]) -> tuple[str | None, Pose]:
        """The parent frame's name, and the skin's pose in it."""
        frames = skin.get("parent_frames", skin.get("parent_frame", []))
        frames = [
            _object(f, "skin, parent_frames", self._path) for f in (frames if isinstance(frames, list) else [frames])
        ]
        more = "only the first is used, for all taxels"
        add_finding(self.findings, "several-frames", self._path.name, more, max(len(frames) - 1, 0))
        if not frames:
            return None, Pose.identity()
        link = str(frames[0].get("name") or "").strip() or None
        return link, self._pose(frames[0].get("tf_matrix"))

    def _pose(self, stated: object) -> Pose:
        """The rigid transform that ``tf_matrix`` is; none, and a finding, where it is another kind of matrix."""
        matrix = np.eye(4) if stated is None else _matrix(stated)
        if matrix is not None and np.array_equal(matrix, np.eye(4)):
            return Pose.identity()
        where = f"{self._path.name}, tf_matrix"
        rotation = None if matrix is None else _nearest_rotation(matrix)
        if matrix is None or rotation is None:
            action = "not applied to the taxels: it is no rotation and translation"
            self.findings.append(Finding("frame-transform", where, action))
            return Pose.identity()
        shift = matrix[:3, 3] * (1e-3 if np.abs(matrix[:3, 3]).max() > MAX_COORDINATE else 1.0)
        turn = np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))
        action = f"applied to the taxels: turned by {turn:.1f} deg, shifted by {1e3 * np.linalg.norm(shift):.4g} mm"
        self.findings.append(Finding("frame-transform", where, action))
        return Pose(rotation, shift)

    def _refuse(self, problem: str, place: str, value: object) -> SkinError:
        return SkinError(problem, file=self._path, place=place, value=value)


def _stated_unit(document: Mapping[str, Any]) -> float | None:
    """Metres in the unit that our own files state; None for those of others, which state none."""
    info = document.get("info")
    unit = info.get("unit") if isinstance(info, dict) else None
    return {"m": 1.0, "mm": 1e-3}.get(unit) if isinstance(unit, str) else None


def _matrix(stated: object) -> FloatArray | None:
    """(4, 4) with the translation in its last column, from 16 numbers or 4 x 4, by columns or rows; None otherwise."""
    if not isinstance(stated, list):
        return None
    numbers = [x for row in stated for x in (row if isinstance(row, list) else [row])]
    if len(numbers) != 16 or not all(_is_finite(x) for x in numbers):
        return None
    matrix = np.array(numbers, dtype=np.float64).reshape(4, 4)
    last = [0.0, 0.0, 0.0, 1.0]
    if matrix[3].tolist() == last:
        # Without a translation, only the form tells rows from columns: 16 numbers in a line go by columns.
        lined = len(stated) == len(numbers)
        return matrix.T if lined and matrix[:, 3].tolist() == last else matrix
    return matrix.T if matrix[:, 3].tolist() == last else None


def _nearest_rotation(matrix: FloatArray) -> FloatArray | None:
    """(3, 3) the rotation that the matrix states with rounded numbers; None where it is none."""
    left, _, right = np.linalg.svd(matrix[:3, :3])
    rotation = np.asarray(left @ right)
    off = float(np.abs(rotation - matrix[:3, :3]).max())
    return rotation if off <= _ROUNDED and np.linalg.det(rotation) > 0 else None


def _names(entries: Sequence[Mapping[str, Any]]) -> tuple[str, ...] | None:
    """What the taxels are called; None unless each has a name."""
    names = tuple(name for entry in entries if isinstance(name := entry.get("name"), str))
    return names if len(names) == len(entries) and any(names) else None


def _upward(points: FloatArray, faces: IntArray) -> IntArray:
    """``faces`` (f, 3) of a map, counter-clockwise from above."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    below = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return np.where(below[:, None], faces[:, ::-1], faces)


def _parse(path: Path) -> object:
    try:
        document: object = parse_json(read_bounded_text(path, error=SkinError), constants=True)
    except ValueError as error:
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
