"""Rows of studies, the table that a report writes and figures draw; and statistics of those numbers that are known."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from app.core.arrays import FloatArray

Cell: TypeAlias = str | float | int | bool | None
Row: TypeAlias = Mapping[str, Cell]
Case: TypeAlias = Mapping[str, Any]
"""What to measure; its keys begin its rows."""


def number(cell: object, missing: float = math.nan) -> float:
    """A cell as a number; ``missing`` where it holds none, or nan."""
    return float(cell) if isinstance(cell, int | float) and not math.isnan(cell) else missing


def distinct(rows: Sequence[Row], key: str) -> list[Cell]:
    """The values of a column, each once, in the order in which they first come."""
    return list(dict.fromkeys(row[key] for row in rows))


def rms(values: FloatArray) -> float:
    """Root mean square of those values that are finite; nan where there is none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else math.nan


def p95(values: FloatArray) -> float:
    """95th percentile of those values that are finite; nan where there is none."""
    known = values[np.isfinite(values)]
    return float(np.percentile(known, 95)) if known.size else math.nan


def finite_or_none(value: float) -> float | None:
    """The value, or None for a cell that shall stay empty."""
    return value if math.isfinite(value) else None
