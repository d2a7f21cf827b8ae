"""Arrows of shear in both views: the traction on pressed taxels, merged where they are close, with one scale in pixels.

An arrow of ``ARROW_PX`` is half the maximum of the pressure scale, so that arrows and colours adapt together. Taxels of
a patch in the same cell of the map, ``ARROW_PX`` wide in the view, share an arrow: the mean traction of their area, at
the centre of it. Views find the arrows; ``draw_arrows`` paints them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainter, QPainterPath

from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.reading_units import THIN, ReadingUnits
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.painting import RIM, WHITE, make_pen, polygon

ARROW_PX = 24.0
"""Length of an arrow at half the maximum of the pressure scale, and side of a cell within which arrows merge."""
_SHORTEST_PX = 4.0
"""Length below which no arrow is drawn: noise, and no direction can be seen."""
_HEAD = 6.0
_HALF_HEAD = 3.4
_HALF_SHAFT = 0.9
"""Length and half width of an arrow's head, and half width of its shaft [px]."""


def full_arrow(scale: PressureScale) -> float:
    """Return the traction of an arrow of ``ARROW_PX`` [Pa]."""
    return 1e3 * scale.maximum / 2


def sheared_taxels(frame: Frame) -> IntArray:
    """Return the taxels (k,) that are pressed and have a traction; none without shear."""
    if frame.shear is None:
        return np.zeros(0, np.int64)
    return np.flatnonzero((frame.pressures >= TOUCH_THRESHOLD) & (np.abs(frame.shear).max(axis=1) > 0))


@dataclass(frozen=True, eq=False)
class TaxelGroups:
    """Taxels that share an arrow.

    Attributes:
        group: (k,) number of each taxel's arrow.
        areas: (k,) area of each taxel [m²].
    """

    group: IntArray
    areas: FloatArray

    @classmethod
    def of(cls, places: FloatArray, patches: IntArray, areas: FloatArray, cells: FloatArray) -> TaxelGroups:
        """Group taxels by cells of the map.

        Args:
            places: (k, 2) places on the map [m].
            patches: (k,) patch of each taxel; those of different patches are never grouped.
            areas: (k,) area of each taxel [m²].
            cells: (k,) side of its cell [m], the same for all taxels of a patch.
        """
        keys = np.column_stack([patches, np.floor(places / cells[:, None])])
        group = np.unique(keys, axis=0, return_inverse=True)[1]
        return cls(np.asarray(group).ravel(), areas)

    def means(self, values: FloatArray) -> FloatArray:
        """Return the means (groups, d) of values (k, d), weighted by area."""
        totals = np.bincount(self.group, self.areas)
        sums = [np.bincount(self.group, self.areas * column) for column in values.T]
        return np.stack(sums, axis=1) / totals[:, None]


def arrow_ends(places: FloatArray, steps: FloatArray) -> FloatArray:
    """Return tail and tip (k, 2, 2) [px] of the arrows that are long enough.

    Args:
        places: (k, 2) centres [px].
        steps: (k, 2) from tail to tip [px].
    """
    long_enough = np.linalg.norm(steps, axis=1) >= _SHORTEST_PX
    half = 0.5 * steps[long_enough]
    return np.stack([places[long_enough] - half, places[long_enough] + half], axis=1)


def draw_arrows(painter: QPainter, ends: FloatArray) -> None:
    """Draw arrows with these tails and tips (k, 2, 2) [px], white with a dark rim: visible on touch of any colour."""
    if not len(ends):
        return
    step = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(step, axis=1)[:, None]
    along = step / length
    aside = along[:, ::-1] * [-1.0, 1.0]
    size = np.minimum(1.0, length / (2 * _HEAD))  # the head of a short arrow is half of it
    neck = ends[:, 1] - size * _HEAD * along
    shaft = size * _HALF_SHAFT * aside
    head = size * _HALF_HEAD * aside
    tail = ends[:, 0]
    outline = np.stack(
        [tail - shaft, neck - shaft, neck - head, ends[:, 1], neck + head, neck + shaft, tail + shaft], 1
    )
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.WindingFill)
    for corners in outline:
        path.addPolygon(polygon(corners))
        path.closeSubpath()
    painter.setPen(make_pen(RIM, 2.4, join=Qt.PenJoinStyle.RoundJoin))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPath(path)
    painter.fillPath(path, WHITE)


def shear_legend(scale: PressureScale, units: ReadingUnits) -> MarkLegend:
    """Make the legend of the arrows: one of ``ARROW_PX`` and its traction."""
    text = f"{1e-3 * full_arrow(scale):g}{THIN}{units.unit} of shear"
    return MarkLegend(((partial(_draw_key, ARROW_PX), text),), ARROW_PX)


def _draw_key(length: float, painter: QPainter, middle: QPointF, theme: Theme) -> None:
    half = np.array([length / 2, 0.0])
    centre = np.array(middle.toTuple())
    draw_arrows(painter, np.stack([centre - half, centre + half])[None])
