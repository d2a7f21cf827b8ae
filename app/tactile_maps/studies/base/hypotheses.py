"""Hypotheses: what theory expects of a study's rows, and whether it held.

A judgement rests on intervals, never on a middle alone: held where the whole interval is within the bounds, not held
where all of it is outside, and not decided between, or where rows are missing.
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
    """What rows say of a hypothesis."""

    HELD = "held"
    NOT_HELD = "not held"
    NOT_DECIDED = "not decided"


class Interval(NamedTuple):
    """A median over seeds, and the ends of its 95 % bootstrap interval; infinite where most of them cannot."""

    middle: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.middle:.3g} [{self.low:.3g}, {self.high:.3g}]"


_DRAWS = 2000
_SURE = (2.5, 97.5)


def bootstrap_median(values: Sequence[float]) -> Interval:
    """Median over seeds.

    Args:
        values: At least one, one a seed; inf where it cannot.
    """
    known = np.asarray(values, dtype=np.float64)
    middle = _median(known[None])[0]
    drawn = _median(np.random.default_rng(0).choice(known, (_DRAWS, len(known))))
    # Percentiles between inf and a number are no number: the nearest value counts.
    low, high = np.percentile(drawn, _SURE, method="nearest")
    return Interval(float(middle), float(low), float(high))


def paired_ratio(values: Sequence[float], others: Sequence[float]) -> Interval:
    """The median over seeds of value over other, with common random numbers: what a seed does alike to both, cancels.

    Args:
        values: One a seed, above 0; inf where it cannot.
        others: Of the same seeds, finite.
    """
    return bootstrap_median([one / other for one, other in zip(values, others, strict=True)])


def paired_difference(values: Sequence[float], others: Sequence[float]) -> Interval:
    """The median over seeds of value minus other, as ``paired_ratio``: the effect in the values' own unit."""
    return bootstrap_median([one - other for one, other in zip(values, others, strict=True)])


def _median(rows: FloatArray) -> FloatArray:
    """(k,) of each row (k, n): the upper one of two, which is one of the values."""
    return np.asarray(np.sort(rows, axis=1)[:, rows.shape[1] // 2])


@dataclass(frozen=True)
class Judgement:
    """What rows say.

    Attributes:
        verdict: Whether it held.
        figures: The figures that decide, with their intervals.
        rows: How many rows are behind it.
    """

    verdict: Verdict
    figures: str
    rows: int


@dataclass(frozen=True)
class Hypothesis:
    """What theory expects.

    Attributes:
        name: ``H1`` to ``H8``.
        statement: What is expected, with its numbers.
        judge: Of a study's rows; those with a ``problem`` are left out before.
    """

    name: str
    statement: str
    judge: Callable[[Sequence[Row]], Judgement]


def within(interval: Interval, low: float, high: float) -> Verdict:
    """Whether a figure lies within bounds.

    Args:
        interval: Of the figure.
        low: The lower bound; may be infinite.
        high: The upper one; likewise.
    """
    if low <= interval.low and interval.high <= high and math.isfinite(interval.high):
        return Verdict.HELD
    return Verdict.NOT_HELD if interval.high < low or interval.low > high else Verdict.NOT_DECIDED


def all_of(verdicts: Sequence[Verdict]) -> Verdict:
    """Held if all are, not held if one is not; not decided without any."""
    if Verdict.NOT_HELD in verdicts:
        return Verdict.NOT_HELD
    decided = verdicts and all(verdict is Verdict.HELD for verdict in verdicts)
    return Verdict.HELD if decided else Verdict.NOT_DECIDED
