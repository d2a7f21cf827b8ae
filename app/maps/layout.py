"""Where the patches lie on the map: one rigid placement each, the only thing that arranging changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.errors import MapError


@dataclass(frozen=True)
class Placement:
    """How one chart is put on the map: mirrored (if so), then turned, then moved. Lengths stay true.

    Attributes:
        angle: Counter-clockwise [rad].
        offset: (x, y) [m].
        mirrored: Whether x is negated first.
    """

    angle: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)
    mirrored: bool = False

    def apply(self, plane: FloatArray) -> FloatArray:
        """Map coordinates (k, 2) of chart coordinates (k, 2) [m]."""
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        start = plane * [-1.0, 1.0] if self.mirrored else plane
        return start @ np.array([[cosine, sine], [-sine, cosine]]) + np.asarray(self.offset)


@dataclass(frozen=True)
class MapLayout:
    """All placements, in the order of the skin's patches."""

    placements: tuple[Placement, ...]

    def __post_init__(self) -> None:
        numbers = [value for p in self.placements for value in (p.angle, *p.offset)]
        if not np.isfinite(numbers).all():
            raise MapError("a placement is not finite", value=numbers)
