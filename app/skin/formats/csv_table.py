"""Taxels as a table: comma, semicolon or tab between columns that say what they are.

Columns: ``x y z``, and where known ``nx ny nz`` (outward normal), ``u v`` (place on a map), ``taxel`` (its number),
``id`` (its hardware id; where there is no such column, ``taxel`` is), ``module``, ``channel`` and ``link``. Lengths are
metres, or millimetres where the column's name ends in ``_mm``. Without a line of names, three columns are positions and
six are positions and normals. A line that starts with # is a remark.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from app.core.arrays import FloatArray, IntArray
from app.core.errors import Finding, SkinError, add_finding, errors_in_file
from app.core.files import read_bounded_text, write_lines
from app.skin.formats.taxel_set import MAX_TAXELS, TaxelSet, distinct_numbers, is_number, line_error, unit_normals

_POSITION, _NORMAL, _POINT = ("x", "y", "z"), ("nx", "ny", "nz"), ("u", "v")
_LENGTHS = _POSITION + _POINT
_WHOLE = ("taxel", "id", "module", "channel")
_KNOWN = (*_POSITION, *_NORMAL, *_POINT, *_WHOLE, "link")
_SEPARATORS = (";", "\t", ",")
_LARGEST_NUMBER = 2**31


@dataclass(frozen=True)
class _Table:
    """The rows of one file: where they are, what their columns are called, and which of those are in millimetres."""

    path: Path
    columns: Mapping[str, int]
    millimetres: frozenset[str]
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
    names = [(cells[link].strip() if link is not None else "") for _, cells in table.rows]
    sets = []
    for name in dict.fromkeys(names):
        chosen = [row for row, of in zip(table.rows, names, strict=True) if of == name]
        sets.append(_taxel_set(table, chosen, name or None, len(set(names)) > 1))
    return (sets[0].with_findings(*table.findings), *sets[1:])


def write_table(sets: Sequence[TaxelSet], path: str | Path) -> None:
    """Write ``sets`` as one table, in metres; what only some of them know is an empty cell in the others' rows.

    Raises:
        SkinError: The file cannot be written.
    """
    known = [name for name in _KNOWN if any(_has(taxels, name) for taxels in sets)]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([f"{name}_m" if name in _LENGTHS else name for name in known])
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
    columns["taxel"] = taxels.numbers.tolist()
    for name, values in (("id", taxels.ids), ("module", taxels.modules), ("channel", taxels.channels)):
        if values is not None:
            columns[name] = values.tolist()
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
    try:
        cells = list(csv.reader((line for _, line in lines), delimiter=separator, strict=True))
    except csv.Error as error:
        raise SkinError("the table cannot be parsed", file=path, value=error) from error
    rows = [(number, row) for (number, _), row in zip(lines, cells, strict=True)] if len(cells) == len(lines) else []
    if not rows:
        raise SkinError("a quoted cell runs over several lines", file=path, remedy="Close the quotes")
    findings: list[Finding] = []
    columns, millimetres, body = _header(rows, path, findings)
    for number, row in body:
        if len(row) != len(rows[0][1]):
            raise line_error(f"the row must have {len(rows[0][1])} cells", path, number, separator.join(row))
    if not body:
        raise SkinError("the table has no rows below its names", file=path)
    return _Table(path, columns, frozenset(millimetres), body, tuple(findings))


def _header(
    rows: Sequence[tuple[int, Sequence[str]]], path: Path, findings: list[Finding]
) -> tuple[dict[str, int], set[str], Sequence[tuple[int, Sequence[str]]]]:
    """The columns by name, those in millimetres, and the rows below the names."""
    line, first = rows[0]
    if is_number(first[0]):
        names = {3: _POSITION, 6: _POSITION + _NORMAL}.get(len(first))
        if names is None:
            remedy = f"Put a line of names first: {', '.join(_KNOWN)}"
            raise SkinError(
                "the names of the columns are missing", file=path, value=f"{len(first)} columns", remedy=remedy
            )
        return {name: k for k, name in enumerate(names)}, set(), rows
    columns, millimetres = dict[str, int](), set[str]()
    for k, cell in enumerate(first):
        name, unit = cell.strip().lower(), ""
        stem, _, ending = name.rpartition("_")
        if stem in _LENGTHS and ending in ("m", "mm"):
            name, unit = stem, ending
        if name not in _KNOWN:
            add_finding(findings, "unknown-column", path.name, f"ignored: {cell.strip()[:40]!r}", 1)
        elif name in columns:
            raise line_error(f"the column {name} is duplicated", path, line, ", ".join(first))
        else:
            columns[name] = k
            if unit == "mm":
                millimetres.add(name)
    _require_whole_groups(columns, path, line)
    add_finding(findings, "millimetres", path.name, "converted to metres", len(millimetres))
    return columns, millimetres, rows[1:]


def _require_whole_groups(columns: Mapping[str, int], path: Path, line: int) -> None:
    for group in (_POSITION, _NORMAL, _POINT):
        missing = [name for name in group if name not in columns]
        if missing and (group is _POSITION or len(missing) < len(group)):
            raise line_error("a column is missing", path, line, ", ".join(missing))


def _taxel_set(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], link: str | None, named: bool) -> TaxelSet:
    where, findings = table.path.name, list[Finding]()
    normals, points = (_floats(table, rows, group) for group in (_NORMAL, _POINT))
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
            modules=modules,
            ids=ids,
            channels=channels,
            findings=tuple(findings),
        )


def _floats(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], group: Sequence[str]) -> FloatArray | None:
    """(n, k) the columns of ``group`` in SI units; NaN for an empty cell of a normal or a map point."""
    if group[0] not in table.columns:
        return None
    columns = [table.columns[name] for name in group]
    values = np.empty((len(rows), len(group)))
    for row, (line, cells) in enumerate(rows):
        for k, column in enumerate(columns):
            text = cells[column].strip()
            if text or group is _POSITION:
                values[row, k] = _number(text, table.path, line, group[k])
            else:
                values[row, k] = np.nan
    return values * [1e-3 if name in table.millimetres else 1.0 for name in group]


def _integers(table: _Table, rows: Sequence[tuple[int, Sequence[str]]], name: str) -> IntArray | None:
    if name not in table.columns:
        return None
    column = table.columns[name]
    if all(not cells[column].strip() for _, cells in rows):
        return None
    values = np.empty(len(rows), dtype=np.int64)
    for row, (line, cells) in enumerate(rows):
        value = _number(cells[column], table.path, line, name)
        if not (value.is_integer() and 0 <= value < _LARGEST_NUMBER):
            raise line_error(f"{name} must be a whole number, not negative", table.path, line, cells[column])
        values[row] = int(value)
    return values


def _number(text: str, path: Path, line: int, name: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise line_error(f"{name} must be a number with a decimal point", path, line, text) from error
    if not np.isfinite(value):
        raise line_error(f"{name} is not a finite number", path, line, text)
    return value
