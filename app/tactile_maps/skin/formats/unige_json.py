"""Skins and maps in the JSON format (file version 2) of the robot skin library of the University of Genoa.

``skin`` contains ``taxels`` (id, position x [m], normal n, type, cut; optionally module, channel, name, axes, tangent
t1, and ``aliases``: a list of further ids at this place; ``stream`` of a skin: number of values of its stream) and
``faces`` over them. Each of ``tactile_maps``, a list or a single map, contains its own taxels (id, position x on the
map [m], type, cut) and faces. Ids are repeated in real files, so that taxels are identified by index: a taxel of a map
is the taxel of the skin with the same index if all their ids agree, and otherwise the next one with its id.

Real files also state positions in millimetres, and the pose of the skin in its parent frame (``tf_matrix``, 16 numbers
by columns). Some contain only a map. The positions of their taxels on the body are unknown, but are not needed for the
map: such a file is read as a flat skin in the plane of the map, with a finding.
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

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text, write_atomically
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.formats.vendors.documents import parse_json_file
from tactile_maps.skin.formats.vendors.mapping_file import unknown_layout
from tactile_maps.skin.model.taxel_axes import NUMBERS_OF_AXES, stated_frames
from tactile_maps.skin.model.taxel_set import (
    MAX_COORDINATE,
    MAX_TAXELS,
    TaxelSet,
    distinct_numbers,
    further_ids,
    length_unit,
    unit_normals,
)

FILE_VERSION = 2
_LARGEST_NUMBER = 2**31
_PRESSURE = "pressure"
_NO_ID = -1
"""Id in real files of a taxel that is not connected to a board."""
_ROUNDED = 1e-3
"""Largest error of the entries of a rotation, which are written with four digits."""


@dataclass(frozen=True, eq=False)
class UnigeMap(ArrayFields):
    """Flat map in such a file.

    Attributes:
        name: Displayed name.
        taxels: (k,) indices of taxels of the skin; a taxel may be on both sides of a cut.
        points: (k, 2) positions on the map [m].
        faces: (f, 3) triangles over the taxels of the map.
        description: Displayed description.
    """

    name: str
    taxels: IntArray
    points: FloatArray
    faces: IntArray
    description: str = ""


@dataclass(frozen=True, eq=False)
class UnigeFile:
    """Skin and its maps.

    Attributes:
        taxels: Taxels with faces; the link is the name of the parent frame, the findings are those of the whole file.
        maps: Maps in the order of the file.
    """

    taxels: TaxelSet
    maps: tuple[UnigeMap, ...] = ()

    def with_points(self) -> TaxelSet:
        """Return the taxels with their positions on the first map; at a cut, the first position counts."""
        first = self.maps[0]
        points = np.full((len(self.taxels), 2), np.nan)
        points[first.taxels[::-1]] = first.points[::-1]
        taxels = replace(self.taxels, points=points)
        notes = list[Finding]()
        missing = int((~taxels.mapped).sum())
        add_finding(notes, "not-on-map", f"map {first.name}", "the taxel has no place on the map", missing)
        return taxels.with_findings(*notes)


def read_unige(path: str | Path) -> UnigeFile:
    """Return the skin and the maps in a file; without a skin, it is the first map as a flat skin.

    Raises:
        SkinError: The file cannot be read, or a part is invalid; names the place.
    """
    path = Path(path)
    text = read_bounded_text(path, error=SkinError)
    with errors_in_file(path):
        document = parse_json_file(text)
        if not isinstance(document, dict) or not ("skin" in document or document.get("tactile_maps")):
            raise unknown_layout(path, document)
        decoder = _Decoder(path, _stated_unit(document))
        stated = document.get("tactile_maps", [])
        entries = [stated] if isinstance(stated, dict) and stated else _list(stated, "tactile_maps")
        maps = [_object(entry, f"tactile_maps {k}") for k, entry in enumerate(entries)]
        if "skin" in document:
            taxels, ids = decoder.skin(_object(document.get("skin"), "skin"), document)
        else:
            taxels, ids = decoder.flat_skin(maps[0])
        decoded = tuple(decoder.map(entry, k, ids) for k, entry in enumerate(maps))
        return UnigeFile(taxels.with_findings(*decoder.findings), decoded)


def write_unige(file: UnigeFile, path: str | Path) -> None:
    """Write ``file`` with the ids of the taxels, or their numbers without ids, and their modules and channels if known.

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
            **({} if taxels.stream is None else {"stream": taxels.stream}),
            "parent_frames": [frame],
            "taxels": _skin_entries(taxels),
            "faces": [] if taxels.faces is None else taxels.faces.tolist(),
        },
        "tactile_maps": [
            {
                "key": k,
                "name": map_.name,
                "type": "2D",
                "description": map_.description,
                "n_taxels": len(map_.taxels),
                "n_faces": len(map_.faces),
                "taxels": _taxel_entries([ids[i] for i in map_.taxels.tolist()], map_.points, cut[k]),
                "faces": map_.faces.tolist(),
            }
            for k, map_ in enumerate(file.maps)
        ],
    }
    text = json.dumps(document, ensure_ascii=False, indent=1)
    write_atomically(Path(path), text.encode("utf-8", errors="replace"), error=SkinError)


