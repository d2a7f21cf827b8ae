"""Taxels in records with named fields: which field holds the position, the id, the normal and the link."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.skin.model.taxel_axes import NUMBERS_OF_AXES, stated_frames
from tactile_maps.skin.model.taxel_set import (
    MAX_TAXELS,
    METRES,
    TaxelSet,
    distinct_numbers,
    length_unit,
    stated_areas,
    unit_normals,
)

EVERY = "*"
"""Part of a path that stands for each entry of an object or list; as a field, the key of that entry."""
_LARGEST_NUMBER = 2**31


@dataclass(frozen=True)
class FieldMapping:
    """Fields of a file that hold the properties of its taxels.

    A field is a name, or names joined by dots for nested objects, or the index in a record that is a list. It is
    searched in the record and then in the objects that contain the record.

    Attributes:
        position: Three fields, or one field of three numbers.
        records: Path to the list of records, joined by dots; lists on the way and nested lists are flattened, and ``*``
            stands for each entry of an object. Instead of a list, an object may hold one list for each field. Empty
            for a file that is the list itself.
        unit: Unit of positions, areas (its square) and radii: m, cm, mm or um. Without a unit, metres, or millimetres
            with a finding if metres are implausible.
        normal: Outward normals, like ``position``.
        id: Hardware id.
        module: Module of the taxel.
        channel: Channel in its module.
        area: Area of its pad.
        radius: Radius of a round pad, instead of the area.
        link: Name of the link; ``*`` is the key that ``*`` in ``records`` stands for.
        name: Name of the taxel or its sensor.
        axes: Number of axes of all taxels, 1 or 3, or the field that holds it; None for one axis.
        t1: First tangents of the taxels, like ``position``, or three numbers for all taxels.
        t2: Second tangents, like ``t1``; they are only checked.
    """

    position: tuple[str, ...]
    records: str = ""
    unit: str | None = None
    normal: tuple[str, ...] = ()
    id: str | None = None
    module: str | None = None
    channel: str | None = None
    area: str | None = None
    radius: str | None = None
    link: str | None = None
    name: str | None = None
    axes: str | int | None = None
    t1: tuple[str | float, ...] = ()
    t2: tuple[str | float, ...] = ()


@dataclass(frozen=True)
class Node:
    """Value in a file, with the objects that contain it.

    Attributes:
        value: The value.
        enclosing: Objects that contain it, the innermost first.
        key: Key that the last ``*`` stands for.
        place: Path to it, for errors.
    """

    value: object
    enclosing: tuple[Mapping[str, object], ...] = ()
    key: str = ""
    place: str = ""

    def child(self, key: str | int, value: object, *, named: bool = False) -> Node:
        """Return the node of an entry of this value."""
        enclosing = (self.value, *self.enclosing) if isinstance(self.value, dict) else self.enclosing
        return Node(value, enclosing, str(key) if named else self.key, f"{self.place}.{key}".lstrip("."))

    def children(self, *, named: bool = False) -> Iterator[Node]:
        """Yield the nodes of the entries of an object or list; nothing for other values."""
        if isinstance(self.value, dict):
            for key, value in self.value.items():
                yield self.child(key, value, named=named)
        elif isinstance(self.value, list):
            for number, value in enumerate(self.value):
                yield self.child(number, value, named=named)


def taxel_sets_of(document: object, mapping: FieldMapping, *, name: str, where: str) -> tuple[TaxelSet, ...]:
    """Return the taxels in the records of ``document``, one set for each link, in the order of their first records.

    Args:
        document: Values of the file.
        mapping: Fields of the records.
        name: Name of the set if there is only one link.
        where: Name of the file, for findings.

    Raises:
        SkinError: A field is missing or of another kind; names its place.
    """
    by_link = dict[str, list[Node]]()
    for count, record in enumerate(_records(document, mapping)):
        if count >= MAX_TAXELS:
            raise SkinError(f"the file has more than {MAX_TAXELS} taxels")
        link = "" if mapping.link is None else _text(record, mapping.link)
        by_link.setdefault(link, []).append(record)
    if not by_link:
        raise SkinError("the file has no records", place=mapping.records or None)
    return tuple(
        _taxel_set(records, mapping, link or None, link if link and len(by_link) > 1 else name, where)
        for link, records in by_link.items()
    )


def _records(document: object, mapping: FieldMapping) -> Iterator[Node]:
    nodes = [Node(document)]
    for part in mapping.records.split(".") if mapping.records else ():
        nodes = [found for node in nodes for found in _step(node, part)]
    for node in nodes:
        yield from _flattened(node, mapping)


def _step(node: Node, part: str) -> Iterator[Node]:
    """Yield the nodes that one part of a path leads to."""
    if part == EVERY:
        yield from node.children(named=True)
    elif isinstance(node.value, list):
        for item in node.children():
            yield from _step(item, part)
    elif isinstance(node.value, dict) and part in node.value:
        yield node.child(part, node.value[part])
    else:
        raise _missing(node, part)


def _flattened(node: Node, mapping: FieldMapping) -> Iterator[Node]:
    """Yield the records of a node: the entries of nested lists, or one for each entry of the lists of an object."""
    if isinstance(node.value, list) and not _is_vector(node.value):
        for item in node.children():
            yield from _flattened(item, mapping)
    elif isinstance(node.value, dict) and (columns := _columns(node, mapping)):
        length = len(columns[mapping.position[0]])
        for field, values in columns.items():
            if len(values) != length:
                found = f"{len(values)} and {length}"
                raise SkinError("the lists differ in length", place=f"{node.place}.{field}".lstrip("."), value=found)
        for row in range(length):
            yield node.child(row, {field: values[row] for field, values in columns.items()})
    else:
        yield node


def _columns(node: Node, mapping: FieldMapping) -> dict[str, list[object]]:
    """Return the lists of an object by the fields of the mapping; empty if its fields are those of one record."""
    single = (mapping.id, mapping.module, mapping.channel, mapping.area, mapping.radius, mapping.link, mapping.name)
    vectors = {field: fields for fields in (mapping.position, mapping.normal) for field in fields}
    found = dict[str, list[object]]()
    for field in (*vectors, *filter(None, single)):
        value = _follow(node.value, field)
        of_three = len(vectors.get(field, ())) == 1
        if isinstance(value, list) and not (of_three and _is_vector(value)):
            found[field] = value
    return found if mapping.position[0] in found else {}


def _is_vector(values: Sequence[object]) -> bool:
    """Whether a list holds numbers and texts, not records."""
    return bool(values) and not any(isinstance(value, dict | list) for value in values)


_MISSING = object()


def _follow(value: object, field: str) -> object:
    """Return the value of a field, or ``_MISSING``; a key may contain dots."""
    if isinstance(value, dict):
        if field in value:
            return value[field]
        first, dot, rest = field.partition(".")
        return _follow(value[first], rest) if dot and first in value else _MISSING
    if isinstance(value, list) and field.isdecimal() and int(field[:9]) < len(value):
        return value[int(field[:9])]
    return _MISSING


def _value(record: Node, field: str) -> object:
    """Return the value of a field of the record, or else of the nearest object that contains the record."""
    for value in (record.value, *record.enclosing):
        if (found := _follow(value, field)) is not _MISSING:
            return found
    raise _missing(record, field)


def _missing(node: Node, field: str) -> SkinError:
    value = node.value
    fields = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    here = ", ".join(str(one)[:40] for one in list(fields)[:12])
    remedy = f"It has: {here}" if here else "Check the path to the records"
    return SkinError("a field is missing", place=node.place or None, value=field, remedy=remedy)


def _text(record: Node, field: str) -> str:
    value = record.key if field == EVERY else _value(record, field)
    if not isinstance(value, str | int) or isinstance(value, bool):
        raise SkinError("must be a text", place=f"{record.place}, {field}", value=type(value).__name__)
    return str(value).strip()


def _number(value: object, place: str) -> float:
    """Return a number, also one that is written as text, as in tables."""
    if isinstance(value, str | int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except (ValueError, OverflowError):
            pass
    raise SkinError("must be a number", place=place, value=str(value)[:40])


def _numbers(records: Sequence[Node], field: str) -> FloatArray:
    """Return (n,) the numbers in a field."""
    return np.array([_number(_value(record, field), f"{record.place}, {field}") for record in records])


def _vectors(records: Sequence[Node], fields: Sequence[str | float]) -> FloatArray:
    """Return (n, 3) the numbers in three fields, or in one field of three numbers; numbers are the same for all."""
    constant = [float(field) for field in fields if not isinstance(field, str)]
    if constant:
        return np.tile(constant, (len(records), 1))
    names = [str(field) for field in fields]
    if len(names) == 3:
        return np.column_stack([_numbers(records, name) for name in names])
    rows = []
    for record in records:
        place = f"{record.place}, {names[0]}"
        value = _value(record, names[0])
        if not isinstance(value, list) or len(value) != 3:
            raise SkinError("must be three numbers", place=place, value=str(value)[:40])
        rows.append([_number(one, place) for one in value])
    return np.array(rows)


def _whole(records: Sequence[Node], field: str | None) -> np.ndarray | None:
    if field is None:
        return None
    values = _numbers(records, field)
    valid = (values >= 0) & (values < _LARGEST_NUMBER) & (values % 1 == 0)
    if not valid.all():
        row = int(valid.argmin())
        place = f"{records[row].place}, {field}"
        raise SkinError("must be a whole number, not negative", place=place, value=values[row])
    return values.astype(np.int64)


def _axes(records: Sequence[Node], stated: str | int | None) -> IntArray | None:
    """Return (n,) numbers of axes; None if they are not stated.

    Raises:
        SkinError: A number in the field is neither 1 nor 3.
    """
    if stated is None:
        return None
    if isinstance(stated, int):
        return np.full(len(records), stated)
    values = _numbers(records, stated)
    valid = np.isin(values, NUMBERS_OF_AXES)
    if not valid.all():
        row = int(valid.argmin())
        raise SkinError("must be 1 or 3", place=f"{records[row].place}, {stated}", value=values[row])
    return values.astype(np.int64)


def _taxel_set(records: Sequence[Node], mapping: FieldMapping, link: str | None, name: str, where: str) -> TaxelSet:
    findings = list[Finding]()
    positions = _vectors(records, mapping.position)
    unit = length_unit(positions, where, findings) if mapping.unit is None else METRES[mapping.unit]
    areas = None
    if mapping.area is not None:
        areas = unit**2 * _numbers(records, mapping.area)
    elif mapping.radius is not None:
        areas = np.pi * (unit * _numbers(records, mapping.radius)) ** 2
    ids = _whole(records, mapping.id)
    normals = unit_normals(_vectors(records, mapping.normal), where, findings) if mapping.normal else None
    axes = _axes(records, mapping.axes)
    t1, t2 = (_vectors(records, fields) if fields else None for fields in (mapping.t1, mapping.t2))

    def place(row: int) -> str:
        return records[row].place + ("" if ids is None else f", id {ids[row]}")

    tangents = stated_frames(axes, t1, t2, normals, where=where, findings=findings, place=place)
    return TaxelSet(
        name,
        link,
        np.arange(len(records)) if ids is None else distinct_numbers(ids, where, findings),
        unit * positions,
        normals=normals,
        axes=axes,
        tangents=tangents,
        areas=None if areas is None else stated_areas(areas, where, findings),
        ids=ids,
        modules=_whole(records, mapping.module),
        channels=_whole(records, mapping.channel),
        names=None if mapping.name is None else tuple(_text(record, mapping.name) for record in records),
        findings=tuple(findings),
    )
