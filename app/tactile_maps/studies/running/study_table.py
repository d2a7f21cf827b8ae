"""A study's table, read back: what was varied, what was measured, and the median over seeds of each point.

Any table that ``tactile-maps study`` writes can be read, as CSV or Parquet. What it is a table of, its columns say: the
keys of a case come first and end with ``seed``, and what was measured follows. Where a case has several rows, words
behind ``seed`` tell them apart.
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

from tactile_maps.core.errors import UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import read_bounded_file
from tactile_maps.studies.base.hypotheses import Interval, bootstrap_median
from tactile_maps.studies.base.rows import Cell, Row, number
from tactile_maps.studies.running.tables import columns

SEED = "seed"
"""The column that every table of a study has."""
TABLE_ENDINGS = FileKind.STUDY_TABLE.suffixes
MOST_POINTS = 400
MOST_AT_A_POINT = 2000
_REMEDY = "Give a table that `tactile-maps study NAME -o FOLDER` wrote: NAME.csv or NAME.parquet"
_TRUTH = {"True": True, "False": False}


@dataclass(frozen=True)
class TheoryColumn:
    """A column of what a closed-form law predicts of a measure.

    Attributes:
        column: Its name.
        law: The law, as a legend has it.
        source: Where it comes from and what it leaves out, in a sentence.
    """

    column: str
    law: str
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
            "alone, without the lag of the joints",
        ),
    ),
}
"""By measure: the limits and laws that studies write beside what they measure."""


@dataclass(frozen=True)
class StudyTable:
    """The rows of a study.

    Attributes:
        file: Where they were read.
        rows: In the file's order, each with every column; None where a cell is empty.
    """

    file: Path
    rows: tuple[Row, ...]

    @cached_property
    def columns(self) -> list[str]:
        """All, in the file's order."""
        return columns(self.rows)

    @cached_property
    def case_columns(self) -> list[str]:
        """What makes a row, without its seed: the columns before ``seed``; where a case has several rows, also the
        first columns of words behind it that tell those apart, if there are such.
        """
        names = self.columns
        before = names[: names.index(SEED)]
        made = list(before)
        words = (name for name in names[len(before) + 1 :] if not self._holds_numbers(name))
        while not self._tells_rows_apart(made):
            more = next(words, None)
            if more is None:
                return before
            made.append(more)
        return made

    def _tells_rows_apart(self, names: Sequence[str]) -> bool:
        return len({tuple(row[name] for name in (*names, SEED)) for row in self.rows}) == len(self.rows)

    def _holds_numbers(self, name: str) -> bool:
        """Whether most cells that are filled do."""
        filled = [row[name] for row in self.rows if row[name] is not None]
        return 2 * sum(map(_is_number, filled)) > len(filled)

    @property
    def factors(self) -> list[str]:
        """What a point can be told by: every column but the seed, those of the case first."""
        return [name for name in self.columns if name != SEED]

    @property
    def measures(self) -> list[str]:
        """Columns that hold numbers rather than words, those that make no row first."""
        known = [name for name in self.columns if name != SEED and self._holds_numbers(name)]
        return sorted(known, key=lambda name: name in self.case_columns)

    def theory(self, measure: str) -> tuple[TheoryColumn, ...]:
        """What laws predict of a measure, as far as the table says."""
        return tuple(one for one in THEORY.get(measure, ()) if one.column in self.columns)


@dataclass(frozen=True)
class TablePoint:
    """The rows with one value of a factor, and what they say.

    Attributes:
        x: The factor's value.
        series: That of the column that tells curves apart; None where there is none.
        interval: Median over seeds and its 95 % bootstrap interval; infinite where most of them cannot.
        rows: All that are behind it.
        missing: How many of them have no such number, and are not counted.
        pooled: Columns of the case in which they differ besides: rows of several cases are taken for one.
    """

    x: Cell
    series: Cell
    interval: Interval
    rows: tuple[Row, ...]
    missing: int
    pooled: tuple[str, ...]

    def predicted(self, column: str) -> float | None:
        """The median of what a law predicts of these rows; None where it is not said or differs without bound."""
        values = [value for row in self.rows if (value := number(row[column])) is not None and math.isfinite(value)]
        return median(values) if values else None


