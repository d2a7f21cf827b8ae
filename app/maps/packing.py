"""Charts arranged on one map as they sit on the body: from the base outwards, left limbs left and right limbs right.

Rows are read like text. In the middle of a row are the charts that have no twin, from left to right; the twins of a
pair (``l_hand`` and ``r_hand``) lie at the same distance left and right of them, outer ones farther out. Charts are
neither turned nor mirrored, so each stays upright, its far end up, and seen from outside.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from app.arrays import FloatArray
from app.errors import MapError
from app.maps.chart import Chart
from app.maps.layout import MapLayout, Placement

ASPECT = 1.15
"""Wanted width over height of the whole map."""
MARGIN = 0.09
"""Free space around a chart, as a share of the median chart size."""
_TRIED = 12
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}
_OPPOSITE = {"left": "right", "right": "left"}

Unit = tuple[int, ...]
"""One chart, or the left and the right chart of a pair."""


def pack(charts: Sequence[Chart], *, links: Sequence[str] | None = None) -> MapLayout:
    """Place charts in rows, none overlapping, in the body's order.

    All ways to break the order into rows are tried for up to twelve charts or pairs; the one closest to the wanted
    shape wins. The charts' boxes are kept apart, and so are the charts.

    Args:
        charts: In the skin's order, each with its box's first corner at the origin.
        links: Name of each chart's link or patch, to find left and right; without, no chart has a twin.

    Raises:
        MapError: Not one name for each chart.
    """
    if links is not None and len(links) != len(charts):
        raise MapError("each chart needs the name of its link", value=f"{len(links)} names for {len(charts)} charts")
    if not charts:
        return MapLayout(())
    sizes = np.array([np.ptp(chart.plane, axis=0) for chart in charts])
    margin = MARGIN * float(np.median(sizes.max(axis=1)))
    units = pair_up(links) if links is not None else [(k,) for k in range(len(charts))]
    tried = (_rows(sizes, [units[a:b] for a, b in rows], margin) for rows in _breaks(len(units)))
    corners = min(tried, key=lambda corners: _misfit(corners, sizes))
    corners = corners - corners.min(axis=0)
    return MapLayout(tuple(Placement(offset=(float(x), float(y))) for x, y in corners))


def pair_up(links: Sequence[str]) -> list[Unit]:
    """Charts and (left, right) pairs of charts in the body's order; a pair comes where its first chart does.

    Two names are a pair if one says left (``l``, ``left``) and the other right in the same place, and they are alike
    otherwise; of several patches on such a link the first goes with the first, and so on.
    """
    waiting: dict[tuple[tuple[str, ...], str], list[int]] = {}
    twin: dict[int, int] = {}
    named = [_side(name) for name in links]
    for number, (rest, side) in enumerate(named):
        others = waiting.get((rest, _OPPOSITE.get(side, "")))
        if others:
            other = others.pop(0)
            twin[number], twin[other] = other, number
        elif side:
            waiting.setdefault((rest, side), []).append(number)
    firsts = [k for k in range(len(links)) if twin.get(k, k) >= k]
    pairs = {k: (k, twin[k]) if named[k][1] == "left" else (twin[k], k) for k in firsts if k in twin}
    return [pairs.get(k, (k,)) for k in firsts]


def _side(name: str) -> tuple[tuple[str, ...], str]:
    """The words of a name without that for its side, and the side; empty if there is none, or more than one."""
    words = [word.lower() for word in _WORDS.findall(name)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    if len(sides) != 1:
        return tuple(words), ""
    return tuple("" if word in _SIDES else word for word in words), sides[0]


def _breaks(count: int) -> list[list[tuple[int, int]]]:
    """Ways to break units into rows [a, b): every one for few units, rows of equal length for many."""
    if count > _TRIED:
        starts = [list(range(0, count, step)) for step in range(1, count + 1)]
    else:
        starts = [[0, *(k for k in range(1, count) if bits >> (k - 1) & 1)] for bits in range(2 ** (count - 1))]
    return [list(pairwise([*row, count])) for row in starts]


def _rows(sizes: FloatArray, rows: Sequence[Sequence[Unit]], margin: float) -> FloatArray:
    """(n, 2) lower-left corners, rows from the top, all centred on one line."""
    corners, top = np.zeros_like(sizes), 0.0
    for row in rows:
        own = [number for unit in row for number in unit]
        height = sizes[own, 1].max()
        for number, middle in _along_row(sizes[:, 0], row, margin).items():
            corners[number] = middle - 0.5 * sizes[number, 0], top - 0.5 * (height + sizes[number, 1])
        top -= height + margin
    return corners


def _along_row(widths: FloatArray, row: Sequence[Unit], margin: float) -> dict[int, float]:
    """Where the middle of each chart of a row is, left or right of the row's own: singles inside, pairs around them."""
    singles, middles = [unit[0] for unit in row if len(unit) == 1], {}
    inner = sum(widths[k] + margin for k in singles)
    x = -0.5 * inner
    for number in singles:
        middles[number] = x + 0.5 * (widths[number] + margin)
        x += widths[number] + margin
    reach = 0.5 * inner
    for left, right in (unit for unit in row if len(unit) == 2):
        slot = max(widths[left], widths[right]) + margin
        middles[left], middles[right] = -reach - 0.5 * slot, reach + 0.5 * slot
        reach += slot
    return middles


def _misfit(corners: FloatArray, sizes: FloatArray) -> tuple[float, float]:
    """How large a window of the wanted shape must be to show it all, then how far from that shape it is."""
    width, height = (corners + sizes).max(axis=0) - corners.min(axis=0)
    return max(width, ASPECT * height), abs(width - ASPECT * height)
