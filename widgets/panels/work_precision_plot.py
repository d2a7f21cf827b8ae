"""A work-precision diagram: error against milliseconds, both logarithmic; a click on a point chooses its setting."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.arrays import FloatArray
from app.experiments.work_precision import Curve, Diagram, Point, Setting, best_for_the_time, said
from widgets.colours import Theme
from widgets.panels.curve_marks import FULL, RING, SMALL, CurveLegend, ink, symbol
from widgets.panels.log_plot import LogCanvas, number

REACH = 12.0
"""A point so near is meant [px]."""
_MARGIN, _LEAST_SPAN = 0.09, 0.3


class WorkPrecisionPlot(QWidget):
    """One diagram with its legend and a line that names the point under the hand. Arrows go along points, Enter uses.

    Args:
        theme: Its colours.
    """

    chosen = Signal(object)
    """The Setting of a point that was clicked."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._diagram: Diagram | None = None
        self._present: Setting | None = None
        self._held: Point | None = None
        self._floor = 0.0
        self._detail = QLabel(self)
        self._detail.setProperty("role", "caption")
        self._detail.setObjectName("work-precision-detail")
        self._detail.setWordWrap(True)
        self._detail.setMinimumHeight(2 * self._detail.fontMetrics().height())
        self._detail.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.canvas = LogCanvas(self)
        self.canvas.hovered.connect(self._on_hovered)
        self.canvas.clicked.connect(self._on_clicked)
        self.canvas.key_pressed.connect(self._on_key_pressed)
        self._legend = CurveLegend(self)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(4)
        column.addWidget(self.canvas, 1)
        column.addWidget(self._detail)
        column.addWidget(self._legend)
        self._cursor = pg.ScatterPlotItem(size=RING - 4, brush=None, antialias=True)
        self._cursor.setZValue(20)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self.canvas.dress(theme)
        self._cursor.setPen(pg.mkPen(QColor(theme.text), width=1.5))
        self._draw()

    def show_diagram(self, diagram: Diagram, present: Setting | None = None) -> None:
        """Draw a diagram and ring the point of the ``present`` setting, if it has one."""
        if (diagram, present) != (self._diagram, self._present):
            self._diagram, self._present = diagram, present
            self._draw()

    def places(self) -> list[tuple[Point, QPointF]]:
        """Every point and where it lies on the canvas [px]."""
        points = self._diagram.points if self._diagram else ()
        box = self.canvas.getPlotItem().getViewBox()
        scene = [box.mapViewToScene(QPointF(*map(float, at))) for at in self._logarithms(points)]
        return [(point, QPointF(self.canvas.mapFromScene(at))) for point, at in zip(points, scene, strict=True)]

    @property
    def held(self) -> Point | None:
        """The point under the hand."""
        return self._held

    def _draw(self) -> None:
        plot = self.canvas.getPlotItem()
        plot.clear()
        diagram = self._diagram
        if diagram is None:
            return
        self.canvas.name_axis("left", f"{diagram.error_name} ({diagram.unit})", self._theme)
        self.canvas.setAccessibleName(f"{diagram.title}: {diagram.error_name.lower()} against time")
        self._fit(diagram.points)
        best = best_for_the_time(diagram.points)
        if len(best) > 1:
            pen = pg.mkPen(QColor(self._theme.quiet), width=1, style=Qt.PenStyle.DashLine)
            plot.addItem(pg.PlotDataItem(self._logarithms(best), pen=pen, antialias=True))
        for curve in diagram.curves:
            self._draw_curve(curve)
        self._draw_present(diagram)
        entries: list[tuple[int | str, str]] = [(curve.number, said(curve.method)) for curve in diagram.curves]
        ring = [("ring", "Present setting")] if self._point_of(self._present) else []
        self._legend.show_entries([*entries, ("best", "Best for the time"), *ring], self._theme)
        plot.addItem(self._cursor)
        self._hold(self._held if self._held in diagram.points else None)

    def _draw_curve(self, curve: Curve) -> None:
        plot, colour = self.canvas.getPlotItem(), ink(self._theme, curve.number)
        line = self._logarithms([point for point in curve.points if point.joined])
        plot.addItem(pg.PlotDataItem(line, pen=pg.mkPen(colour, width=1.5), antialias=True))
        marks = [
            self._mark(point, at, colour)
            for point, at in zip(curve.points, self._logarithms(curve.points), strict=True)
        ]
        marks.sort(key=lambda mark: mark["size"])
        scatter = pg.ScatterPlotItem(marks, symbol=symbol(curve.number), antialias=True)
        scatter.setZValue(10)
        plot.addItem(scatter)

    def _mark(self, point: Point, at: FloatArray, colour: QColor) -> dict[str, Any]:
        """Full on the line, hollow for a setting beside it, small for a round on the way."""
        ground = QColor(self._theme.panel)
        if not point.usable:
            return {"pos": at, "size": SMALL, "brush": colour, "pen": None}
        if not point.joined:
            return {"pos": at, "size": FULL - 1, "brush": ground, "pen": pg.mkPen(colour, width=1.5)}
        return {"pos": at, "size": FULL, "brush": colour, "pen": pg.mkPen(ground)}

    def _draw_present(self, diagram: Diagram) -> None:
        point = self._point_of(self._present)
        if point is None:
            return
        pen = pg.mkPen(QColor(self._theme.accent), width=2.5)
        ring = pg.ScatterPlotItem(pos=self._logarithms([point]), size=RING, brush=None, pen=pen, antialias=True)
        ring.setZValue(15)
        self.canvas.getPlotItem().addItem(ring)

    def _point_of(self, setting: Setting | None) -> Point | None:
        points = self._diagram.points if self._diagram else ()
        return next((point for point in points if point.usable and point.setting == setting), None)

    def _fit(self, points: Sequence[Point]) -> None:
        """Make room for all points; those without error lie below the smallest that has some, and are labelled 0."""
        least = self._diagram.least if self._diagram else 0.0
        errors = [point.error for point in points if point.error > least]
        self._floor = math.log10(min(errors) / 2 if errors else least)
        flat = any(point.error <= least for point in points)
        self.canvas.left_axis.zero = self._floor if flat else None
        places = self._logarithms(points) if points else np.zeros((1, 2))
        low, high = places.min(axis=0), places.max(axis=0)
        middle, half = 0.5 * (low + high), (0.5 + _MARGIN) * np.maximum(high - low, _LEAST_SPAN)
        x, y = np.stack([middle - half, middle + half], axis=1)
        self.canvas.getPlotItem().getViewBox().setRange(xRange=x, yRange=y, padding=0)

    def _logarithms(self, points: Sequence[Point]) -> FloatArray:
        """(k, 2) where points lie in the diagram."""
        least = self._diagram.least if self._diagram else 0.0
        rows = [
            (math.log10(point.milliseconds), math.log10(point.error) if point.error > least else self._floor)
            for point in points
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, 2)

    def _hold(self, point: Point | None) -> None:
        """Mark and name a point; None names the present setting."""
        self._held = point
        self._cursor.setData(pos=self._logarithms([point] if point else []))
        self._detail.setText(self._named(point))
        self.canvas.setAccessibleDescription(self._detail.text())
        usable = point is not None and point.usable
        self.canvas.setCursor(Qt.CursorShape.PointingHandCursor if usable else Qt.CursorShape.ArrowCursor)

    def _named(self, point: Point | None) -> str:
        if self._diagram is None:
            return ""
        if point is None:
            present = self._point_of(self._present)
            return f"Present: {_told(present, self._diagram.unit)}" if present else "Click a point to use its setting."
        told = _told(point, self._diagram.unit)
        if not point.usable:
            return f"{told}. On the way, not a setting."
        if point.setting == self._present:
            return f"{told}. In use."
        return f"{told}. Click or Enter to use it." + (f" {point.note}." if point.note else "")

    def _nearest(self, at: QPointF) -> Point | None:
        """The point meant by the pointer at ``at``; a setting goes before a round on the way."""
        away = [(math.hypot(place.x() - at.x(), place.y() - at.y()), point) for point, place in self.places()]
        near = [(not point.usable, distance, point) for distance, point in away if distance <= REACH]
        return min(near, key=lambda entry: entry[:2])[2] if near else None

    def _on_hovered(self, at: QPointF | None) -> None:
        self._hold(self._nearest(at) if at is not None else None)

    def _on_clicked(self, at: QPointF) -> None:
        self._hold(self._nearest(at))
        self._use()

    def _use(self) -> None:
        if self._held is not None and self._held.usable and self._held.setting != self._present:
            self.chosen.emit(self._held.setting)

    def _on_key_pressed(self, key: int) -> None:
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._use()
        elif key == Qt.Key.Key_Escape:
            self._hold(None)
        else:
            self._hold(self._beside(key))

    def _beside(self, key: int) -> Point | None:
        """The next setting to the right (slower), left, up (more error) or down, from the held or present one."""
        points = [point for point in (self._diagram.points if self._diagram else ()) if point.usable]
        start = self._held or self._point_of(self._present)
        if start not in points:
            return best_for_the_time(points)[0] if points else None
        if not self._held:
            return start
        measure = _MEASURES[Qt.Key(key)]
        further = [point for point in points if measure(point) > measure(start)]
        return min(further, key=measure) if further else start


_MEASURES: dict[Qt.Key, Callable[[Point], tuple[float, float]]] = {
    Qt.Key.Key_Right: lambda point: (point.milliseconds, point.error),
    Qt.Key.Key_Left: lambda point: (-point.milliseconds, -point.error),
    Qt.Key.Key_Up: lambda point: (point.error, point.milliseconds),
    Qt.Key.Key_Down: lambda point: (-point.error, -point.milliseconds),
}


def _told(point: Point, unit: str) -> str:
    gap = "" if unit == "°" else "\u202f"
    name = f"{said(point.setting.method)}{', ' if point.name else ''}{point.name}"
    return f"{name}: {number(point.error)}{gap}{unit}, {number(point.milliseconds)}\u202fms"
