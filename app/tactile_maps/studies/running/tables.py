"""Rows as files: CSV, and Parquet where pyarrow is installed."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from importlib.util import find_spec

from tactile_maps.studies.base.rows import Row


def columns(rows: Sequence[Row]) -> list[str]:
    """Return the names of all columns in order of first occurrence."""
    return list(dict.fromkeys(key for row in rows for key in row))


def csv_table(rows: Sequence[Row]) -> bytes:
    """Return rows as CSV with a header; missing cells are empty."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns(rows), restval="")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def parquet_table(rows: Sequence[Row]) -> bytes | None:
    """Return rows as Parquet; None without pyarrow or without rows.

    Columns of numbers or booleans keep their type; all others are text.
    """
    if not rows or find_spec("pyarrow") is None:
        return None
    import pyarrow
    import pyarrow.parquet

    table = {name: pyarrow.array(_of_one_kind([row.get(name) for row in rows])) for name in columns(rows)}
    stream = io.BytesIO()
    pyarrow.parquet.write_table(pyarrow.table(table), stream, compression="zstd")
    return stream.getvalue()


def _of_one_kind(cells: list[object]) -> list[object]:
    kinds = {type(cell) for cell in cells if cell is not None}
    if len(kinds) <= 1 and kinds <= {int, float, bool}:
        return cells
    kind = float if kinds == {int, float} else str
    return [None if cell is None else kind(cell) for cell in cells]  # type: ignore[arg-type]