def _skin_entries(taxels: TaxelSet) -> list[dict[str, Any]]:
    ids = taxels.stated_ids.tolist()
    uncut = np.zeros(len(taxels))
    entries = _taxel_entries(ids, taxels.positions, uncut, normals=taxels.normals)
    columns = {
        "module": None if taxels.modules is None else taxels.modules.tolist(),
        "channel": None if taxels.channels is None else taxels.channels.tolist(),
        "name": taxels.names,
        "axes": None if taxels.axes is None else taxels.axes.tolist(),
    }
    for key, column in columns.items():
        for entry, value in zip(entries, column or (), strict=column is not None):
            entry[key] = value
    if taxels.tangents is not None:
        for entry, tangent in zip(entries, taxels.tangents.tolist(), strict=True):
            entry |= {} if np.isnan(tangent[0]) else {"t1": tangent}
    if taxels.aliases is not None:
        for entry, further in zip(entries, further_ids(taxels.aliases, len(taxels)), strict=True):
            if further:
                entry["aliases"] = further
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


class _Decoder:
    """Decoder of the parts of one file, with the findings of all."""

    def __init__(self, path: Path, unit: float | None) -> None:
        self._path = path
        self._unit = unit
        self.findings: list[Finding] = []
        self._row_of: IntArray = np.zeros(0, dtype=np.int64)

    def skin(self, skin: Mapping[str, Any], document: Mapping[str, Any]) -> tuple[TaxelSet, IntArray]:
        """Return the taxels that have an id, and the ids (n,) of all taxels in the file, -1 for none."""
        where = self._path.name
        entries = self._taxels(skin, "skin")
        ids = self._ids(entries, "skin")
        kept = self._identified(ids, "skin")
        normals = None
        if all("n" in entry for entry in entries):
            normals = unit_normals(self._vectors(entries, "n", 3, "skin")[kept], where, self.findings)
        faces = self._kept_faces(skin, len(ids), "skin")
        odd = sum(entry.get("type", _PRESSURE) != _PRESSURE for entry in entries)
        add_finding(self.findings, "not-pressure", where, "kept, although the type of the taxel is not pressure", odd)
        info = document.get("info")
        name = info.get("name") if isinstance(info, dict) else None
        link, pose = self._frame(skin)
        positions = self._places(entries, 3, "skin")[kept]
        axes = self._axes(entries)[kept] if any("axes" in entry for entry in entries) else None
        t1, t2 = (self._vectors(entries, field, 3, "skin", optional=True)[kept] for field in ("t1", "t2"))
        tangents = stated_frames(
            axes,
            t1,
            t2,
            normals,
            where=where,
            findings=self.findings,
            place=lambda row: f"skin, taxel {kept[row]}, id {ids[kept[row]]}",
        )
        taxels = TaxelSet(
            name=name if isinstance(name, str) and name.strip() else self._path.stem,
            link=link,
            numbers=distinct_numbers(ids[kept], where, self.findings),
            ids=ids[kept],
            modules=self._optional(entries, kept, "module"),
            channels=self._optional(entries, kept, "channel"),
            names=_names([entries[row] for row in kept.tolist()]),
            aliases=_aliases(entries, kept),
            stream=_stream(skin),
            positions=pose.points(positions),
            normals=None if normals is None else pose.directions(normals),
            axes=axes,
            tangents=None if tangents is None else pose.directions(tangents),
            faces=faces if len(faces) else None,
        )
        return taxels, ids

    def flat_skin(self, map_: Mapping[str, Any]) -> tuple[TaxelSet, IntArray]:
        """Return the taxels of a map without a skin, in its plane, and the ids (n,) of all of its taxels."""
        place = "tactile_maps 0"
        name = str(map_.get("name") or self._path.stem)
        entries = self._taxels(map_, place)
        ids = self._ids(entries, place)
        kept = self._identified(ids, place)
        faces = self._kept_faces(map_, len(ids), place)
        before = len(self.findings)
        points = self._places(entries, 2, place)[kept]
        del self.findings[before:]  # the map is decoded later, with the same findings
        action = f"the file has no positions on a body: its taxels are placed in the plane of the map {name!r}"
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
        """Return (k,) rows of the taxels that have an id; their new rows are stored for faces and maps."""
        kept = np.flatnonzero(ids != _NO_ID)
        add_finding(self.findings, "taxel-without-id", self._path.name, "left out: its id is -1", len(ids) - len(kept))
        if not len(kept):
            raise SkinError("no taxel has an id", place=place, value=len(ids))
        self._row_of = np.full(len(ids), -1)
        self._row_of[kept] = np.arange(len(kept))
        return kept

    def _kept_faces(self, part: Mapping[str, Any], count: int, place: str) -> IntArray:
        """Return faces (f, 3) over the taxels that have an id; the part has ``count`` taxels."""
        faces = self._faces(part, place)
        unknown = (faces >= count).any(axis=1)
        if unknown.any():
            row = int(unknown.argmax())
            problem = "a face names a taxel that does not exist"
            raise SkinError(problem, place=f"faces, row {row}", value=faces[row].tolist())
        faces = self._row_of[faces]
        return faces[(faces >= 0).all(axis=1)]

    def _places(self, entries: Sequence[Mapping[str, Any]], count: int, place: str) -> FloatArray:
        """Return positions (n, count) [m]."""
        stated = self._vectors(entries, "x", count, place)
        if self._unit is not None:
            return self._unit * stated
        return length_unit(stated, f"{self._path.name}, {place}", self.findings) * stated

    def map(self, entry: Mapping[str, Any], key: int, skin_ids: IntArray) -> UnigeMap:
        """Return the map number ``key``."""
        place = f"tactile_maps {key}"
        entries = self._taxels(entry, place)
        points = self._places(entries, 2, place)
        faces = self._faces(entry, place)
        if not (np.abs(points) <= MAX_COORDINATE).all():
            problem = f"a map point is not within {MAX_COORDINATE:g} m"
            raise SkinError(problem, place=place, value=float(np.abs(points).max()))
        if (faces >= len(points)).any():
            problem = "a face names a taxel that the map does not have"
            raise SkinError(problem, place=place, value=int(faces.max()))
        taxels = self._indices(self._ids(entries, place), skin_ids, place)
        taxels = np.where(taxels >= 0, self._row_of[taxels], -1)
        known = taxels >= 0
        action = "left out: the skin has no taxel with its id"
        add_finding(self.findings, "unknown-taxel", place, action, int((~known).sum()))
        faces = (np.cumsum(known) - 1)[faces[known[faces].all(axis=1)]]
        taxels = taxels[known]
        points = points[known]
        if not len(taxels):
            raise SkinError("the map shows none of the skin's taxels", place=place)
        name = entry.get("name")
        description = entry.get("description") or ""
        text = " ".join(map(str, description)) if isinstance(description, list) else str(description)
        return UnigeMap(str(name or place), taxels, points, faces.reshape(-1, 3), text)

    def _indices(self, ids: IntArray, skin_ids: IntArray, place: str) -> IntArray:
        """Return (k,) index in the skin of each taxel of the map; -1 for none."""
        if len(ids) <= len(skin_ids) and (ids == skin_ids[: len(ids)]).all():
            return np.arange(len(ids))
        waiting: dict[int, deque[int]] = defaultdict(deque)
        for index, number in enumerate(skin_ids.tolist()):
            waiting[number].append(index)
        found = []
        for number in ids.tolist():
            queue = waiting.get(number)
            # The last taxel with an id may be used again: it is on both sides of a cut.
            found.append(-1 if not queue else queue.popleft() if len(queue) > 1 else queue[0])
        indices = np.array(found, dtype=np.int64)
        again = len(indices) - len(np.unique(indices))
        add_finding(self.findings, "shown-twice", place, "the map shows a taxel at several places", again)
        return indices

    def _taxels(self, part: Mapping[str, Any], place: str) -> list[Mapping[str, Any]]:
        """Return the entries of taxels; older files contain one list per parent frame."""
        entries = list[Any]()
        for entry in _list(part.get("taxels"), f"{place}, taxels"):
            entries += entry if isinstance(entry, list) else [entry]
        if not 1 <= len(entries) <= MAX_TAXELS:
            raise SkinError(f"there must be 1 to {MAX_TAXELS} taxels", place=place, value=len(entries))
        self._compare(part, "n_taxels", len(entries), place)
        return [_object(entry, f"{place}, taxel {k}") for k, entry in enumerate(entries)]

    def _faces(self, part: Mapping[str, Any], place: str) -> IntArray:
        """Return faces (f, 3) of indices that are not negative."""
        faces = _list(part.get("faces", []), f"{place}, faces")
        for k, face in enumerate(faces):
            if not (isinstance(face, list) and len(face) == 3 and all(map(_is_whole, face))):
                raise SkinError("a face must be three indices", place=f"{place}, face {k}", value=face)
        self._compare(part, "n_faces", len(faces), place)
        return np.array(faces, dtype=np.int64).reshape(-1, 3)

    def _compare(self, part: Mapping[str, Any], field: str, count: int, place: str) -> None:
        stated = part.get(field, count)
        if stated != count:
            self.findings.append(Finding("count-mismatch", place, f"{field} is {stated}, there are {count}"))

    def _ids(self, entries: Sequence[Mapping[str, Any]], place: str) -> IntArray:
        ids = [entry.get("id") for entry in entries]
        for k, number in enumerate(ids):
            if not (_is_whole(number) or (type(number) is int and number == _NO_ID)):
                problem = "id must be a whole number, -1 for none"
                raise SkinError(problem, place=f"{place}, taxel {k}", value=number)
        return np.array(ids, dtype=np.int64)

    def _optional(self, entries: Sequence[Mapping[str, Any]], kept: IntArray, key: str) -> IntArray | None:
        """Return the optional whole numbers of the taxels ``kept``; None if one of them does not have a valid one."""
        values = [entries[k].get(key) for k in kept.tolist()]
        if not all(_is_whole(value) for value in values):
            some = sum(value is not None for value in values)
            add_finding(self.findings, f"{key}-unknown", "skin", "not used: not a whole number of every taxel", some)
            return None
        return np.array(values, dtype=np.int64)

    def _axes(self, entries: Sequence[Mapping[str, Any]]) -> IntArray:
        """Return (n,) numbers of axes; 1 for taxels that do not state it."""
        axes = [entry.get("axes", 1) for entry in entries]
        for k, number in enumerate(axes):
            if not _is_whole(number) or number not in NUMBERS_OF_AXES:
                raise SkinError("axes must be 1 or 3", place=f"skin, taxel {k}", value=number)
        return np.array(axes, dtype=np.int64)

    def _vectors(
        self, entries: Sequence[Mapping[str, Any]], field: str, count: int, place: str, *, optional: bool = False
    ) -> FloatArray:
        """Return (n, count) numbers in a field; NaN for entries without an optional one."""
        for k, entry in enumerate(entries):
            if optional and field not in entry:
                continue
            value = entry.get(field)
            if not (isinstance(value, list) and len(value) == count and all(_is_finite(x) for x in value)):
                problem = f"{field} must be {count} finite numbers"
                raise SkinError(problem, place=f"{place}, taxel {k}", value=value)
        return np.array([entry.get(field, [np.nan] * count) for entry in entries], dtype=np.float64)

    def _frame(self, skin: Mapping[str, Any]) -> tuple[str | None, Pose]:
        """Return the name of the parent frame, and the pose of the skin in it."""
        frames = skin.get("parent_frames", skin.get("parent_frame", []))
        frames = [_object(f, "skin, parent_frames") for f in (frames if isinstance(frames, list) else [frames])]
        more = "only the first is used, for all taxels"
        add_finding(self.findings, "several-frames", self._path.name, more, max(len(frames) - 1, 0))
        if not frames:
            return None, Pose.identity()
        link = str(frames[0].get("name") or "").strip() or None
        return link, self._pose(frames[0].get("tf_matrix"))

    def _pose(self, stated: object) -> Pose:
        """Return the rigid transform of ``tf_matrix``; the identity, and a finding, for other matrices."""
        matrix = np.eye(4) if stated is None else _matrix(stated)
        if matrix is not None and np.array_equal(matrix, np.eye(4)):
            return Pose.identity()
        where = f"{self._path.name}, tf_matrix"
        rotation = None if matrix is None else _nearest_rotation(matrix)
        if matrix is None or rotation is None:
            action = "not applied to the taxels: it is not a rotation and translation"
            self.findings.append(Finding("frame-transform", where, action))
            return Pose.identity()
        shift = matrix[:3, 3] * (1e-3 if np.abs(matrix[:3, 3]).max() > MAX_COORDINATE else 1.0)
        turn = np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))
        action = f"applied to the taxels: rotated by {turn:.1f} deg, moved by {1e3 * np.linalg.norm(shift):.4g} mm"
        self.findings.append(Finding("frame-transform", where, action))
        return Pose(rotation, shift)


