"""Where the patches lie on the map: one placement each, the only thing that arranging changes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.errors import MapError

FARTHEST = 1e6
"""No patch lies farther from the map's origin [m]."""
SMALLEST, LARGEST = 0.1, 10.0
"""A patch is drawn no smaller and no larger than so many times its true size."""


@dataclass(frozen=True)
class Placement:
    """How one chart is put on the map: mirrored (if so), then scaled, turned and moved.

    Angles stay true, and lengths at scale 1, which everything automatic uses; only a person enlarges a patch, to see a
    small one better, and ``distortion`` then counts the enlargement as what it is.

    Attributes:
        angle: Counter-clockwise [rad].
        offset: (x, y) [m].
        mirrored: Whether x is negated first.
        scale: How many times longer lengths are on the map than on the chart.
    """

    angle: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False
    scale: float = 1.0

    def apply(self, plane: FloatArray) -> FloatArray:
        """Map coordinates (k, 2) of chart coordinates (k, 2) [m]."""
        return (plane * self._stretch) @ self._turn + np.asarray(self.offset)

    def back(self, points: FloatArray) -> FloatArray:
        """Chart coordinates (k, 2) of map coordinates (k, 2) [m]."""
        return ((points - np.asarray(self.offset)) @ self._turn.T) / self._stretch

    def after(self, first: Placement) -> Placement:
        """The placement that does what ``first`` does, and then what this one does."""
        x, y = self.apply(np.array([first.offset]))[0]
        angle = self.angle + (-first.angle if self.mirrored else first.angle)
        mirrored, scale = self.mirrored ^ first.mirrored, self.scale * first.scale
        return Placement(math.remainder(angle, math.tau), (float(x), float(y)), mirrored, scale)

    @property
    def _stretch(self) -> FloatArray:
        return np.array([-self.scale if self.mirrored else self.scale, self.scale])

    @property
    def _turn(self) -> FloatArray:
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        return np.array([[cosine, sine], [-sine, cosine]])


@dataclass(frozen=True)
class MapLayout:
    """All placements, in the order of the skin's patches."""

    placements: tuple[Placement, ...]

    def __post_init__(self) -> None:
        numbers = [value for p in self.placements for value in (p.angle, *p.offset, p.scale)]
        if not np.isfinite(numbers).all():
            raise MapError("a placement is not finite", value=numbers)
        farthest = max((abs(x) for p in self.placements for x in p.offset), default=0.0)
        if farthest >= FARTHEST:
            raise MapError("a patch would lie too far out", value=f"{farthest:g} m", remedy="Bring it nearer")
        for scale in (p.scale for p in self.placements):
            if not SMALLEST <= scale <= LARGEST:
                most = f"Between {SMALLEST:g} and {LARGEST:g} times its true size is possible"
                raise MapError("a patch would be drawn too small or too large", value=f"{scale:g}", remedy=most)
