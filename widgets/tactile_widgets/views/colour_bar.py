"""Colour bar at the left edge of the map: pressures [kPa, or counts] by colour, current peak, maximum of the scale."""

from __future__ import annotations

from math import ceil

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QActionGroup,
    QColor,
    QContextMenuEvent,
    QFontMetricsF,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QDoubleSpinBox, QMenu, QWidget

from tactile_maps.core.reading_units import ReadingUnits
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import small_font

MAXIMA = (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
"""Maxima of the scale in the context menu [kPa]."""
LOWEST = 0.1
HIGHEST = 10_000.0
BAR_LEFT = 18.0
BAR_WIDTH = 8.0
_TICK = 3.0
_GAP = 2.0
_DIGITS = 2
"""The bar has room for numbers of at least as many digits."""
TOP = 34.0
BOTTOM = 24.0


class ColourBar(QWidget):
    """A slim vertical bar. Double-click, Space, the context menu or Up and Down set the maximum of the scale."""

    maximum_changed = Signal(float)
    """Maximum chosen by the user [kPa]; the bar does not change until ``set_scale``."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._scale = scale
        self._peak = 0.0
        self._units = ReadingUnits.CALIBRATED
        self.setObjectName("colour-bar")
        self.setAccessibleName("Pressure scale")
        self.setToolTip("Colour scale of pressure in both views. Double-click to set its maximum.")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumHeight(160)
        self._editor = QDoubleSpinBox(self)
        self._editor.setObjectName("colour-bar-maximum")
        self._editor.setAccessibleName("Maximum of the pressure scale")
        self._editor.setRange(LOWEST, HIGHEST)
        self._editor.setDecimals(1)
        self._editor.setButtonSymbols(QDoubleSpinBox.ButtonSymbols.NoButtons)
        self._editor.editingFinished.connect(self._on_editor_finished)
        self._editor.hide()
        self.set_scale(scale)

    def sizeHint(self) -> QSize:
        digits = max(len(f"{value:g}") for value in ticks(self._scale.maximum, most=10))
        numbers = QFontMetricsF(small_font(self.font())).horizontalAdvance("0" * max(digits, _DIGITS))
        return QSize(ceil(BAR_LEFT + BAR_WIDTH + _TICK + numbers + 2 * _GAP), 400)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self.update()

    def set_scale(self, scale: PressureScale) -> None:
        """Show a scale."""
        self._scale = scale
        self._gradient = np.ascontiguousarray(scale.lut[::-1, None])
        self.setFixedWidth(self.sizeHint().width())
        self._describe()

    def set_units(self, units: ReadingUnits) -> None:
        """Set the units of the readings."""
        if units is not self._units:
            self._units = units
            self._describe()

    @property
    def title(self) -> str:
        """Title of the scale, such as "Pressure (kPa)"."""
        return self._units.title

    def _describe(self) -> None:
        self.setAccessibleDescription(f"From 0 to {self._scale.maximum:g} {self._units.unit}")
        self.update()

    def set_peak(self, kilopascals: float) -> None:
        """Mark the current peak pressure [kPa]; above the maximum of the scale, show its value."""
        if kilopascals != self._peak:
            self._peak = kilopascals
            self.update()

    def y_of(self, kilopascals: float) -> float:
        """Return the vertical position of a pressure on the bar [px]."""
        return TOP + (1 - kilopascals / self._scale.maximum) * self._length

    @property
    def _length(self) -> float:
        return self.height() - TOP - BOTTOM

    def build_menu(self) -> QMenu:
        """Build the context menu of maxima."""
        menu = QMenu(self)
        group = QActionGroup(menu)
        for maximum in MAXIMA:
            action = QAction(f"0 to {maximum:g}\u202f{self._units.unit}", group)
            action.setCheckable(True)
            action.setChecked(maximum == self._scale.maximum)
            action.setData(maximum)
            menu.addAction(action)
        group.triggered.connect(self._on_menu_triggered)
        menu.addSeparator()
        menu.addAction("Other…").triggered.connect(self.edit)
        return menu

    def edit(self) -> None:
        """Let the user type the maximum of the scale."""
        self._editor.setValue(self._scale.maximum)
        self._editor.setGeometry(0, 4, self.width(), 26)
        self._editor.show()
        self._editor.setFocus()
        self._editor.selectAll()

    def _on_menu_triggered(self, action: QAction) -> None:
        self.maximum_changed.emit(float(action.data()))

    def _on_editor_finished(self) -> None:
        if self._editor.isVisible():
            self._editor.hide()
            self.setFocus()
            if self._editor.value() != self._scale.maximum:
                self.maximum_changed.emit(self._editor.value())

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        menu = self.build_menu()
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(event.globalPos())

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        self.edit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Up and Down choose the next maximum of the menu, Space types one, Escape stops typing."""
        key = event.key()
        now = self._scale.maximum
        if key == Qt.Key.Key_Space:
            self.edit()
        elif key == Qt.Key.Key_Escape and self._editor.isVisible():
            self._editor.setValue(now)
            self._on_editor_finished()
        elif key == Qt.Key.Key_Up and now < MAXIMA[-1]:
            self.maximum_changed.emit(next(maximum for maximum in MAXIMA if maximum > now))
        elif key == Qt.Key.Key_Down and now > MAXIMA[0]:
            self.maximum_changed.emit(next(maximum for maximum in reversed(MAXIMA) if maximum < now))
        else:
            super().keyPressEvent(event)

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), QColor(self._theme.window))
        painter.setFont(small_font(self.font()))
        self._paint_bar(painter)
        self._paint_ticks(painter)
        self._paint_label(painter)
        self._paint_peak(painter)
        painter.end()

    def _paint_bar(self, painter: QPainter) -> None:
        count = len(self._gradient)
        image = QImage(self._gradient.data, 1, count, 4, QImage.Format.Format_RGB32)
        box = QRectF(BAR_LEFT, TOP, BAR_WIDTH, self._length)
        painter.drawImage(box, image)
        painter.setPen(QPen(QColor(self._theme.line), 1))
        painter.drawRect(box)

    def _paint_ticks(self, painter: QPainter) -> None:
        metrics = QFontMetricsF(painter.font())
        left = BAR_LEFT + BAR_WIDTH
        for value in ticks(self._scale.maximum, most=max(2, int(self._length / 48))):
            y = self.y_of(value)
            painter.setPen(QColor(self._theme.quiet))
            painter.drawLine(QPointF(left, y), QPointF(left + _TICK, y))
            painter.drawText(QPointF(left + _TICK + _GAP, y + metrics.capHeight() / 2), f"{value:g}")

    def _paint_label(self, painter: QPainter) -> None:
        painter.save()
        painter.translate(BAR_LEFT - 6, TOP + self._length / 2)
        painter.rotate(-90)
        painter.setPen(QColor(self._theme.quiet))
        painter.drawText(QRectF(-80, -14, 160, 16), Qt.AlignmentFlag.AlignCenter, self.title)
        painter.restore()

    def _paint_peak(self, painter: QPainter) -> None:
        if self._peak <= 0:
            return
        beyond = self._peak > self._scale.maximum
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.fault if beyond else self._theme.text))
        middle = BAR_LEFT + BAR_WIDTH / 2
        if not beyond:
            y = self.y_of(self._peak)
            painter.drawPolygon(
                QPolygonF([QPointF(BAR_LEFT, y), QPointF(BAR_LEFT - 7, y - 4), QPointF(BAR_LEFT - 7, y + 4)])
            )
            return
        painter.drawPolygon(
            QPolygonF([QPointF(middle, TOP - 10), QPointF(middle - 6, TOP - 3), QPointF(middle + 6, TOP - 3)])
        )
        painter.setPen(QColor(self._theme.text))
        painter.drawText(QRectF(0, 4, self.width(), 18), Qt.AlignmentFlag.AlignCenter, f"{self._peak:.0f}")


def ticks(maximum: float, *, most: int) -> list[float]:
    """Return round values from 0 to ``maximum``, in at most ``most`` equal steps of 1, 2 or 5 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(maximum / most))
    step = float(next(power * factor for factor in (1, 2, 5, 10) if maximum / (power * factor) <= most + 1e-9))
    return [round(index * step, 9) for index in range(int(maximum / step + 1e-9) + 1)]
