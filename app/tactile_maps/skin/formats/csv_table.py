"""Taxels as a table: comma, semicolon or tab between named columns in any order.

Columns: ``x y z``, and optionally ``nx ny nz`` (outward normal), ``axes`` (1 or 3), ``t1x t1y t1z`` and ``t2x t2y t2z``
(tangents of the frame of a taxel), ``u v`` (position on a map), ``area``, ``taxel`` (number), ``id`` (hardware id;
without this column, ``taxel``), ``aliases`` (further ids at this place, separated by blanks), ``module``, ``channel``,
``stream`` (number of values in a vendor's stream without ids, the same for all taxels of a link), ``name`` and
``link``. Common synonyms are accepted (``pos_x``, ``normal_x``, ``taxel_id``, ``body``...). A unit follows the name:
``x_mm``, ``x [mm]``, ``area (mm2)``. Lengths without a unit are metres, or millimetres with a finding if metres are
implausible. Without a line of names, three columns are positions and six are positions and normals. Lines that start
with # are comments.
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
from tactile_maps.skin.formats.vendors.documents import TableRows, names_readings, refuse_decimal_comma, table_rows
from tactile_maps.skin.formats.vendors.mapping_file import mapping_path, template_command
from tactile_maps.skin.model.taxel_axes import NUMBERS_OF_AXES, stated_frames
from tactile_maps.skin.model.taxel_set import (
    METRES,
    TaxelSet,
    distinct_numbers,
    further_ids,
    is_number,
    length_unit,
    line_error,
    stated_areas,
    unit_normals,
)

_POSITION = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_T1 = ("t1x", "t1y", "t1z")
_T2 = ("t2x", "t2y", "t2z")
_POINT = ("u", "v")
_LENGTHS = _POSITION + _POINT
_WHOLE = ("taxel", "id", "module", "channel")
_KNOWN = (*_POSITION, *_NORMAL, "axes", *_T1, *_T2, *_POINT, "area", *_WHOLE, "aliases", "stream", "name", "link")
_SQUARE_METRES = {f"{unit}{square}": metres**2 for unit, metres in METRES.items() for square in ("2", "²", "^2")}
_UNIT = re.compile(r"^(?P<name>.+?)(?:[_/](?P<after>[a-zµ]+(?:\^?2|²)?)|[\[(]_?(?P<within>[^\])]*?)_?[\])])$")
_OTHER_NAMES = {
    **{f"{word}_{axis}": axis for axis in _POSITION for word in ("pos", "position", "p")},
    **{f"{axis}_{word}": axis for axis in _POSITION for word in ("pos", "position")},
    **{f"p{axis}": axis for axis in _POSITION},
    **{f"{word}_{axis}": f"n{axis}" for axis in _POSITION for word in ("n", "normal", "norm")},
    **{f"normal{axis}": f"n{axis}" for axis in _POSITION},
    **{f"{word}{k}_{axis}": f"t{k}{axis}" for axis in _POSITION for k in (1, 2) for word in ("t", "tangent")},
    **dict.fromkeys(("n_axes", "num_axes", "number_of_axes"), "axes"),
    **{f"map_{axis}": axis for axis in _POINT},
    **{f"{word}_id": word for word in ("module", "channel")},
    **dict.fromkeys(("taxel_id", "hardware_id", "hw_id", "sensor_id"), "id"),
    **dict.fromkeys(("number", "index", "taxel_number", "taxel_index"), "taxel"),
    **dict.fromkeys(("board", "board_id", "patch_module"), "module"),
    **dict.fromkeys(("body", "link_name", "frame", "frame_id", "parent_link"), "link"),
    **dict.fromkeys(("taxel_area", "sensor_area"), "area"),
    **dict.fromkeys(("taxel_name", "sensor_name", "sensor"), "name"),
}
_LARGEST_NUMBER = 2**31
MAX_LINKS = 1000


@dataclass(frozen=True)
class _Table:
    """Rows of a file with their line numbers, columns by name, and the SI value of the unit of each column."""

    where: str
    columns: Mapping[str, int]
    units: Mapping[str, float]
    headings: Sequence[str]
    rows: TableRows
    findings: tuple[Finding, ...]


def read_table(path: str | Path) -> tuple[TaxelSet, ...]:
    """Return the taxels of a table, one set for each link it names, in the order of their first rows.

    Raises:
        SkinError: The file cannot be read, a column is missing, or a cell is invalid; names the line.
    """
    path = Path(path)
    text = read_bounded_text(path, error=SkinError)
    with errors_in_file(path):
        table = _parse(text, path.name)
        link = table.columns.get("link")
        rows = dict[str, list[tuple[int, Sequence[str]]]]()
        for row in table.rows:
            rows.setdefault(row[1][link].strip() if link is not None else "", []).append(row)
        if len(rows) > MAX_LINKS:
            problem = f"the table names more than {MAX_LINKS} links"
            place = f"column {table.headings[link or 0]}"
            raise SkinError(problem, place=place, value=len(rows), remedy="Check which column names the links")
        sets = [
            _taxel_set(table, own, name or None, name if name and len(rows) > 1 else path.stem)
            for name, own in rows.items()
        ]
    return (sets[0].with_findings(*table.findings), *sets[1:])


def write_table(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` as one table in metres, with empty cells for properties that a set does not have.

    Raises:
        SkinError: The file cannot be written.
    """
    tables = [_columns(taxels) for taxels in sets]
    known = [name for name in _KNOWN if any(name in columns for columns in tables)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name}_m" if name in _LENGTHS else f"{name}_m2" if name == "area" else name for name in known])
    for taxels, columns in zip(sets, tables, strict=True):
        writer.writerows(zip(*(columns.get(name, [""] * len(taxels)) for name in known), strict=True))
    write_lines(Path(path), text.getvalue().splitlines(), error=SkinError)


