"""Taxels as a table: comma, semicolon or tab between columns that say what they are, in any order.

Columns: ``x y z``, and where known ``nx ny nz`` (outward normal), ``u v`` (place on a map), ``area``, ``taxel`` (its
number), ``id`` (its hardware id; where there is no such column, ``taxel`` is), ``module``, ``channel``, ``name`` and
``link``; usual other names of them are understood (``pos_x``, ``normal_x``, ``taxel_id``, ``body``...). A unit follows
its name: ``x_mm``, ``x [mm]``, ``area (mm2)``. Lengths without a unit are metres, unless metres cannot be meant, which
is told. Without a line of names, three columns are positions and six are positions and normals. A line that starts
with # is a remark.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding, errors_in_file
from tactile_maps.core.files import read_bounded_text, write_lines
from tactile_maps.skin.model.taxel_set import (
    MAX_TAXELS,
    TaxelSet,
    distinct_numbers,
    is_number,
    length_unit,
    line_error,
    unit_normals,
)

_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_POINT = ("u", "v")
_LENGTHS = _POSITION + _POINT
_WHOLE = ("taxel", "id", "module", "channel")
_KNOWN = (*_POSITION, *_NORMAL, *_POINT, "area", *_WHOLE, "name", "link")
_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
_SQUARE_METRES = {f"{unit}{square}": metres**2 for unit, metres in _METRES.items() for square in ("2", "²", "^2")}
_UNIT = re.compile(r"^(?P<name>.+?)(?:[_/](?P<after>[a-zµ]+(?:\^?2|²)?)|[\[(]_?(?P<within>[^\])]*?)_?[\])])$")
_OTHER_NAMES = {
    **{f"{word}_{axis}": axis for axis in _POSITION for word in ("pos", "position", "p")},
    **{f"{axis}_{word}": axis for axis in _POSITION for word in ("pos", "position")},
    **{f"p{axis}": axis for axis in _POSITION},
    **{f"{word}_{axis}": f"n{axis}" for axis in _POSITION for word in ("n", "normal", "norm")},
    **{f"normal{axis}": f"n{axis}" for axis in _POSITION},
    **{f"map_{axis}": axis for axis in _POINT},
    **{f"{word}_id": word for word in ("module", "channel")},
    **dict.fromkeys(("taxel_id", "hardware_id", "hw_id", "sensor_id"), "id"),
    **dict.fromkeys(("number", "index", "taxel_number", "taxel_index"), "taxel"),
    **dict.fromkeys(("board", "board_id", "patch_module"), "module"),
    **dict.fromkeys(("body", "link_name", "frame", "frame_id", "parent_link"), "link"),
    **dict.fromkeys(("taxel_area", "sensor_area"), "area"),
    **dict.fromkeys(("taxel_name", "sensor_name", "sensor"), "name"),
}  # fmt: skip
_SEPARATORS = (";", "\t", ",")
_LARGEST_NUMBER = 2**31
MAX_COLUMNS = 1000
MAX_LINKS = 1000


@dataclass(frozen=True)
class _Table:
    """The rows of one file: where they are, what their columns are called, and the SI value of the units they state."""

    path: Path
    columns: Mapping[str, int]
    units: Mapping[str, float]
    headings: Sequence[str]
    rows: Sequence[tuple[int, Sequence[str]]]  # the line's number, and its cells
    findings: tuple[Finding, ...]


def read_table(path: str | Path) -> tuple[TaxelSet, ...]:
    """The taxels in the table at ``path``, one set for each link it names, in the order of their first rows.

    Raises:
        SkinError: It cannot be read, a column is missing, or a cell is not the number it should be; names the line.
    """
    path = Path(path)
    table = _open(path)
    link = table.columns.get("link")
    rows: dict[str, list[tuple[int, Sequence[str]]]] = {}
    for row in table.rows:
        rows.setdefault(row[1][link].strip() if link is not None else "", []).append(row)
    if len(rows) > MAX_LINKS:
        problem = f"the table names more than {MAX_LINKS} links"
        remedy = "Check which column names the links"
        raise SkinError(problem, file=path, place=f"column {table.headings[link or 0]}", value=len(rows), remedy=remedy)
    sets = [_taxel_set(table, chosen, name or None, len(rows) > 1) for name, chosen in rows.items()]
    return (sets[0].with_findings(*table.findings), *sets[1:])


def write_table(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` as one table, in metres; what only some of them know is an empty cell in the others' rows.

    Raises:
        SkinError: The file cannot be written.
    """
    known = [name for name in _KNOWN if any(_has(taxels, name) for taxels in sets)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name}_m" if name in _LENGTHS else f"{name}_m2" if name == "area" else name for name in known])
    for taxels in sets:
        columns = _columns(taxels)
        writer.writerows(zip(*(columns.get(name, [""] * len(taxels)) for name in known), strict=True))
    write_lines(Path(path), text.getvalue().splitlines(), error=SkinError)


