"""Hypotheses: what theory expects of the rows of a study, and whether it held.

A judgement is based on intervals, not on medians alone: held if the whole interval is within the bounds, not held if
all of it is outside, and otherwise, or with missing rows, not decided.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.base.rows import Row


class Verdict(StrEnum):
    """Result of the comparison of rows with a hypothesis."""

    HELD = "held"
    NOT_HELD = "not held"
    NOT_DECIDED = "not decided"


class Interval(NamedTuple):
    """Median over seeds and the ends of its 95 % bootstrap interval; infinite where most seeds fail."""

    middle: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.middle:.3g} [{self.low:.3g}, {self.high:.3g}]"


_DRAWS = 2000
_SURE = (2.5, 97.5)


def bootstrap_median(values: Sequence[float]) -> Interval:
    """Return the median over seeds with its bootstrap interval.

    Args:
        values: At least one value, one a seed; inf for a seed that fails.
    """
    known = np.asarray(values, dtype=np.float64)
    middle = _median(known[None])[0]
    drawn = _median(np.random.default_rng(0).choice(known, (_DRAWS, len(known))))
    # Percentiles between inf and a number are no number: the nearest value counts.
    low, high = np.percentile(drawn, _SURE, method="nearest")
    return Interval(float(middle), float(low), float(high))


def paired_ratio(values: Sequence[float], others: Sequence[float]) -> Interval:
    """Return the median over seeds of value over other; common effects of a seed cancel (common random numbers).

    Args:
        values: Positive values, one a seed; inf for a seed that fails.
        others: Finite values of the same seeds.
    """
    return bootstrap_median([one / other for one, other in zip(values, others, strict=True)])


def paired_difference(values: Sequence[float], others: Sequence[float]) -> Interval:
    """Return the median over seeds of value minus other: as ``paired_ratio``, in the unit of the values."""
    return bootstrap_median([one - other for one, other in zip(values, others, strict=True)])


def _median(rows: FloatArray) -> FloatArray:
    """(k,) median of each row (k, n): the upper of two middle values, so that it is one of the values."""
    return np.asarray(np.sort(rows, axis=1)[:, rows.shape[1] // 2])


@dataclass(frozen=True)
class Judgement:
    """Judgement of a hypothesis by rows.

    Attributes:
        verdict: The verdict.
        figures: The figures that decide, with their intervals.
        rows: Number of rows on which it is based.
    """

    verdict: Verdict
    figures: str
    rows: int


@dataclass(frozen=True)
class Hypothesis:
    """Expectation from theory.

    Attributes:
        name: ``H1`` to ``H8``.
        statement: The expectation, with its numbers.
        judge: Judges rows of a study; rows with a ``problem`` are removed before the call.
    """

    name: str
    statement: str
    judge: Callable[[Sequence[Row]], Judgement]


def within(interval: Interval, low: float, high: float) -> Verdict:
    """Compare a figure with bounds.

    Args:
        interval: The figure with its interval.
        low: Lower bound; may be infinite.
        high: Upper bound; may be infinite.
    """
    if low <= interval.low and interval.high <= high and math.isfinite(interval.high):
        return Verdict.HELD
    return Verdict.NOT_HELD if interval.high < low or interval.low > high else Verdict.NOT_DECIDED


def all_of(verdicts: Sequence[Verdict]) -> Verdict:
    """Return held if all are, not held if one is not; not decided without any."""
    if Verdict.NOT_HELD in verdicts:
        return Verdict.NOT_HELD
    decided = verdicts and all(verdict is Verdict.HELD for verdict in verdicts)
    return Verdict.HELD if decided else Verdict.NOT_DECIDED