def _columns(taxels: TaxelSet) -> dict[str, list[object]]:
    """Return the cells by column, for the properties of the set."""
    blocks = (
        (_POSITION, taxels.positions),
        (_NORMAL, taxels.normals),
        (_T1, taxels.tangents),
        (_POINT, taxels.points),
    )
    columns: dict[str, list[object]] = {
        name: ["" if np.isnan(x) else x for x in values[:, k].tolist()]
        for names, values in blocks
        if values is not None
        for k, name in enumerate(names)
    }
    single = (
        ("axes", taxels.axes),
        ("area", taxels.areas),
        ("taxel", taxels.numbers),
        ("id", taxels.ids),
        ("module", taxels.modules),
        ("channel", taxels.channels),
    )
    for name, values in single:
        if values is not None:
            columns[name] = values.tolist()
    if taxels.aliases is not None:
        further = further_ids(taxels.aliases, len(taxels))
        columns["aliases"] = [" ".join(map(str, ids)) for ids in further]
    if taxels.stream is not None:
        columns["stream"] = [taxels.stream] * len(taxels)
    if taxels.names is not None:
        columns["name"] = [" ".join(name.split()) for name in taxels.names]
    if taxels.link is not None:
        columns["link"] = [" ".join(taxels.link.split())] * len(taxels)
    return columns


def _parse(text: str, where: str) -> _Table:
    rows = table_rows(text)
    findings = list[Finding]()
    columns, units, body = _header(rows, where, findings)
    if not body:
        raise SkinError("the table has no rows below its names")
    units |= _guessed_units(columns, units, body, where, findings)
    return _Table(where, columns, units, [cell.strip() for cell in rows[0][1]], body, tuple(findings))


def _header(rows: TableRows, where: str, findings: list[Finding]) -> tuple[dict[str, int], dict[str, float], TableRows]:
    """Return the columns by name, the SI values of stated units, and the rows below the names."""
    line, first = rows[0]
    refuse_decimal_comma(first[0], place=f"line {line}", error=SkinError)
    if is_number(first[0]):
        names = {3: _POSITION, 6: _POSITION + _NORMAL}.get(len(first))
        if names is None:
            remedy = f"Put a line of names first: {', '.join(_KNOWN)}"
            raise SkinError("the names of the columns are missing", value=f"{len(first)} columns", remedy=remedy)
        return {name: k for k, name in enumerate(names)}, {}, rows
    columns = dict[str, int]()
    units = dict[str, float]()
    for k, cell in enumerate(first):
        name, unit = _column_name(cell, line)
        if name not in _KNOWN:
            add_finding(findings, "unknown-column", where, f"ignored: {cell.strip()[:40]!r}", 1)
        elif name in columns:
            raise line_error(f"the column {name} is duplicated", line, ", ".join(first))
        else:
            columns[name] = k
            if unit is not None:
                units[name] = unit
    for group in (_POSITION, _NORMAL, _POINT, _T1, _T2):
        missing = [name for name in group if name not in columns]
        if missing and group is _POSITION and names_readings(first):
            remedy = "Connect to it with File > Connect, or read it with the command listen"
            raise SkinError("the table has readings, not taxels", place=f"line {line}", remedy=remedy)
        if missing and (group is _POSITION or len(missing) < len(group)):
            remedy = f"Name the columns {', '.join(group)} in the first line"
            if group[0] in _LENGTHS:
                remedy += f", with a unit as in {group[0]}_mm (known units: {', '.join(METRES)})"
            if group is _POSITION:
                remedy += f", or in {mapping_path(Path(where)).name} next to it; {template_command(Path(where))}"
            raise _missing_columns(missing, rows[0], remedy)
    if _T2[0] in columns and _T1[0] not in columns:
        remedy = f"Name the columns {', '.join(_T1)}, too, or leave t2 out"
        raise _missing_columns(_T1, rows[0], remedy)
    add_finding(findings, "millimetres", where, "converted to metres", list(units.values()).count(1e-3))
    return columns, units, rows[1:]