def _has(taxels: TaxelSet, name: str) -> bool:
    return name in _columns(taxels)


def _columns(taxels: TaxelSet) -> dict[str, list[object]]:
    """The cells by column, of what the set knows."""
    blocks = ((_POSITION, taxels.positions), (_NORMAL, taxels.normals), (_POINT, taxels.points))
    columns: dict[str, list[object]] = {
        name: ["" if np.isnan(x) else x for x in values[:, k].tolist()]
        for names, values in blocks
        if values is not None
        for k, name in enumerate(names)
    }
    if taxels.areas is not None:
        columns["area"] = taxels.areas.tolist()
    columns["taxel"] = taxels.numbers.tolist()
    for name, values in (("id", taxels.ids), ("module", taxels.modules), ("channel", taxels.channels)):
        if values is not None:
            columns[name] = values.tolist()
    if taxels.names is not None:
        columns["name"] = [" ".join(name.split()) for name in taxels.names]
    if taxels.link is not None:
        columns["link"] = [" ".join(taxels.link.split())] * len(taxels)
    return columns


def _open(path: Path) -> _Table:
    lines = [
        (number, line)
        for number, line in enumerate(read_bounded_text(path, error=SkinError).splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise SkinError("the table has no rows", file=path)
    if len(lines) > MAX_TAXELS + 1:
        raise SkinError(f"the table has more than {MAX_TAXELS} rows", file=path, value=len(lines))
    separator = max(_SEPARATORS, key=lines[0][1].count)
    if (width := lines[0][1].count(separator) + 1) > MAX_COLUMNS:
        place = f"line {lines[0][0]}"
        remedy = "Keep the columns of positions, normals and ids"
        problem = f"the table has more than {MAX_COLUMNS} columns"
        raise SkinError(problem, file=path, place=place, value=width, remedy=remedy)
    try:
        cells = list(csv.reader((line for _, line in lines), delimiter=separator, strict=True))
    except csv.Error as error:
        raise SkinError("the table cannot be parsed", file=path, value=error) from error
    rows = [(number, row) for (number, _), row in zip(lines, cells, strict=True)] if len(cells) == len(lines) else []
    if not rows:
        raise SkinError("a quoted cell runs over several lines", file=path, remedy="Close the quotes")
    findings: list[Finding] = []
    columns, units, body = _header(rows, path, findings)
    for number, row in body:
        if len(row) != len(rows[0][1]):
            raise line_error(f"the row must have {len(rows[0][1])} cells", path, number, separator.join(row))
    if not body:
        raise SkinError("the table has no rows below its names", file=path)
    units |= _guessed_units(columns, units, body, path, findings)
    return _Table(path, columns, units, [cell.strip() for cell in rows[0][1]], body, tuple(findings))


def _header(
    rows: Sequence[tuple[int, Sequence[str]]], path: Path, findings: list[Finding]
) -> tuple[dict[str, int], dict[str, float], Sequence[tuple[int, Sequence[str]]]]:
    """The columns by name, the SI value of those units that are stated, and the rows below the names."""
    line, first = rows[0]
    if is_number(first[0]):
        names = {3: _POSITION, 6: _POSITION + _NORMAL}.get(len(first))
        if names is None:
            remedy = f"Put a line of names first: {', '.join(_KNOWN)}"
            raise SkinError(
                "the names of the columns are missing", file=path, value=f"{len(first)} columns", remedy=remedy
            )
        return {name: k for k, name in enumerate(names)}, {}, rows
    columns = dict[str, int]()
    units = dict[str, float]()
    for k, cell in enumerate(first):
        name, unit = _column_name(cell, path, line)
        if name not in _KNOWN:
            add_finding(findings, "unknown-column", path.name, f"ignored: {cell.strip()[:40]!r}", 1)
        elif name in columns:
            raise line_error(f"the column {name} is duplicated", path, line, ", ".join(first))
        else:
            columns[name] = k
            if unit is not None:
                units[name] = unit
    _require_whole_groups(columns, path, line)
    add_finding(findings, "millimetres", path.name, "converted to metres", list(units.values()).count(1e-3))
    return columns, units, rows[1:]


def _column_name(cell: str, path: Path, line: int) -> tuple[str, float | None]:
    """The name that a heading means, and the SI value of the unit that it states.

    Raises:
        SkinError: The unit is not one of the column's kind.
    """
    text = " ".join(cell.split()).lower().replace(" ", "_").replace("_[", "[").replace("_(", "(")
    if (plain := _OTHER_NAMES.get(text, text)) in _KNOWN or not (found := _UNIT.match(text)):
        return plain, None
    name = _OTHER_NAMES.get(found["name"], found["name"])
    word = found["after"] or found["within"]
    units = _METRES if name in _LENGTHS else _SQUARE_METRES if name == "area" else {}
    if word in units:
        return name, units[word]
    if name not in _KNOWN or found["after"]:
        return text, None
    if not units:
        return name, None  # a number or a direction in whatever they call its unit
    remedy = f"Choose one of: {', '.join(units)}"
    place = f"line {line}, column {cell.strip()}"
    raise SkinError(f"the unit of {name} is not known", file=path, place=place, value=word, remedy=remedy)


def _guessed_units(
    columns: Mapping[str, int],
    units: Mapping[str, float],
    body: Sequence[tuple[int, Sequence[str]]],
    path: Path,
    findings: list[Finding],
) -> dict[str, float]:
    """Of the lengths that state no unit: metres, unless these cannot be meant. Areas follow the positions."""
    guessed = dict[str, float]()
    for group in (_POSITION, _POINT):
        if group[0] not in columns or any(name in units for name in group):
            continue
        places = [columns[name] for name in group]
        numbers = _finite_floats(body, places)
        if numbers is None:
            cells = ([row[place] for place in places] for _, row in body)
            numbers = np.array([[float(cell) for cell in row] for row in cells if all(map(is_number, row))])
        if len(numbers):
            where = f"{path.name}, columns {', '.join(group)}"
            guessed |= dict.fromkeys(group, length_unit(numbers, where, findings))
    if "area" in columns and "area" not in units:
        unit = units.get("x", guessed.get("x", 1.0)) ** 2
        word = {1.0: "m2", 1e-6: "mm2"}.get(unit, f"{unit:g} m2")
        action = f"taken as {word}, as the positions are: its column states no unit"
        add_finding(findings, "guessed-unit", f"{path.name}, column area", action, len(body))
        guessed["area"] = unit
    return guessed


def _require_whole_groups(columns: Mapping[str, int], path: Path, line: int) -> None:
    for group in (_POSITION, _NORMAL, _POINT):
        missing = [name for name in group if name not in columns]
        if missing and (group is _POSITION or len(missing) < len(group)):
            remedy = f"Name the columns {', '.join(group)} in the first line, with a unit as in {group[0]}_mm"
            raise SkinError(
                "a column is missing", file=path, place=f"line {line}", value=", ".join(missing), remedy=remedy
            )


def _taxel_set(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], link: str | None, named: bool) -> TaxelSet:
    where = table.path.name
    findings = list[Finding]()
    normals, points, areas = (_floats(table, rows, group) for group in (_NORMAL, _POINT, ("area",)))
    numbers, ids, modules, channels = (_integers(table, rows, name) for name in _WHOLE)
    ids = numbers if ids is None else ids
    numbers = ids if numbers is None else numbers
    if normals is not None and np.isnan(normals).all():
        normals = None
    with errors_in_file(table.path):
        return TaxelSet(
            name=link if named and link else table.path.stem,
            link=link,
            numbers=np.arange(len(rows)) if numbers is None else distinct_numbers(numbers, where, findings),
            positions=np.asarray(_floats(table, rows, _POSITION)),
            normals=None if normals is None else unit_normals(normals, where, findings),
            points=None if points is None or np.isnan(points).all() else points,
            areas=_areas(areas, where, findings),
            modules=modules,
            ids=ids,
            channels=channels,
            names=_names(table, rows),
            findings=tuple(findings),
        )


def _names(table: _Table, rows: Sequence[tuple[int, Sequence[str]]]) -> tuple[str, ...] | None:
    """(n,) of the taxels; None where no row has one."""
    if "name" not in table.columns:
        return None
    names = tuple(cells[table.columns["name"]].strip() for _, cells in rows)
    return names if any(names) else None


def _areas(stated: FloatArray | None, where: str, findings: list[Finding]) -> FloatArray | None:
    """(n,) stated areas [m²]; None, and a finding, where some taxel has none above zero."""
    if stated is None or np.isnan(stated).all():
        return None
    lacking = int((~(stated[:, 0] > 0)).sum())
    add_finding(findings, "area-unknown", where, "the areas are not used: not above zero for every taxel", lacking)
    return None if lacking else stated[:, 0]


def _floats(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], group: Sequence[str]) -> FloatArray | None:
    """(n, k) the columns of ``group`` in SI units; NaN for an empty cell, but of a position."""
    if group[0] not in table.columns:
        return None
    columns = [table.columns[name] for name in group]
    units = [table.units.get(name, 1.0) for name in group]
    values = _finite_floats(rows, columns)
    if values is not None:
        return values * units
    values = np.empty((len(rows), len(group)))
    for row, (line, cells) in enumerate(rows):
        for k, column in enumerate(columns):
            text = cells[column].strip()
            if text or group is _POSITION:
                values[row, k] = _number(text, table, line, group[k])
            else:
                values[row, k] = np.nan
    return values * units


