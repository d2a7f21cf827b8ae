"""Statistics over seeds: medians with bootstrap intervals, and paired differences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from app.core.arrays import FloatArray

_DRAWS, _SURE = 2000, (2.5, 97.5)


class Interval(NamedTuple):
    """A median over seeds, and the ends of its 95 % bootstrap interval."""

    middle: float
    low: float
    high: float


def bootstrap_median(values: Sequence[float]) -> Interval:
    """Median over seeds; infinite where most of them cannot.

    Args:
        values: One a seed; inf where it cannot.
    """
    known = np.asarray(values, dtype=np.float64)
    middle, drawn = _median(known[None])[0], _median(np.random.default_rng(0).choice(known, (_DRAWS, len(known))))
    # Percentiles between inf and a number are no number: the nearest value counts.
    low, high = np.percentile(drawn, _SURE, method="nearest")
    return Interval(float(middle), float(low), float(high))


def paired_ratio(values: Sequence[float], others: Sequence[float]) -> Interval:
    """The median over seeds of value over other, with common random numbers: what one seed does alike, cancels.

    Args:
        values: One a seed, above 0; inf where it cannot.
        others: Of the same seeds, finite.
    """
    return bootstrap_median([one / other for one, other in zip(values, others, strict=True)])


def _median(rows: FloatArray) -> FloatArray:
    """(k,) of each row (k, n): the upper one of two, which is one of the values."""
    return np.asarray(np.sort(rows, axis=1)[:, rows.shape[1] // 2])