def _missing_columns(missing: Sequence[str], header: tuple[int, Sequence[str]], remedy: str) -> SkinError:
    """Return the error about columns that are not in the line of names."""
    line, cells = header
    problem = "a column is missing" if len(missing) == 1 else "columns are missing"
    found = ", ".join(cell.strip() for cell in cells)
    return SkinError(f"{problem}: {', '.join(missing)}", place=f"line {line}", value=found, remedy=remedy)


def _column_name(cell: str, line: int) -> tuple[str, float | None]:
    """Return the name of a column from its heading, and the SI value of the unit in it.

    Raises:
        SkinError: The unit does not fit the column.
    """
    text = " ".join(cell.split()).lower().replace(" ", "_").replace("_[", "[").replace("_(", "(")
    if (plain := _OTHER_NAMES.get(text, text)) in _KNOWN or not (found := _UNIT.match(text)):
        return plain, None
    name = _OTHER_NAMES.get(found["name"], found["name"])
    word = found["after"] or found["within"]
    units = METRES if name in _LENGTHS else _SQUARE_METRES if name == "area" else {}
    if word in units:
        return name, units[word]
    if name not in _KNOWN or found["after"]:
        return text, None
    if not units:
        return name, None  # the unit of a number or a direction does not matter
    remedy = f"Choose one of: {', '.join(units)}"
    place = f"line {line}, column {cell.strip()}"
    raise SkinError(f"the unit of {name} is not known", place=place, value=word, remedy=remedy)


def _guessed_units(
    columns: Mapping[str, int], units: Mapping[str, float], body: TableRows, where: str, findings: list[Finding]
) -> dict[str, float]:
    """Return the units of columns that state none: metres, unless these are implausible; areas follow the positions."""
    guessed = dict[str, float]()
    for group in (_POSITION, _POINT):
        if group[0] not in columns or any(name in units for name in group):
            continue
        values = _values(body, [columns[name] for name in group])
        values = values[np.isfinite(values).all(axis=1)]
        if len(values):
            guessed |= dict.fromkeys(group, length_unit(values, f"{where}, columns {', '.join(group)}", findings))
    if "area" in columns and "area" not in units:
        unit = units.get("x", guessed.get("x", 1.0)) ** 2
        word = {1.0: "m2", 1e-6: "mm2"}.get(unit, f"{unit:g} m2")
        action = f"assumed to be in {word}, like the positions: the column does not state its unit"
        add_finding(findings, "guessed-unit", f"{where}, column area", action, len(body))
        guessed["area"] = unit
    return guessed


def _taxel_set(table: _Table, rows: TableRows, link: str | None, name: str) -> TaxelSet:
    where = table.where
    findings = list[Finding]()
    normals, points, areas = (_floats(table, rows, group) for group in (_NORMAL, _POINT, ("area",)))
    numbers, ids, modules, channels = (_integers(table, rows, column) for column in _WHOLE)
    ids = numbers if ids is None else ids
    numbers = ids if numbers is None else numbers
    if normals is not None and np.isnan(normals).all():
        normals = None
    normals = None if normals is None else unit_normals(normals, where, findings)
    axes = _axes(table, rows)

    def place(row: int) -> str:
        return f"line {rows[row][0]}" + ("" if ids is None else f", taxel {ids[row]}")

    t1, t2 = (_floats(table, rows, group) for group in (_T1, _T2))
    tangents = stated_frames(axes, t1, t2, normals, where=where, findings=findings, place=place)
    return TaxelSet(
        name,
        link,
        np.arange(len(rows)) if numbers is None else distinct_numbers(numbers, where, findings),
        np.asarray(_floats(table, rows, _POSITION)),
        normals=normals,
        axes=axes,
        tangents=tangents,
        points=None if points is None or np.isnan(points).all() else points,
        areas=None if areas is None or np.isnan(areas).all() else stated_areas(areas[:, 0], where, findings),
        modules=modules,
        ids=ids,
        channels=channels,
        names=_names(table, rows),
        aliases=None if ids is None else _aliases(table, rows),
        stream=_stream(table, rows),
        findings=tuple(findings),
    )


