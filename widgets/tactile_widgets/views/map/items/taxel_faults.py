"""Marks of faulty taxels on the map, at every zoom, and their legend with one line for each kind of fault.

Dead taxels are crossed out, stuck ones boxed, saturated ones hatched; blind ones have a hatched circle.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import STROKES, Fault, FaultLegend
from tactile_widgets.views.map.items.map_items import MapItem, ZOrder, cosmetic_pen, to_lines
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.painting import RIM, WHITE, make_pen

FAULT_COLOURS = {
    Fault.BLIND: (WHITE, RIM),
    Fault.DEAD: (WHITE, RIM),
    Fault.STUCK: (WHITE, RIM),
    Fault.SATURATED: (RIM, WHITE),
}
"""Rim and ink of each mark, lowest first: saturated taxels are deep red, the others light."""
_SMALLEST = 2.5
_LARGEST = 7.0
"""Half the size of a mark [px]."""
_WIDTHS = {False: (3.0, 1.4), True: (2.2, 1.1)}
"""Widths of rim and ink [px] by whether the mark is a hatched circle."""
_BLIND_SHARE = 0.5
_SMALLEST_BLIND = 5.5
"""Radius of a blind taxel's circle as a fraction of the pitch, so that it reaches the next taxel; and minimum [px]."""
_GLYPH = 4.0
"""Half the size of a mark in the legend [px]."""


class FaultsItem(MapItem):
    """Marks on single taxels.

    Attributes:
        faults: (taxels,) for each kind of fault, whether a taxel has it.
    """

    def __init__(self) -> None:
        super().__init__(ZOrder.FAULTS)
        self._places: FloatArray = np.zeros((0, 2))
        self._drawn: BoolArray = np.zeros(0, bool)
        self._pitch = 0.0
        self.faults: Mapping[Fault, BoolArray] = {}

    def place(self, shapes: MapShapes) -> None:
        """Move the marks to the taxels' locations on the map."""
        self._places = shapes.taxels
        self._pitch = shapes.pitch
        self._drawn = shapes.on_shown()
        self.set_bounds(shapes.taxels)

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pitch = self._pitch * pixels_per_unit
        small = min(max(0.3 * pitch, _SMALLEST), _LARGEST)
        for fault, inks in FAULT_COLOURS.items():
            if fault not in self.faults:
                continue
            places = self._places[self.faults[fault] & self._drawn]
            if len(places):
                half = max(_BLIND_SHARE * pitch, _SMALLEST_BLIND) if fault is Fault.BLIND else small
                strokes = STROKES[fault] * half / pixels_per_unit
                lines = to_lines((places[:, None, None] + strokes).reshape(-1, 2, 2))
                for ink, width in zip(inks, _WIDTHS[fault is Fault.BLIND], strict=True):
                    painter.setPen(cosmetic_pen(painter, ink, width))
                    painter.drawLines(lines)


def fault_marks_legend(entries: FaultLegend) -> MarkLegend:
    """Make the legend of faults; ``entries`` are at least one."""
    return MarkLegend(tuple((partial(_draw_glyph, fault), text) for fault, text in entries), 2 * _GLYPH)


def _draw_glyph(fault: Fault, painter: QPainter, middle: QPointF, theme: Theme) -> None:
    painter.setPen(make_pen(theme.text, _WIDTHS[fault is Fault.BLIND][1]))
    painter.drawLines(to_lines(STROKES[fault] * _GLYPH + middle.toTuple()))
