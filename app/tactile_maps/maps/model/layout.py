"""Layout of the patches on the map: one placement per patch, and their packing.

Charts are packed in the order of the body: from the base outwards, left limbs left and right limbs right. Rows are read
like text. The middle of a row has the charts without a counterpart, from left to right; the charts of a pair
(``l_hand`` and ``r_hand``) are at equal distances left and right of them, outer pairs farther out. Charts are neither
rotated nor mirrored, so each stays upright, its far end up, and seen from outside.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.flattening.chart import Chart
from tactile_maps.geometry.surface.plane import cross

FARTHEST_OFFSET = 1e6
"""Largest distance of a patch from the map's origin [m]."""
SMALLEST_SCALE = 0.1
LARGEST_SCALE = 10.0
"""Smallest and largest scale of a patch relative to its true size."""


@dataclass(frozen=True)
class Placement:
    """Placement of a chart on the map: mirrored (if so), then scaled, rotated and moved.

    Angles are preserved, and lengths at scale 1, which everything automatic uses. Only a user enlarges a patch, to see
    a small one better; ``distortion`` then includes the enlargement.

    Attributes:
        angle: Counter-clockwise [rad].
        offset: (x, y) [m].
        mirrored: Whether x is negated first.
        scale: Ratio of lengths on the map to lengths on the chart.
    """

    angle: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False
    scale: float = 1.0

    def apply(self, plane: FloatArray) -> FloatArray:
        """Return map coordinates (k, 2) of chart coordinates (k, 2) [m]."""
        return (plane * self._stretch) @ self._turn + np.asarray(self.offset)

    def back(self, points: FloatArray) -> FloatArray:
        """Return chart coordinates (k, 2) of map coordinates (k, 2) [m]."""
        return ((points - np.asarray(self.offset)) @ self._turn.T) / self._stretch

    def after(self, first: Placement) -> Placement:
        """Return the composition: ``first``, then this placement."""
        x, y = self.apply(np.array([first.offset]))[0]
        angle = self.angle + (-first.angle if self.mirrored else first.angle)
        mirrored = self.mirrored ^ first.mirrored
        scale = self.scale * first.scale
        return Placement(math.remainder(angle, math.tau), (float(x), float(y)), mirrored, scale)

    @property
    def _stretch(self) -> FloatArray:
        return np.array([-self.scale if self.mirrored else self.scale, self.scale])

    @property
    def _turn(self) -> FloatArray:
        cosine = np.cos(self.angle)
        sine = np.sin(self.angle)
        return np.array([[cosine, sine], [-sine, cosine]])


def fit_placement(plane: FloatArray, points: FloatArray, *, rigid: bool = False) -> Placement:
    """Return the placement of ``plane`` closest to ``points`` by least squares (orthogonal Procrustes analysis).

    Closed form in the plane, where the best rotation is an angle (Schönemann 1966; Umeyama 1991).

    Args:
        plane: (k, 2) chart coordinates, at least one [m].
        points: (k, 2) target of each [m].
        rigid: Only rotate and move. By default also scale, and mirror if that is closer; the scale is 0 if all of
            ``plane`` is one point.
    """
    goals = points - points.mean(axis=0)
    tried = []
    for mirrored in (False,) if rigid else (False, True):
        flat = (plane - plane.mean(axis=0)) * [-1.0 if mirrored else 1.0, 1.0]
        along = float((flat * goals).sum())
        across = float(cross(flat, goals).sum())
        tried.append((np.hypot(along, across), np.arctan2(across, along), mirrored))
    kept, angle, mirrored = max(tried)
    size = float(((plane - plane.mean(axis=0)) ** 2).sum())
    scale = 1.0 if rigid else float(kept / size) if size > 0 else 0.0
    turn = Placement(float(angle), mirrored=mirrored, scale=scale)
    x, y = points.mean(axis=0) - turn.apply(plane).mean(axis=0)
    return replace(turn, offset=(float(x), float(y)))


@dataclass(frozen=True)
class MapLayout:
    """All placements, in the order of the skin's patches."""

    placements: tuple[Placement, ...]

    def __post_init__(self) -> None:
        numbers = [value for p in self.placements for value in (p.angle, *p.offset, p.scale)]
        if not np.isfinite(numbers).all():
            raise MapError("a placement is not finite", value=numbers)
        farthest = max((abs(x) for p in self.placements for x in p.offset), default=0.0)
        if farthest >= FARTHEST_OFFSET:
            raise MapError(
                "a patch would be too far from the origin", value=f"{farthest:g} m", remedy="Bring it nearer"
            )
        for scale in (p.scale for p in self.placements):
            if not SMALLEST_SCALE <= scale <= LARGEST_SCALE:
                most = f"Between {SMALLEST_SCALE:g} and {LARGEST_SCALE:g} times its true size is possible"
                raise MapError("a patch would be drawn too small or too large", value=f"{scale:g}", remedy=most)


PACKING_ASPECT = 0.85
"""Target aspect ratio (width over height) of the map: that of the window's map pane, next to the body's."""
PACKING_MARGIN = 0.09
"""Free space around a chart, as a share of the median chart size."""
_TRIED = 12
_WORDS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+")
_SIDES = {"l": "left", "left": "left", "r": "right", "right": "right"}
_OPPOSITE = {"left": "right", "right": "left"}