def _axes(table: _Table, rows: TableRows) -> IntArray | None:
    """Return (n,) numbers of axes, 1 for empty cells; None without the column."""
    values = _floats(table, rows, ("axes",))
    if values is None:
        return None
    numbers = np.where(np.isnan(values[:, 0]), 1, values[:, 0])
    valid = np.isin(numbers, NUMBERS_OF_AXES)
    if not valid.all():
        line, cells = rows[int(valid.argmin())]
        raise _cell_error("must be 1 or 3", table, line, "axes", cells[table.columns["axes"]].strip())
    return numbers.astype(np.int64)


def _aliases(table: _Table, rows: TableRows) -> IntArray | None:
    """Return (k, 2) further ids and their rows; None if no row has one."""
    if "aliases" not in table.columns:
        return None
    found = list[tuple[int, int]]()
    for row, (line, cells) in enumerate(rows):
        text = cells[table.columns["aliases"]]
        for word in text.split():
            if not (word.isdecimal() and word.isascii() and len(word) <= 10 and int(word) < _LARGEST_NUMBER):
                raise _cell_error("must be ids separated by blanks", table, line, "aliases", text.strip())
            found.append((int(word), row))
    return np.array(found, dtype=np.int64) if found else None


def _stream(table: _Table, rows: TableRows) -> int | None:
    """Return the number of values in the stream; None if it is not stated.

    Raises:
        SkinError: Rows of one link state different numbers.
    """
    numbers = _integers(table, rows, "stream")
    if numbers is None:
        return None
    other = numbers != numbers[0]
    if other.any():
        line, cells = rows[int(other.argmax())]
        problem = f"must be the same for all taxels of a link, here {numbers[0]}"
        raise _cell_error(problem, table, line, "stream", cells[table.columns["stream"]].strip())
    return int(numbers[0])


def _names(table: _Table, rows: TableRows) -> tuple[str, ...] | None:
    """Return (n,) names of the taxels; None if no row has one."""
    if "name" not in table.columns:
        return None
    names = tuple(cells[table.columns["name"]].strip() for _, cells in rows)
    return names if any(names) else None


def _values(rows: TableRows, columns: Sequence[int]) -> FloatArray:
    """Return (n, k) the numbers in some columns; NaN for cells that are not numbers."""

    def value(text: str) -> float:
        try:
            return float(text)
        except ValueError:
            return np.nan

    texts = [cells[column] for _, cells in rows for column in columns]
    try:
        values = list(map(float, texts))
    except ValueError:
        values = list(map(value, texts))
    return np.array(values).reshape(-1, len(columns))


def _floats(table: _Table, rows: TableRows, group: Sequence[str]) -> FloatArray | None:
    """Return (n, k) the columns of ``group`` in SI units; NaN for empty cells, which positions may not have."""
    if group[0] not in table.columns:
        return None
    columns = [table.columns[name] for name in group]
    values = _values(rows, columns)
    for row, k in np.argwhere(~np.isfinite(values)).tolist():
        line, cells = rows[row]
        text = cells[columns[k]].strip()
        if text or group is _POSITION:
            refuse_decimal_comma(text, place=f"line {line}, {_column_text(table, group[k])}", error=SkinError)
            empty = "" if text else "; the cell is empty"
            problem = f"must be a number with a decimal point{empty}"
            raise _cell_error("is not a finite number" if is_number(text) else problem, table, line, group[k], text)
    return values * [table.units.get(name, 1.0) for name in group]


def _integers(table: _Table, rows: TableRows, name: str) -> IntArray | None:
    """Return (n,) the whole numbers of a column; None without the column, or if all of its cells are empty."""
    values = _floats(table, rows, (name,))
    if values is None or np.isnan(values).all():
        return None
    valid = (values >= 0) & (values < _LARGEST_NUMBER) & (values % 1 == 0)
    if not valid.all():
        line, cells = rows[int(valid.argmin())]
        text = cells[table.columns[name]].strip()
        problem = "must be a whole number, not negative" if text else "must be a number; the cell is empty"
        raise _cell_error(problem, table, line, name, text)
    return values[:, 0].astype(np.int64)


def _cell_error(problem: str, table: _Table, line: int, name: str, value: str) -> SkinError:
    """Return the error about a cell."""
    remedy = "Correct the cell, or leave the row out"
    place = f"line {line}, {_column_text(table, name)}"
    return SkinError(f"{name} {problem}", place=place, value=value or None, remedy=remedy)


def _column_text(table: _Table, name: str) -> str:
    """Return the place of a column: its heading, or its position without headings."""
    column = table.columns[name]
    heading = table.headings[column]
    return f"column {column + 1} ({name})" if is_number(heading) else f"column {heading}"