def _finite_floats(rows: Sequence[tuple[int, Sequence[str]]], columns: Sequence[int]) -> FloatArray | None:
    """Return (n, k) the numbers in some columns; None if a cell is not a finite number."""
    try:
        values = np.array([[float(cells[column]) for column in columns] for _, cells in rows])
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _integers(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], name: str) -> IntArray | None:
    if name not in table.columns:
        return None
    column = table.columns[name]
    if all(not cells[column].strip() for _, cells in rows):
        return None
    values = np.empty(len(rows), dtype=np.int64)
    for row, (line, cells) in enumerate(rows):
        value = _number(cells[column], table, line, name)
        if not (value.is_integer() and 0 <= value < _LARGEST_NUMBER):
            raise _cell_error(f"{name} must be a whole number, not negative", table, line, name, cells[column])
        values[row] = int(value)
    return values


def _number(text: str, table: _Table, line: int, name: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        problem = f"{name} must be a number with a decimal point" + ("" if text.strip() else "; the cell is empty")
        raise _cell_error(problem, table, line, name, text) from error
    if not np.isfinite(value):
        raise _cell_error(f"{name} is not a finite number", table, line, name, text)
    return value


def _cell_error(problem: str, table: _Table, line: int, name: str, value: str) -> SkinError:
    """What is wrong with a cell; its column by its heading, or by its place where the table has no line of names."""
    column = table.columns[name]
    heading = table.headings[column]
    shown = f"{column + 1} ({name})" if is_number(heading) else heading
    place = f"line {line}, column {shown}"
    remedy = "Correct the cell, or leave the row out"
    return SkinError(problem, file=table.path, place=place, value=value or None, remedy=remedy)