def _stated_unit(document: Mapping[str, Any]) -> float | None:
    """Return the unit stated in files of this program [m]; None for other files, which do not state it."""
    info = document.get("info")
    unit = info.get("unit") if isinstance(info, dict) else None
    return {"m": 1.0, "mm": 1e-3}.get(unit) if isinstance(unit, str) else None


def _matrix(stated: object) -> FloatArray | None:
    """Return a matrix (4, 4) with the translation in its last column, from 16 numbers or 4 x 4, by columns or rows.

    None for other values.
    """
    if not isinstance(stated, list):
        return None
    numbers = [x for row in stated for x in (row if isinstance(row, list) else [row])]
    if len(numbers) != 16 or not all(_is_finite(x) for x in numbers):
        return None
    matrix = np.array(numbers, dtype=np.float64).reshape(4, 4)
    last = [0.0, 0.0, 0.0, 1.0]
    if matrix[3].tolist() == last:
        # Without a translation, only the form distinguishes rows from columns: a flat list is by columns.
        lined = len(stated) == len(numbers)
        return matrix.T if lined and matrix[:, 3].tolist() == last else matrix
    return matrix.T if matrix[:, 3].tolist() == last else None


def _nearest_rotation(matrix: FloatArray) -> FloatArray | None:
    """Return the rotation (3, 3) of a matrix with rounded numbers; None if it is not a rotation."""
    left, _, right = np.linalg.svd(matrix[:3, :3])
    rotation = np.asarray(left @ right)
    off = float(np.abs(rotation - matrix[:3, :3]).max())
    return rotation if off <= _ROUNDED and np.linalg.det(rotation) > 0 else None