def read_study_table(path: str | Path) -> StudyTable:
    """The table in the file at ``path``. Cost: 0.1 s for 10,000 rows of CSV.

    Raises:
        UsageError: It cannot be read, is no CSV or Parquet file, or no study's table.
    """
    path = Path(path)
    if path.suffix.lower() not in TABLE_ENDINGS:
        raise UsageError("this is no table of a study", file=path, value=path.suffix or "no ending", remedy=_REMEDY)
    data = read_bounded_file(path, error=UsageError)
    rows = _parquet_rows(path, data) if path.suffix.lower() == ".parquet" else _csv_rows(path, data)
    if not rows:
        raise UsageError("the table has no rows", file=path, remedy=_REMEDY)
    table = StudyTable(path, tuple(rows))
    if SEED not in table.columns:
        named = ", ".join(table.columns)
        raise UsageError(f"the table is no study's: it has no column {SEED}", file=path, value=named, remedy=_REMEDY)
    if not table.measures:
        raise UsageError("no column of the table holds numbers", file=path, remedy=_REMEDY)
    return table


def _csv_rows(path: Path, data: bytes) -> list[Row]:
    try:
        lines = list(csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True))
    except (UnicodeDecodeError, csv.Error) as error:
        raise UsageError("the table is no CSV", file=path, value=error, remedy=_REMEDY) from error
    head = lines[0] if lines else []
    if len(set(head)) < len(head):
        double = next(name for name in head if head.count(name) > 1)
        raise UsageError("two columns have one name", file=path, value=double, remedy=_REMEDY)
    for line, cells in enumerate(lines[1:], start=2):
        if len(cells) != len(head):
            told = f"{len(cells)} cells, where the head has {len(head)}"
            raise UsageError(f"line {line} is not whole", file=path, value=told, remedy=_REMEDY)
    return [dict(zip(head, map(_cell, cells), strict=True)) for cells in lines[1:]]


def _cell(text: str) -> Cell:
    """A cell as what it was before it was written; numbers that are none are missing."""
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
            remedy="pip install 'tactile-maps[pyarrow]', or open the CSV beside it",
        )
    import pyarrow
    import pyarrow.parquet

    try:
        found = pyarrow.parquet.read_table(io.BytesIO(data)).to_pylist()
    except (pyarrow.ArrowException, OSError, ValueError) as error:
        raise UsageError("the table is no Parquet file", file=path, value=error, remedy=_REMEDY) from error
    return [{name: _plain(path, name, cell) for name, cell in row.items()} for row in found]


def _plain(path: Path, name: str, cell: object) -> Cell:
    if isinstance(cell, str):
        return _cell(cell)
    if cell is None or (isinstance(cell, float) and math.isnan(cell)):
        return None
    if isinstance(cell, bool | int | float):
        return cell
    kind = type(cell).__name__
    raise UsageError(f"column {name} holds neither numbers nor words", file=path, value=kind, remedy=_REMEDY)


def _is_number(cell: Cell) -> bool:
    return number(cell) is not None and not isinstance(cell, bool)


def only(rows: Sequence[Row], conditions: str) -> list[Row]:
    """The rows for which all conditions hold.

    Args:
        rows: Of a table.
        conditions: ``column=value``, one after the other with commas between; empty for all rows.

    Raises:
        UsageError: A condition is none, or there is no such column.
    """
    chosen = list(rows)
    for condition in filter(None, (part.strip() for part in conditions.split(","))):
        name, equals, value = (part.strip() for part in condition.partition("="))
        if not equals or (rows and name not in rows[0]):
            named = ", ".join(rows[0]) if rows else "none"
            raise UsageError("this is no condition", value=condition, remedy=f"Write column=value; columns: {named}")
        wanted = _cell(value)
        chosen = [row for row in chosen if row[name] == wanted]
    return chosen


def table_points(table: StudyTable, rows: Sequence[Row], x: str, y: str, by: str | None = None) -> list[TablePoint]:
    """A point for each value of a factor, and of the column ``by``; numbers in order, words as they come.

    Args:
        table: Whose rows they are.
        rows: Those that count.
        x: The factor.
        y: The measure. Of a row whose verdict is ``cannot`` a number that is missing is infinite.
        by: The column that tells curves apart.

    Raises:
        UsageError: They are too many to be told apart or reckoned.
    """
    found: dict[tuple[Cell, Cell], list[Row]] = {}
    for row in rows:
        found.setdefault((row[x], row[by] if by else None), []).append(row)
    if len(found) > MOST_POINTS or any(len(one) > MOST_AT_A_POINT for one in found.values()):
        told = f"{len(found)} points from {len(rows)} rows"
        remedy = (
            f"The most are {MOST_POINTS} points, of {MOST_AT_A_POINT} rows each: choose another factor or fewer rows"
        )
        raise UsageError("these are too many to draw", value=told, remedy=remedy)
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
    """Numbers by size, then all others as they came."""
    known = number(cell)
    return known is None, known or 0.0
