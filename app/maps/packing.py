"""Charts arranged on one map: in the skin's order, from the base outwards, in rows read like text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.maps.chart import Chart
from app.maps.layout import MapLayout, Placement

ASPECT = 1.15
"""Wanted width over height of the whole map."""
MARGIN = 0.09
"""Free space around a chart, as a share of the median chart size."""


def pack(charts: Sequence[Chart]) -> MapLayout:
    """Place charts in rows, none overlapping, the body's order kept from left to right and top to bottom.

    All ways to break the order into rows are tried for up to twelve charts; the one closest to the wanted shape wins.

    Args:
        charts: In the skin's order, each with its box's first corner at the origin.
    """
    if not charts:
        return MapLayout(())
    sizes = np.array([np.ptp(chart.plane, axis=0) for chart in charts])
    margin = MARGIN * float(np.median(sizes.max(axis=1)))
    best = min((_rows(sizes, breaks, margin) for breaks in _breaks(len(charts))), key=_misfit)
    low = best.min(axis=0)
    return MapLayout(tuple(Placement(offset=(float(x), float(y))) for x, y in best[: len(charts)] - low))


def _breaks(count: int) -> list[tuple[int, ...]]:
    """Where rows may start; every choice for few charts, rows of equal length for many."""
    if count > 12:
        return [tuple(range(step, count, step)) for step in range(1, count + 1)]
    return [tuple(k + 1 for k in range(count - 1) if bits >> k & 1) for bits in range(2 ** (count - 1))]


def _rows(sizes: np.ndarray, breaks: tuple[int, ...], margin: float) -> np.ndarray:
    """(n + 1, 2) lower-left corners, rows from the top; the last row of the result is the width and height."""
    corners, top, widest = np.zeros((len(sizes) + 1, 2)), 0.0, 0.0
    rows = np.split(np.arange(len(sizes)), list(breaks))
    widths = [sizes[row, 0].sum() + margin * (len(row) - 1) for row in rows]
    widest = max(widths)
    for row, width in zip(rows, widths, strict=True):
        height = sizes[row, 1].max()
        x = 0.5 * (widest - width)
        for i in row:
            corners[i] = x, top - height + 0.5 * (height - sizes[i, 1])
            x += sizes[i, 0] + margin
        top -= height + margin
    corners[-1] = widest, -top - margin
    return corners


def _misfit(corners: np.ndarray) -> tuple[float, float]:
    """How large a window of the wanted shape must be to show it all, then how far from that shape it is."""
    width, height = corners[-1]
    return max(width, ASPECT * height), abs(width - ASPECT * height)
