"""An empty logarithmic plot: axes with round numbers, and what the hand does over it."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QFont, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication, QSizePolicy, QWidget

from app.arrays import FloatArray
from widgets.colours import Theme

_STEPS = ((1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8), (1, 1.5, 2, 3, 4, 5, 6, 8), (1, 2, 3, 5), (1, 2, 5), (1, 3), (1,))
_ROOM = {"bottom": 40, "left": 22}
"""Pixels between two labels."""
_KEYS = (
    Qt.Key.Key_Left, Qt.Key.Key_Right, Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_Return, Qt.Key.Key_Enter,
    Qt.Key.Key_Escape,
)  # fmt: skip


def round_logarithms(low: float, high: float, room: float) -> FloatArray:
    """Decimal logarithms of round numbers from ``low`` to ``high``, none closer than ``room``; two others if none."""
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
    """Its values are decimal logarithms, its labels the numbers; a place may be labelled as zero.

    Attributes:
        zero: Where zero is drawn; None where there is none.
    """

    zero: float | None = None

    def tickValues(self, minVal: float, maxVal: float, size: float) -> list[tuple[float, list[float]]]:
        """pyqtgraph."""
        if not (np.isfinite([minVal, maxVal]).all() and maxVal > minVal and size > 0):
            return []
        room = _ROOM[self.orientation] * (maxVal - minVal) / size
        ticks = round_logarithms(minVal + 0.2 * room, maxVal - 0.2 * room, room)  # a label at the very end is cut
        if self.zero is not None:
            ticks = np.array([self.zero, *ticks[ticks > self.zero + room]])
        return [(1.0, [float(tick) for tick in ticks])]

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:
        """pyqtgraph."""
        return ["0" if value == self.zero else number(10**value) for value in values]


def number(value: float) -> str:
    """Three significant digits, never an exponent from 0.0001 to 99,999."""
    if value == 0 or not 1e-4 <= abs(value) < 99_999.5:
        return f"{value:.3g}"
    digits = max(2 - int(np.floor(np.log10(abs(value)))), 0)
    text = f"{value:.{digits}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


class LogCanvas(pg.PlotWidget):
    """Tells where the pointer is, what was clicked, and which arrows, Enter or Escape were pressed; draws nothing."""

    hovered = Signal(object)
    """A QPointF, or None when the pointer has left."""
    clicked = Signal(QPointF)
    key_pressed = Signal(int)

    def __init__(self, parent: QWidget) -> None:
        self.left_axis, self.bottom_axis = LogAxis("left"), LogAxis("bottom")
        axes = {"left": self.left_axis, "bottom": self.bottom_axis}
        super().__init__(parent, background=None, axisItems=axes)
        self.setObjectName("work-precision-canvas")
        self.setAcceptDrops(False)  # a file dropped here is the window's
        self.setMenuEnabled(False)
        self.setMouseEnabled(x=False, y=False)
        self.hideButtons()
        menu = self.getPlotItem().ctrlMenu  # made without a parent, it would outlive the plot
        menu.setParent(self, menu.windowFlags())
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMouseTracking(True)
        self.setMinimumHeight(190)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        small = QFont(self.font())
        small.setPixelSize(11)
        for axis in axes.values():
            axis.setStyle(tickLength=3, hideOverlappingLabels=False)
            axis.setTickFont(small)
        self.left_axis.setWidth(52)
        self.bottom_axis.setHeight(34)
        self._pressed: QPointF | None = None

    def dress(self, theme: Theme) -> None:
        """Take a theme."""
        self.name_axis("bottom", "Time (ms)", theme)
        for axis in (self.left_axis, self.bottom_axis):
            axis.setPen(pg.mkPen(QColor(theme.line)))
            axis.setTextPen(pg.mkPen(QColor(theme.quiet)))
        self.getPlotItem().showGrid(x=True, y=True, alpha=0.5)

    def name_axis(self, side: str, text: str, theme: Theme) -> None:
        """Write what an axis measures, and its unit, beside it."""
        self.getAxis(side).setLabel(text, color=theme.quiet, **{"font-size": "11px"})

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt."""
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        self._pressed = event.position() if event.button() == Qt.MouseButton.LeftButton else None

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt."""
        self.hovered.emit(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: a press that moved is no click."""
        pressed, self._pressed = self._pressed, None
        if pressed is not None and (event.position() - pressed).manhattanLength() < QApplication.startDragDistance():
            self.clicked.emit(event.position())

    def leaveEvent(self, event: QEvent) -> None:
        """Qt."""
        super().leaveEvent(event)
        self.hovered.emit(None)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt."""
        super().focusOutEvent(event)
        self.hovered.emit(None)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the wheel scrolls the column."""
        event.ignore()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt."""
        if Qt.Key(event.key()) in _KEYS:
            self.key_pressed.emit(event.key())
            event.accept()
        else:
            event.ignore()
