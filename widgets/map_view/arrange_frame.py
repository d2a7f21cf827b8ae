"""The frame around selected patches, as plain geometry on the map: its handles, and what pulling them means."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.editing.document import MapDocument
from app.editing.snap import STEP
from app.maps.layout import LARGEST, SMALLEST

HANDLE_PX = 9.0
"""Side of a handle as drawn."""
REACH_PX = 8.0
"""Half the side of the square in which a press means the handle."""
STEM_PX = 30.0
"""From the frame's upper side to the handle that turns."""
TURN = 4
"""Number of that handle; 0 to 3 are the corners."""


@dataclass(frozen=True, eq=False)
class ArrangeFrame:
    """A rectangle, upright until it is turned.

    Attributes:
        corners: (4, 2) counter-clockwise from the lower left [m].
    """

    corners: FloatArray

    @classmethod
    def around(cls, document: MapDocument, numbers: tuple[int, ...]) -> ArrangeFrame | None:
        """The frame around these patches; None for none."""
        if not numbers:
            return None
        lines = np.concatenate([outline(document, number) for number in numbers])
        (left, low), (right, high) = lines.min(axis=0), lines.max(axis=0)
        return cls(np.array([[left, low], [right, low], [right, high], [left, high]]))

    @property
    def middle(self) -> FloatArray:
        """(2,) [m]."""
        return np.asarray(self.corners.mean(axis=0))

    def handles(self, pixel: float) -> FloatArray:
        """(5, 2) the corners and the handle that turns [m]; ``pixel`` is the size of one [m]."""
        top, up = self.corners[2:].mean(axis=0), self.corners[3] - self.corners[0]
        length = float(np.linalg.norm(up))
        along = up / length if length > 0 else np.array([0.0, 1.0])
        return np.vstack([self.corners, top + STEM_PX * pixel * along])

    def handle_at(self, point: FloatArray, pixel: float) -> int | None:
        """The nearest handle within reach of a map point; None for none."""
        away = np.abs(self.handles(pixel) - point).max(axis=1)
        nearest = int(away.argmin())
        return nearest if away[nearest] <= REACH_PX * pixel else None

    def moved(self, by: tuple[float, float]) -> ArrangeFrame:
        """The frame moved."""
        return ArrangeFrame(self.corners + np.asarray(by))

    def scaled(self, factor: float, about: FloatArray) -> ArrangeFrame:
        """The frame scaled about a point."""
        return ArrangeFrame(about + factor * (self.corners - about))

    def turned(self, angle: float) -> ArrangeFrame:
        """The frame turned about its middle, counter-clockwise [rad]."""
        turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
        return ArrangeFrame(self.middle + (self.corners - self.middle) @ turn)

    def pulled(self, corner: int, by: FloatArray, *, from_middle: bool) -> tuple[float, FloatArray]:
        """What pulling a corner by (2,) means: how many times larger, and about which point."""
        about = self.middle if from_middle else self.corners[(corner + 2) % 4]
        arm = self.corners[corner] - about
        square = float(arm @ arm)
        return (1.0 + float(by @ arm) / square if square > 0 else 1.0), about

    def swung(self, start: FloatArray, point: FloatArray) -> float:
        """The turn [rad] of a pointer that went from ``start`` to ``point`` around the middle."""
        (x0, y0), (x1, y1) = start - self.middle, point - self.middle
        return math.remainder(math.atan2(y1, x1) - math.atan2(y0, x0), math.tau)


def outline(document: MapDocument, number: int) -> FloatArray:
    """(b, 2) a patch's border on the map [m], closed, from what its chart remembers."""
    chart = document.charts[number]
    return document.layout.placements[number].apply(chart.plane[chart.border])


def possible_scale(document: MapDocument, numbers: tuple[int, ...], factor: float) -> float:
    """The factor nearest to ``factor`` by which all these patches may be scaled."""
    scales = [document.layout.placements[number].scale for number in numbers]
    # A hair inside, so that rounding takes no patch over the edge.
    return min(max(factor, SMALLEST / min(scales) * (1 + 1e-9)), LARGEST / max(scales) * (1 - 1e-9))


def stepped_turn(document: MapDocument, numbers: tuple[int, ...], angle: float) -> float:
    """The turn nearest to ``angle`` by whole steps of 15°; a patch alone ends at a whole step from upright."""
    start = document.layout.placements[numbers[0]].angle if len(numbers) == 1 else 0.0
    return STEP * round((start + angle) / STEP) - start