Unit = tuple[int, ...]
"""A chart, or the left and right chart of a pair."""


def pack_charts(charts: Sequence[Chart], *, links: Sequence[str] | None = None) -> MapLayout:
    """Arrange charts in rows without overlap, in the body's order.

    All ways to break the order into rows are tried for up to twelve charts or pairs; the one closest to the target
    aspect ratio is chosen. The boxes of the charts do not overlap.

    Args:
        charts: In the skin's order, each with the lower-left corner of its box at the origin.
        links: Name of each chart's link or patch, to find left and right; without names there are no pairs.

    Raises:
        MapError: The number of names differs from the number of charts.
    """
    if links is not None and len(links) != len(charts):
        raise MapError("each chart needs the name of its link", value=f"{len(links)} names for {len(charts)} charts")
    if not charts:
        return MapLayout(())
    sizes = np.array([np.ptp(chart.plane, axis=0) for chart in charts])
    margin = PACKING_MARGIN * float(np.median(sizes.max(axis=1)))
    units = pair_up(links) if links is not None else [(k,) for k in range(len(charts))]
    tried = (_rows(sizes, [units[a:b] for a, b in rows], margin) for rows in _breaks(len(units)))
    corners = min(tried, key=lambda corners: _misfit(corners, sizes))
    corners = corners - corners.min(axis=0)
    return MapLayout(tuple(Placement(offset=(float(x), float(y))) for x, y in corners))


def pair_up(links: Sequence[str]) -> list[Unit]:
    """Return charts and (left, right) pairs of charts in the body's order; a pair has the position of its first chart.

    Two names form a pair if one contains left (``l``, ``left``) and the other right in the same place and they are
    equal apart from that. Several patches on such a link are paired in order.
    """
    waiting: dict[tuple[tuple[str, ...], str], list[int]] = {}
    twin: dict[int, int] = {}
    named = [_side(name) for name in links]
    for number, (rest, side) in enumerate(named):
        others = waiting.get((rest, _OPPOSITE.get(side, "")))
        if others:
            other = others.pop(0)
            twin[number] = other
            twin[other] = number
        elif side:
            waiting.setdefault((rest, side), []).append(number)
    firsts = [k for k in range(len(links)) if twin.get(k, k) >= k]
    pairs = {k: (k, twin[k]) if named[k][1] == "left" else (twin[k], k) for k in firsts if k in twin}
    return [pairs.get(k, (k,)) for k in firsts]


def _side(name: str) -> tuple[tuple[str, ...], str]:
    """Return the words of a name without the side, and the side; empty if there is none or more than one."""
    words = [word.lower() for word in _WORDS.findall(name)]
    sides = [_SIDES[word] for word in words if word in _SIDES]
    if len(sides) != 1:
        return tuple(words), ""
    return tuple("" if word in _SIDES else word for word in words), sides[0]


def _breaks(count: int) -> list[list[tuple[int, int]]]:
    """Return ways to break units into rows [a, b): all for few units, rows of equal length for many."""
    if count > _TRIED:
        starts = [list(range(0, count, step)) for step in range(1, count + 1)]
    else:
        starts = [[0, *(k for k in range(1, count) if bits >> (k - 1) & 1)] for bits in range(2 ** (count - 1))]
    return [list(pairwise([*row, count])) for row in starts]


def _rows(sizes: FloatArray, rows: Sequence[Sequence[Unit]], margin: float) -> FloatArray:
    """Return lower-left corners (n, 2), rows from the top, all centred on one line."""
    corners = np.zeros_like(sizes)
    top = 0.0
    for row in rows:
        own = [number for unit in row for number in unit]
        height = sizes[own, 1].max()
        for number, middle in _along_row(sizes[:, 0], row, margin).items():
            corners[number] = middle - 0.5 * sizes[number, 0], top - 0.5 * (height + sizes[number, 1])
        top -= height + margin
    return corners


def _along_row(widths: FloatArray, row: Sequence[Unit], margin: float) -> dict[int, float]:
    """Return the centre of each chart of a row relative to the row's: single charts inside, pairs around them."""
    singles = [unit[0] for unit in row if len(unit) == 1]
    middles = {}
    inner = sum(widths[k] + margin for k in singles)
    x = -0.5 * inner
    for number in singles:
        middles[number] = x + 0.5 * (widths[number] + margin)
        x += widths[number] + margin
    reach = 0.5 * inner
    for left, right in (unit for unit in row if len(unit) == 2):
        slot = max(widths[left], widths[right]) + margin
        middles[left] = -reach - 0.5 * slot
        middles[right] = reach + 0.5 * slot
        reach += slot
    return middles


def _misfit(corners: FloatArray, sizes: FloatArray) -> tuple[float, float]:
    """Return the size of a window of the target aspect ratio that contains everything, then the deviation from it."""
    width, height = (corners + sizes).max(axis=0) - corners.min(axis=0)
    return max(width, PACKING_ASPECT * height), abs(width - PACKING_ASPECT * height)
