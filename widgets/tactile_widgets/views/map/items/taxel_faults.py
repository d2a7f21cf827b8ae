"""Marks of faults on taxels, at every zoom: dead are crossed out, stuck boxed, saturated hatched, blind hatched round.

The graphics item, and the legend: as many lines as there are kinds of faults, none where there are none.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.overlays.taxel_faults import STROKES, Fault, FaultLegend
from tactile_widgets.views.map.items.background import paint_legend_box
from tactile_widgets.views.map.items.map_items import ZOrder, cosmetic_pen, padded_bounds, to_lines
from tactile_widgets.views.map.items.map_shapes import MapShapes

_DARK = QColor(29, 33, 38)
_LIGHT = QColor(255, 255, 255)
FAULT_COLOURS = {
    Fault.BLIND: (_LIGHT, _DARK),
    Fault.DEAD: (_LIGHT, _DARK),
    Fault.STUCK: (_LIGHT, _DARK),
    Fault.SATURATED: (_DARK, _LIGHT),
}
"""Rim and ink of each mark, the lowest first: saturated taxels are deep red, the others light."""
_SMALLEST = 2.5
_LARGEST = 7.0
"""Half a mark [px]."""
_WIDTHS = {False: (3.0, 1.4), True: (2.2, 1.1)}
"""Of rim and ink [px], of a small mark and of a hatched circle."""
_BLIND_SHARE = 0.5
_SMALLEST_BLIND = 5.5
"""Radius of a blind taxel's circle, as a share of the taxels' pitch, and the smallest [px]: it reaches the next one."""


class FaultsItem(QGraphicsItem):
    """Marks on single taxels. Mutable: ``place`` after an edit, ``mark`` with each frame."""

    def __init__(self) -> None:
        super().__init__()
        self._places: FloatArray = np.zeros((0, 2))
        self._drawn: BoolArray = np.zeros(0, bool)
        self._pitch = 0.0
        self._faults: Mapping[Fault, BoolArray] = {}
        self._bounds = QRectF()
        self.setZValue(ZOrder.FAULTS)

    def place(self, shapes: MapShapes) -> None:
        """Put them where the map has its taxels now."""
        self.prepareGeometryChange()
        self._places = shapes.taxels
        self._pitch = shapes.pitch
        self._drawn = shapes.on_shown()
        self._bounds = padded_bounds(shapes.taxels)

    def mark(self, faults: Mapping[Fault, BoolArray]) -> None:
        """Mark these (taxels,) each."""
        self._faults = faults

    def boundingRect(self) -> QRectF:
        """Qt: around all taxels."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the marks."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pixels_per_unit = option.levelOfDetailFromTransform(painter.worldTransform())
        pitch = self._pitch * pixels_per_unit
        small = min(max(0.3 * pitch, _SMALLEST), _LARGEST)
        for fault, inks in FAULT_COLOURS.items():
            if fault not in self._faults:
                continue
            places = self._places[self._faults[fault] & self._drawn]
            if len(places):
                half = max(_BLIND_SHARE * pitch, _SMALLEST_BLIND) if fault is Fault.BLIND else small
                strokes = to_lines(_strokes_at(places, STROKES[fault] * half / pixels_per_unit))
                for ink, width in zip(inks, _WIDTHS[fault is Fault.BLIND], strict=True):
                    painter.setPen(cosmetic_pen(painter, ink, width))
                    painter.drawLines(strokes)


def _strokes_at(places: FloatArray, strokes: FloatArray) -> FloatArray:
    """(k s, 2, 2) the strokes (s, 2, 2) at each place (k, 2)."""
    return (places[:, None, None] + strokes).reshape(-1, 2, 2)


_PAD = 8.0
_GLYPH = 4.0
_INDENT = 2 * _GLYPH + 8


def fault_legend_size(keys: FaultLegend, font: QFont) -> QSizeF:
    """What they take in ``font``, the caption's [px]; at least one."""
    metrics = QFontMetricsF(font)
    width = max(metrics.horizontalAdvance(text) for _, text in keys) + _INDENT
    return QSizeF(width + 2 * _PAD, (metrics.height() + 2) * len(keys) + 2 * _PAD - 2)


def paint_fault_legend(painter: QPainter, keys: FaultLegend, box: QRectF, font: QFont, theme: Theme) -> None:
    """Draw them in ``box``, of their ``fault_legend_size``; ``font`` is the caption's."""
    line = QFontMetricsF(font).height() + 2
    paint_legend_box(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, box.width() - 2 * _PAD, line)
    for fault, text in keys:
        width = _WIDTHS[fault is Fault.BLIND][1]
        painter.setPen(QPen(QColor(theme.text), width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        middle = (row.left() + _GLYPH, row.center().y())
        painter.drawLines(to_lines(STROKES[fault] * _GLYPH + middle))
        painter.setPen(QColor(theme.quiet))
        painter.drawText(
            row.adjusted(_INDENT, 0, 0, 0), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text
        )
        row.translate(0, line)