def _names(entries: Sequence[Mapping[str, Any]]) -> tuple[str, ...] | None:
    """Return the names of the taxels; None unless each has one."""
    names = tuple(name for entry in entries if isinstance(name := entry.get("name"), str))
    return names if len(names) == len(entries) and any(names) else None


def _stream(skin: Mapping[str, Any]) -> int | None:
    """Return the number of values in the vendor's stream; None if it is not stated."""
    stated = skin.get("stream")
    if stated is not None and (type(stated) is not int or not 0 < stated < _LARGEST_NUMBER):
        raise SkinError("must be a positive whole number", place="skin, stream", value=str(stated))
    return stated


def _aliases(entries: Sequence[Mapping[str, Any]], kept: IntArray) -> IntArray | None:
    """Return (k, 2) further ids of the taxels ``kept`` and their rows; None if none has one.

    Raises:
        SkinError: They are not a list of ids.
    """
    found = list[tuple[int, int]]()
    for row, place in enumerate(kept.tolist()):
        further = entries[place].get("aliases", [])
        if not (isinstance(further, list) and all(map(_is_whole, further))):
            problem = "aliases must be a list of whole numbers"
            raise SkinError(problem, place=f"skin, taxel {place}", value=str(further)[:40])
        found += [(number, row) for number in further]
    return np.array(found, dtype=np.int64) if found else None


def _upward(points: FloatArray, faces: IntArray) -> IntArray:
    """Return the faces (f, 3) of a map, counter-clockwise from above."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    below = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) < (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    return np.where(below[:, None], faces[:, ::-1], faces)


def _object(value: object, place: str) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise SkinError("an object is missing or of another kind", place=place, value=type(value).__name__)
    return value


def _list(value: object, place: str) -> list[Any]:
    if not isinstance(value, list):
        raise SkinError("a list is missing or of another kind", place=place, value=type(value).__name__)
    return value


def _is_whole(value: object) -> bool:
    return type(value) is int and 0 <= value < _LARGEST_NUMBER


def _is_finite(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300
