"""Work-precision diagram: error against milliseconds, both logarithmic; a click on a point applies its setting.

``LogCanvas`` is the empty logarithmic plot: axes with round numbers, pointer, clicks and arrow keys.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.study.work_precision import Curve, Diagram, Point, Setting, method_title, pareto_front
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import caption_label, column_layout
from tactile_widgets.plots.curve_legend import (
    ITERATION_MARKER_SIZE,
    LINE_STYLES,
    MARKER_SIZE,
    RING_SIZE,
    CurveLegend,
    curve_colour,
    curve_symbol,
)
from tactile_widgets.plots.traces.plot_canvas import PlotCanvas

_STEPS = ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), (1, 1.5, 2, 3, 4, 5, 6, 8), (1, 2, 3, 5), (1, 2, 5), (1, 3), (1,))
_ROOM = {"bottom": 40, "left": 22}
"""Minimum distance between two labels [px]."""
_KEYS = (
    Qt.Key.Key_Left,
    Qt.Key.Key_Right,
    Qt.Key.Key_Up,
    Qt.Key.Key_Down,
    Qt.Key.Key_Return,
    Qt.Key.Key_Enter,
    Qt.Key.Key_Escape,
)


def log_ticks(low: float, high: float, room: float) -> FloatArray:
    """Return decimal logarithms of round numbers between ``low`` and ``high``, at least ``room`` apart.

    If fewer than two round numbers fit, two other values are returned.
    """
    decades = np.arange(np.floor(low), np.ceil(high) + 1)
    for steps in _STEPS:
        ticks = np.add.outer(decades, np.log10(steps)).ravel()
        ticks = ticks[(ticks >= low) & (ticks <= high)]
        if len(ticks) < 2 or np.diff(ticks).min() >= room:
            break
    else:
        ticks = ticks[:: int(np.ceil(room))]
    return ticks if len(ticks) > 1 else np.array([low + 0.1 * (high - low), high - 0.1 * (high - low)])


class LogAxis(pg.AxisItem):
    """Axis whose values are decimal logarithms and whose labels are the numbers; one position may be labelled zero.

    Attributes:
        zero: Position labelled zero; None for no such label.
    """

    zero: float | None = None

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        if not (np.isfinite([minVal, maxVal]).all() and maxVal > minVal and size > 0):
            return []
        room = _ROOM[self.orientation] * (maxVal - minVal) / size
        ticks = log_ticks(minVal + 0.2 * room, maxVal - 0.2 * room, room)  # a label at the very end is cut
        if self.zero is not None:
            ticks = np.array([self.zero, *ticks[ticks > self.zero + room]])
        return [(1.0, [float(tick) for tick in ticks])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        return ["0" if value == self.zero else format_number(10**value) for value in values]


def format_number(value: float) -> str:
    """Format with three significant digits, without an exponent from 0.0001 to 99,999."""
    if value == 0 or not 1e-4 <= abs(value) < 99_999.5:
        return f"{value:.3g}"
    digits = max(2 - int(np.floor(np.log10(abs(value)))), 0)
    text = f"{value:.{digits}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


class LogCanvas(PlotCanvas):
    """Empty plot that emits pointer positions, clicks, and presses of the arrow keys, Enter and Escape."""

    hovered = Signal(QPointF)
    """Position of the pointer; None once it has left."""
    clicked = Signal(QPointF)
    key_pressed = Signal(int)

    def __init__(self, parent: QWidget) -> None:
        self.left_axis = LogAxis("left")
        self.bottom_axis = LogAxis("bottom")
        axes = {"left": self.left_axis, "bottom": self.bottom_axis}
        super().__init__(parent, axisItems=axes)
        self.setObjectName("work-precision-canvas")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setMinimumHeight(190)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        for axis in axes.values():
            axis.setStyle(tickLength=3, hideOverlappingLabels=False)
        self.left_axis.setWidth(52)
        self.bottom_axis.setHeight(34)
        self._pressed: QPointF | None = None

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self.name_axis("bottom", "Time (ms)", theme)
        self.colour_axes(theme)
        self.getPlotItem().showGrid(x=True, y=True, alpha=0.5)

    def name_axis(self, side: str, text: str, theme: Theme) -> None:
        """Set the label of an axis: quantity and unit."""
        self.getAxis(side).setLabel(text, color=theme.quiet, **{"font-size": "11px"})

    def mousePressEvent(self, event: QMouseEvent) -> None:
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        self._pressed = event.position() if event.button() == Qt.MouseButton.LeftButton else None

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.hovered.emit(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Emit ``clicked`` unless the pointer moved since the press."""
        pressed = self._pressed
        self._pressed = None
        if pressed is not None and (event.position() - pressed).manhattanLength() < QApplication.startDragDistance():
            self.clicked.emit(event.position())

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self.hovered.emit(None)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self.hovered.emit(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Ignore the wheel, so that it scrolls the column."""
        event.ignore()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if Qt.Key(event.key()) in _KEYS:
            self.key_pressed.emit(event.key())
            event.accept()
        else:
            event.ignore()


PICK_RADIUS = 12.0
"""Maximum distance at which a point is under the pointer [px]."""
_MARGIN = 0.09
_LEAST_SPAN = 0.3
_SPREAD_WIDTH = 4.0
_SPREAD_ALPHA = 0.45


class WorkPrecisionPlot(QWidget):
    """Diagram with its legend and a line that names the point under the pointer.

    Arrow keys move between points, Enter applies the setting of the current one.

    Args:
        theme: Colours.
    """

    chosen = Signal(Setting)
    """The point with this setting was clicked."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._diagram: Diagram | None = None
        self._present: Setting | None = None
        self._held: Point | None = None
        self._floor = 0.0
        self._detail = caption_label(self, "work-precision-detail")
        self._detail.setMinimumHeight(2 * self._detail.fontMetrics().height())
        self._detail.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.canvas = LogCanvas(self)
        self.canvas.hovered.connect(self._on_hovered)
        self.canvas.clicked.connect(self._on_clicked)
        self.canvas.key_pressed.connect(self._on_key_pressed)
        self._legend = CurveLegend(self)
        column_layout(self.canvas, self._detail, self._legend, parent=self, spacing=4, stretch=self.canvas)
        self._cursor = pg.ScatterPlotItem(size=RING_SIZE - 4, brush=None, antialias=True)
        self._cursor.setZValue(20)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self.canvas.set_theme(theme)
        self._cursor.setPen(pg.mkPen(theme.text, width=1.5))
        self._draw()

    def show_diagram(self, diagram: Diagram, present: Setting | None = None) -> None:
        """Draw a diagram, with a ring around the point of the ``present`` setting if there is one."""
        if (diagram, present) != (self._diagram, self._present):
            self._diagram = diagram
            self._present = present
            self._draw()

    def places(self) -> list[tuple[Point, QPointF]]:
        """Return all points with their positions on the canvas [px]."""
        points = self._diagram.points if self._diagram else ()
        box = self.canvas.getPlotItem().getViewBox()
        scene = [box.mapViewToScene(QPointF(*map(float, at))) for at in self._logarithms(points)]
        return [(point, QPointF(self.canvas.mapFromScene(at))) for point, at in zip(points, scene, strict=True)]

    @property
    def held(self) -> Point | None:
        """Point under the pointer."""
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
        best = pareto_front(diagram.points)
        if len(best) > 1:
            pen = pg.mkPen(self._theme.quiet, width=1, style=Qt.PenStyle.DashLine)
            plot.addItem(pg.PlotDataItem(self._logarithms(best), pen=pen, antialias=True))
        for one in diagram.theory:
            pen = pg.mkPen(self._theme.quiet, width=1.5, style=Qt.PenStyle.DotLine)
            plot.addItem(pg.PlotDataItem(np.log10(one.points), pen=pen, antialias=True))
        for limit in diagram.limits:
            pen = pg.mkPen(curve_colour(self._theme, limit.number), width=1, style=LINE_STYLES["upright"])
            plot.addItem(pg.InfiniteLine(math.log10(limit.milliseconds), angle=90, pen=pen))
        for curve in diagram.curves:
            self._draw_curve(curve)
        self._draw_present(diagram)
        entries: list[tuple[int | str, str]] = [(curve.number, method_title(curve.method)) for curve in diagram.curves]
        ring = [("ring", "Current setting")] if self._point_of(self._present) else []
        theory: list[tuple[int | str, str]] = [("dotted", one.name) for one in diagram.theory]
        limits: list[tuple[int | str, str]] = [
            ("upright", name) for name in dict.fromkeys(limit.name for limit in diagram.limits)
        ]
        self._legend.show_entries([*entries, ("best", "Pareto front"), *ring, *theory, *limits], self._theme)
        sources = dict.fromkeys((one.name, one.source) for one in diagram.theory)
        sources |= dict.fromkeys((limit.name, limit.source) for limit in diagram.limits)
        self._legend.setToolTip("\n".join(f"{name}: {source}" for name, source in sources))
        plot.addItem(self._cursor)
        self._hold(self._held if self._held in diagram.points else None)

    def _draw_curve(self, curve: Curve) -> None:
        plot = self.canvas.getPlotItem()
        colour = curve_colour(self._theme, curve.number)
        line = self._logarithms([point for point in curve.points if point.joined])
        plot.addItem(pg.PlotDataItem(line, pen=pg.mkPen(colour, width=1.5), antialias=True))
        self._draw_spread(curve, colour)
        marks = [
            self._mark(point, at, colour)
            for point, at in zip(curve.points, self._logarithms(curve.points), strict=True)
        ]
        marks.sort(key=lambda mark: mark["size"])
        scatter = pg.ScatterPlotItem(marks, symbol=curve_symbol(curve.number), antialias=True)
        scatter.setZValue(10)
        plot.addItem(scatter)

    def _draw_spread(self, curve: Curve, colour: QColor) -> None:
        """Draw lines from the median time of each point to its 95th percentile, and vertical error intervals.

        Only points with enough runs, and at enough places, have these values.
        """
        spread = [
            (point, replace(point, milliseconds=p95)) for point in curve.points if (p95 := point.p95_ms) is not None
        ]
        spread += [
            (replace(point, error=point.interval[0]), replace(point, error=point.interval[1]))
            for point in curve.points
            if point.interval is not None
        ]
        if spread:
            ends = self._logarithms([end for pair in spread for end in pair])
            faint = QColor(colour)
            faint.setAlphaF(_SPREAD_ALPHA)
            pen = pg.mkPen(faint, width=_SPREAD_WIDTH, cap=Qt.PenCapStyle.FlatCap)
            self.canvas.getPlotItem().addItem(pg.PlotDataItem(ends, connect="pairs", pen=pen, antialias=True))

    def _mark(self, point: Point, at: FloatArray, colour: QColor) -> dict[str, Any]:
        """Return a marker: filled on the line, hollow for a setting off it, small for an intermediate iteration."""
        background = QColor(self._theme.panel)
        if not point.usable:
            return {"pos": at, "size": ITERATION_MARKER_SIZE, "brush": colour, "pen": None}
        if not point.joined:
            return {"pos": at, "size": MARKER_SIZE - 1, "brush": background, "pen": pg.mkPen(colour, width=1.5)}
        return {"pos": at, "size": MARKER_SIZE, "brush": colour, "pen": pg.mkPen(background)}

    def _draw_present(self, diagram: Diagram) -> None:
        point = self._point_of(self._present)
        if point is None:
            return
        pen = pg.mkPen(self._theme.accent, width=2.5)
        ring = pg.ScatterPlotItem(pos=self._logarithms([point]), size=RING_SIZE, brush=None, pen=pen, antialias=True)
        ring.setZValue(15)
        self.canvas.getPlotItem().addItem(ring)

    def _point_of(self, setting: Setting | None) -> Point | None:
        points = self._diagram.points if self._diagram else ()
        return next((point for point in points if point.usable and point.setting == setting), None)

    def _fit(self, points: Sequence[Point]) -> None:
        """Fit the axes to all points; points without error are placed below the smallest error and labelled 0."""
        least = self._diagram.least if self._diagram else 0.0
        errors = [point.error for point in points if point.error > least]
        self._floor = math.log10(min(errors) / 2 if errors else least)
        flat = any(point.error <= least for point in points)
        self.canvas.left_axis.zero = self._floor if flat else None
        ends = [replace(point, error=end) for point in points for end in point.interval or ()]
        places = self._logarithms([*points, *ends]) if points else np.zeros((1, 2))
        low = places.min(axis=0)
        high = places.max(axis=0)
        upright = [math.log10(limit.milliseconds) for limit in (self._diagram.limits if self._diagram else ())]
        low[0] = min(low[0], *upright, math.inf)
        high[0] = max(high[0], *upright, -math.inf)
        middle = 0.5 * (low + high)
        half = (0.5 + _MARGIN) * np.maximum(high - low, _LEAST_SPAN)
        x, y = np.stack([middle - half, middle + half], axis=1)
        self.canvas.getPlotItem().getViewBox().setRange(xRange=x, yRange=y, padding=0)

    def _logarithms(self, points: Sequence[Point]) -> FloatArray:
        """Return the positions (k, 2) of points in the diagram, as decimal logarithms."""
        least = self._diagram.least if self._diagram else 0.0
        rows = [
            (math.log10(point.milliseconds), math.log10(point.error) if point.error > least else self._floor)
            for point in points
        ]
        return np.array(rows, dtype=np.float64).reshape(-1, 2)

    def _hold(self, point: Point | None) -> None:
        """Mark a point and show its name; None shows the current setting."""
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
            return (
                f"Present: {_point_text(present, self._diagram.unit)}"
                if present
                else "Click a point to apply its setting."
            )
        text = _point_text(point, self._diagram.unit)
        if not point.usable:
            return f"{text}. Intermediate iteration, not a setting."
        if point.setting == self._present:
            return f"{text}. In use."
        return f"{text}. Click or Enter to apply it." + (f" {point.note}." if point.note else "")

    def _nearest(self, at: QPointF) -> Point | None:
        """Return the point under the pointer at ``at``; settings take precedence over intermediate iterations."""
        away = [(math.hypot(place.x() - at.x(), place.y() - at.y()), point) for point, place in self.places()]
        near = [(not point.usable, distance, point) for distance, point in away if distance <= PICK_RADIUS]
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
            self._hold(self._next_point(key))

    def _next_point(self, key: int) -> Point | None:
        """Return the next setting to the right (slower), left, up (more error) or down of the held or current one."""
        points = [point for point in (self._diagram.points if self._diagram else ()) if point.usable]
        start = self._held or self._point_of(self._present)
        if start not in points:
            return pareto_front(points)[0] if points else None
        if not self._held:
            return start
        measure = _KEY_ORDERS[Qt.Key(key)]
        further = [point for point in points if measure(point) > measure(start)]
        return min(further, key=measure) if further else start


_KEY_ORDERS: dict[Qt.Key, Callable[[Point], tuple[float, float]]] = {
    Qt.Key.Key_Right: lambda point: (point.milliseconds, point.error),
    Qt.Key.Key_Left: lambda point: (-point.milliseconds, -point.error),
    Qt.Key.Key_Up: lambda point: (point.error, point.milliseconds),
    Qt.Key.Key_Down: lambda point: (-point.error, -point.milliseconds),
}


def _point_text(point: Point, unit: str) -> str:
    gap = "" if unit == "°" else "\u202f"
    name = f"{method_title(point.setting.method)}{', ' if point.name else ''}{point.name}"
    often = "" if point.p95_ms is None else f" (95\u202f% within {format_number(point.p95_ms)}\u202fms)"
    error = f"{format_number(point.error)}{gap}{unit}"
    if point.interval is not None:
        error += f" ({format_number(point.interval[0])} to {format_number(point.interval[1])}{gap}{unit})"
    return f"{name}: {error}, {format_number(point.milliseconds)}\u202fms{often}"
