"""Taxels that do not read what touches them, marked at every zoom: dead crossed out, stuck boxed, saturated hatched."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import BoolArray, FloatArray
from widgets.map_view.map_items import cosmetic, lines, room_around
from widgets.map_view.map_shapes import MapShapes
from widgets.map_view.taxel_faults import STROKES, Fault

_DARK, _LIGHT = QColor(29, 33, 38), QColor(255, 255, 255)
INKS = {Fault.DEAD: (_LIGHT, _DARK), Fault.STUCK: (_LIGHT, _DARK), Fault.SATURATED: (_DARK, _LIGHT)}
"""Rim and ink of each mark: saturated taxels are deep red, the others light."""
_SMALLEST, _LARGEST = 2.5, 7.0
"""Half a mark [px]."""


class FaultsItem(QGraphicsItem):
    """Marks on single taxels. Mutable: ``place`` after an edit, ``mark`` with each frame."""

    def __init__(self) -> None:
        super().__init__()
        self._places: FloatArray = np.zeros((0, 2))
        self._drawn: BoolArray = np.zeros(0, bool)
        self._pitch = 0.0
        self._faults: Mapping[Fault, BoolArray] = {}
        self._bounds = QRectF()

    def place(self, shapes: MapShapes) -> None:
        """Put them where the map has its taxels now."""
        self.prepareGeometryChange()
        self._places, self._pitch, self._drawn = shapes.taxels, shapes.pitch, shapes.on_shown()
        self._bounds = room_around(shapes.taxels)

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
        half = min(max(0.3 * self._pitch * pixels_per_unit, _SMALLEST), _LARGEST)
        for fault, those in self._faults.items():
            places = self._places[those & self._drawn]
            if len(places):
                strokes = lines(_at(places, STROKES[fault] * half / pixels_per_unit))
                for ink, width in zip(INKS[fault], (3.0, 1.4), strict=True):
                    painter.setPen(cosmetic(painter, ink, width))
                    painter.drawLines(strokes)


def _at(places: FloatArray, strokes: FloatArray) -> FloatArray:
    """(k s, 2, 2) the strokes (s, 2, 2) at each place (k, 2)."""
    return (places[:, None, None] + strokes).reshape(-1, 2, 2)
