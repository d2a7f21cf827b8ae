"""A study table read from a file: what was varied, what was measured, and the median over seeds of each point.

Any table of ``tactile-maps study`` can be read, as CSV or Parquet. Its columns define their meaning: the keys of a case
come first and end with ``seed``, and the measures follow. Where a case has several rows, columns of words after
``seed`` distinguish them.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from statistics import median

from tactile_maps.core.errors import UsageError, install_line
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import read_bounded_file, text_encoding
from tactile_maps.studies.base.hypotheses import Interval, bootstrap_median
from tactile_maps.studies.base.rows import Cell, Row, number
from tactile_maps.studies.running.tables import columns

SEED = "seed"
"""Column that every study table has."""
TABLE_ENDINGS = FileKind.STUDY_TABLE.suffixes
MOST_POINTS = 400
MOST_AT_A_POINT = 2000
_REMEDY = "Give a table that `tactile-maps study NAME -o FOLDER` wrote: NAME.csv or NAME.parquet"
_TRUTH = {"True": True, "False": False}


@dataclass(frozen=True)
class TheoryColumn:
    """Column with the theoretical value of a measure.

    Attributes:
        column: Name of the column.
        name: Name in a legend.
        source: Origin of the formula and its omissions, in a sentence.
    """

    column: str
    name: str
    source: str


THEORY: dict[str, tuple[TheoryColumn, ...]] = {
    "measured": (
        TheoryColumn(
            "predicted",
            "Theory, ideal joints",
            "Sampled integrating loop with d + 1/2 readings of delay: settling 6.4 (d + 1/2) T, oscillation from a "
            "stiffness of L_max / (k_f T) on, ripple sqrt(L / (2 - L))",
        ),
        TheoryColumn("explained", "Theory with the posture loop", "The same sampled loop with the joints' lag in it"),
    ),
    "seconds": (
        TheoryColumn(
            "bound_s",
            "Bound l T / (L* e)",
            "Path of length l within e, at the gain L* of a sampled loop that does not overshoot: the skin's readings "
            "only, without the lag of the joints",
        ),
    ),
}
"""Theoretical columns that studies write next to a measure, by measure."""


@dataclass(frozen=True)
class StudyTable:
    """Rows of a study.

    Attributes:
        file: File they were read from.
        rows: Rows in the order of the file, each with every column; None for empty cells.
    """

    file: Path
    rows: tuple[Row, ...]

    @cached_property
    def columns(self) -> list[str]:
        """All columns in the order of the file."""
        return columns(self.rows)

    @cached_property
    def case_columns(self) -> list[str]:
        """Columns that identify a row apart from its seed: those before ``seed`` and, where a case has several rows,
        the first columns of words after it that distinguish these rows.
        """
        names = self.columns
        before = names[: names.index(SEED)]
        made = list(before)
        words = (name for name in names[len(before) + 1 :] if not self._holds_numbers(name))
        while not self._distinguishes_rows(made):
            more = next(words, None)
            if more is None:
                return before
            made.append(more)
        return made

    def _distinguishes_rows(self, names: Sequence[str]) -> bool:
        return len({tuple(row[name] for name in (*names, SEED)) for row in self.rows}) == len(self.rows)

    def _holds_numbers(self, name: str) -> bool:
        """Whether most filled cells of a column contain numbers."""
        filled = [row[name] for row in self.rows if row[name] is not None]
        return 2 * sum(map(_is_number, filled)) > len(filled)

    @property
    def factors(self) -> list[str]:
        """Columns that can be an axis: all but the seed, those of the case first."""
        return [name for name in self.columns if name != SEED]

    @property
    def measures(self) -> list[str]:
        """Columns of numbers, those outside of the case first."""
        known = [name for name in self.columns if name != SEED and self._holds_numbers(name)]
        return sorted(known, key=lambda name: name in self.case_columns)

    def theory(self, measure: str) -> tuple[TheoryColumn, ...]:
        """Return the theoretical columns of a measure that the table contains."""
        return tuple(one for one in THEORY.get(measure, ()) if one.column in self.columns)


@dataclass(frozen=True)
class TablePoint:
    """Rows with the same value of a factor, and their statistics.

    Attributes:
        x: Value of the factor.
        series: Value of the column that separates curves; None without one.
        interval: Median over seeds and its 95 % bootstrap interval; infinite where most seeds fail.
        rows: The rows.
        missing: Number of rows without such a number, which are left out.
        pooled: Further columns of the case in which the rows differ: several cases are combined.
    """

    x: Cell
    series: Cell
    interval: Interval
    rows: tuple[Row, ...]
    missing: int
    pooled: tuple[str, ...]

    def predicted(self, column: str) -> float | None:
        """Return the median theoretical value of these rows; None if it is missing or infinite."""
        values = [value for row in self.rows if (value := number(row[column])) is not None and math.isfinite(value)]
        return median(values) if values else None


def read_study_table(path: str | Path) -> StudyTable:
    """Read the study table in the file at ``path``. Cost: 0.1 s for 10,000 rows of CSV.

    Raises:
        UsageError: The file cannot be read, is not CSV or Parquet, or is not a study table.
    """
    path = Path(path)
    if path.suffix.lower() not in TABLE_ENDINGS:
        raise UsageError("not a study table", file=path, value=path.suffix or "no file extension", remedy=_REMEDY)
    data = read_bounded_file(path, error=UsageError)
    rows = _parquet_rows(path, data) if path.suffix.lower() == ".parquet" else _csv_rows(path, data)
    if not rows:
        raise UsageError("the table has no rows", file=path, remedy=_REMEDY)
    table = StudyTable(path, tuple(rows))
    if SEED not in table.columns:
        named = ", ".join(table.columns)
        raise UsageError(f"not a study table: column {SEED} is missing", file=path, value=named, remedy=_REMEDY)
    if not table.measures:
        raise UsageError("the table has no column of numbers", file=path, remedy=_REMEDY)
    return table


def _csv_rows(path: Path, data: bytes) -> list[Row]:
    try:
        lines = list(csv.reader(io.StringIO(data.decode(text_encoding(data)), newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError("not a CSV file", file=path, value=error, remedy=_REMEDY) from error
    head = lines[0] if lines else []
    if len(set(head)) < len(head):
        double = next(name for name in head if head.count(name) > 1)
        raise UsageError("two columns have the same name", file=path, value=double, remedy=_REMEDY)
    for line, cells in enumerate(lines[1:], start=2):
        if len(cells) != len(head):
            found = f"{len(cells)} cells instead of {len(head)}"
            raise UsageError(f"line {line} is incomplete", file=path, value=found, remedy=_REMEDY)
    return [dict(zip(head, map(_cell, cells), strict=True)) for cells in lines[1:]]


def _cell(text: str) -> Cell:
    """The value of a cell before it was written; NaN is missing."""
    if text in _TRUTH:
        return _TRUTH[text]
    for kind in (int, float):
        try:
            value = kind(text)
        except ValueError:
            continue
        return None if math.isnan(value) else value
    return text or None


def _parquet_rows(path: Path, data: bytes) -> list[Row]:
    if find_spec("pyarrow") is None:
        raise UsageError(
            "a Parquet file needs pyarrow, which is not installed",
            file=path,
            remedy=f"{install_line('pyarrow')}; or open the CSV file next to it",
        )
    import pyarrow
    import pyarrow.parquet

    try:
        found = pyarrow.parquet.read_table(io.BytesIO(data)).to_pylist()
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        raise UsageError("not a Parquet file", file=path, value=error, remedy=_REMEDY) from error
    return [{name: _plain(path, name, cell) for name, cell in row.items()} for row in found]


def _plain(path: Path, name: str, cell: object) -> Cell:
    if isinstance(cell, str):
        return _cell(cell)
    if cell is None or (isinstance(cell, float) and math.isnan(cell)):
        return None
    if isinstance(cell, bool | int | float):
        return cell
    kind = type(cell).__name__
    raise UsageError(f"column {name} contains neither numbers nor words", file=path, value=kind, remedy=_REMEDY)


def _is_number(cell: Cell) -> bool:
    return number(cell) is not None and not isinstance(cell, bool)


def only(rows: Sequence[Row], conditions: str) -> list[Row]:
    """Return the rows that satisfy all conditions.

    Args:
        rows: Rows of a table.
        conditions: ``column=value``, separated by commas; empty for all rows.

    Raises:
        UsageError: A condition is malformed, or its column is unknown.
    """
    chosen = list(rows)
    for condition in filter(None, (part.strip() for part in conditions.split(","))):
        name, equals, value = (part.strip() for part in condition.partition("="))
        if not equals or (rows and name not in rows[0]):
            named = ", ".join(rows[0]) if rows else "none"
            raise UsageError("invalid condition", value=condition, remedy=f"Write column=value; columns: {named}")
        required = _cell(value)
        chosen = [row for row in chosen if row[name] == required]
    return chosen


def table_points(table: StudyTable, rows: Sequence[Row], x: str, y: str, by: str | None = None) -> list[TablePoint]:
    """Return a point for each value of a factor and of the column ``by``; numbers sorted, words in order of occurrence.

    Args:
        table: Table of the rows.
        rows: Selected rows.
        x: The factor.
        y: The measure. A missing number in a row with verdict ``cannot`` counts as infinite.
        by: Column that separates curves.

    Raises:
        UsageError: There are too many points or rows to draw.
    """
    found: dict[tuple[Cell, Cell], list[Row]] = {}
    for row in rows:
        found.setdefault((row[x], row[by] if by else None), []).append(row)
    if len(found) > MOST_POINTS or any(len(one) > MOST_AT_A_POINT for one in found.values()):
        found_text = f"{len(found)} points from {len(rows)} rows"
        remedy = f"Choose another factor or fewer rows, for at most {MOST_POINTS} points of {MOST_AT_A_POINT} rows each"
        raise UsageError("too many points to draw", value=found_text, remedy=remedy)
    cases = [name for name in table.case_columns if name not in (x, by)]
    points = (_point(key, rows, y, cases) for key, rows in found.items())
    return sorted(filter(None, points), key=lambda point: _order(point.x))


def _point(key: tuple[Cell, Cell], rows: Sequence[Row], y: str, cases: Sequence[str]) -> TablePoint | None:
    values = [value for row in rows if (value := _value(row, y)) is not None]
    if not values:
        return None
    pooled = tuple(name for name in cases if len({row[name] for row in rows}) > 1)
    return TablePoint(*key, bootstrap_median(values), tuple(rows), len(rows) - len(values), pooled)


def _value(row: Row, y: str) -> float | None:
    if row[y] is None and row.get("verdict") == "cannot":
        return math.inf
    return number(row[y])


def _order(cell: Cell) -> tuple[bool, float]:
    """Sort key: numbers by size, then all others in order of occurrence."""
    known = number(cell)
    return known is None, known or 0.0
