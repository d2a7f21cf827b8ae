"""Three small maps side by side: measured readings, simulated readings, and their difference.

A taxel is a dot at its place on the map. Measured and simulated readings share one scale of pressure; the scale of the
difference is symmetric about zero. Both scales only grow while they are shown, so that colours can be compared over
time.
"""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFontMetricsF, QLinearGradient, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.live.simulated_skin import SkinDifference
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import DARK, DifferenceScale, PressureScale, Theme
from tactile_widgets.common.make import small_font
from tactile_widgets.plots.traces.trace_plots import nice_ceiling
from tactile_widgets.views.overlays.painting import polygon

TITLES = ("Measured", "Simulated", "Difference")
_GAP = 8.0
_LINE = 16.0
_KEY = 6.0
"""Distance between two maps, height of a line of text, and height of a colour bar [px]."""
_NEAR = 12.0
"""Distance within which the pointer selects a taxel's dot [px]."""
_LEAST = 1.0
"""Minimum end of both scales [kPa]: the noise of an untouched skin is not to fill them."""


class SkinDifferenceView(QWidget):
    """The three maps. The pointer shows the readings of a taxel, a click selects it.

    Attributes:
        hovered: Taxel under the pointer, or None.
    """

    pointed = Signal(object)
    """Taxel under the pointer, or None."""
    chosen = Signal(int)
    """Clicked taxel."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("skin-difference")
        self.setAccessibleName("Maps of the measured skin, the simulated one, and the difference")
        self.setMouseTracking(True)
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self._theme = DARK
        self._points = np.zeros((0, 2))
        self._box = (np.zeros(2), np.ones(2))
        self._spacing = 1.0
        self._shown: SkinDifference | None = None
        self._pressure = PressureScale(_LEAST)
        self._difference = DifferenceScale(_LEAST)
        self.hovered: int | None = None

    def show_map(self, map_: TactileMap) -> None:
        """Lay the taxels out as on this map."""
        self._points = map_.taxel_points
        low, high = map_.bounds
        self._box = low, np.maximum(high - low, 1e-9)
        self._spacing = float(np.sqrt(map_.skin.areas.sum() / max(len(self._points), 1)))
        self.updateGeometry()
        self.update()

    def show_difference(self, found: SkinDifference | None) -> None:
        """Show a difference; None clears the maps and resets both scales. Cost: 2 ms to paint 1,000 taxels."""
        if found is None:
            self._pressure = PressureScale(_LEAST)
            self._difference = DifferenceScale(_LEAST)
        else:
            peak = 1e-3 * max(found.measured.max(initial=0.0), found.simulated.max(initial=0.0))
            self._pressure = PressureScale(nice_ceiling(max(self._pressure.maximum, peak)))
            self._difference = DifferenceScale(nice_ceiling(max(self._difference.most, 1e-3 * found.largest)))
        self._shown = found
        self.update()

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self._theme = theme
        self.update()

    @property
    def scales(self) -> tuple[float, float]:
        """End of the scale of pressure, and of the scale of the difference to either side [kPa]."""
        return self._pressure.maximum, self._difference.most

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        return round(self._map_width(width) * self._box[1][1] / self._box[1][0] + 2 * _LINE + _KEY + 4)

    def sizeHint(self) -> QSize:
        return QSize(270, self.heightForWidth(270))

    def place_of(self, taxel: int, number: int) -> QPointF:
        """Return the place of a taxel's dot in one of the maps [px]."""
        x, y = self._pixels(number)[taxel]
        return QPointF(x, y)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self._point_at(self._taxel_at(event.position()))

    def leaveEvent(self, event: QEvent) -> None:
        self._point_at(None)
        super().leaveEvent(event)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        taxel = self._taxel_at(event.position())
        if event.button() is Qt.MouseButton.LeftButton and taxel is not None:
            self.chosen.emit(taxel)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(small_font(self.font()))
        for number, title in enumerate(TITLES):
            self._paint_map(painter, number, title)
        painter.end()

    def _paint_map(self, painter: QPainter, number: int, title: str) -> None:
        width = self._map_width(self.width())
        left = number * (width + _GAP)
        painter.setPen(QColor(self._theme.quiet))
        painter.drawText(QRectF(left, 0, width, _LINE), Qt.AlignmentFlag.AlignLeft, title)
        pixels = self._pixels(number)
        if self._shown is not None and len(self._points) == len(self._shown.measured):
            self._paint_dots(painter, pixels, self._colours(number, self._shown))
        if self.hovered is not None and self.hovered < len(pixels):
            painter.setPen(QPen(QColor(self._theme.accent), 1.5))
            painter.drawEllipse(QPointF(*pixels[self.hovered]), 5.0, 5.0)
        self._paint_key(painter, number, left, width)

    def _colours(self, number: int, shown: SkinDifference) -> IntArray:
        """Return the colours of one of the maps: (taxels, 3) red, green, blue."""
        if number == 2:
            return self._difference.rgb(1e-3 * shown.difference).astype(np.int64)
        return self._pressure.rgb(1e-3 * (shown.measured, shown.simulated)[number]).astype(np.int64)

    def _paint_dots(self, painter: QPainter, pixels: FloatArray, colours: IntArray) -> None:
        """Draw all dots of one colour at once, which is 20 times as fast as one by one; untouched skin first."""
        size = min(max(self._spacing * self._map_width(self.width()) / self._box[1][0], 2.5), 12.0)
        words = colours @ np.array([1 << 16, 1 << 8, 1])
        for word in reversed(np.unique(words).tolist()):
            painter.setPen(QPen(QColor(word), size, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.drawPoints(polygon(pixels[words == word]))

    def _paint_key(self, painter: QPainter, number: int, left: float, width: float) -> None:
        top = self.height() - _LINE - _KEY
        table = self._difference.table if number == 2 else self._pressure.table
        gradient = QLinearGradient(left, 0, left + width, 0)
        for at in np.linspace(0, 1, 17):
            gradient.setColorAt(float(at), QColor(*(int(part) for part in table[round(at * (len(table) - 1))])))
        painter.fillRect(QRectF(left, top, width, _KEY), gradient)
        painter.setPen(QColor(self._theme.quiet))
        most = self.scales[number == 2]
        words = (f"−{most:g}", f"{most:g}\u202fkPa") if number == 2 else ("0", f"{most:g}\u202fkPa")
        line = QRectF(left, top + _KEY + 1, width, _LINE)
        painter.drawText(line, Qt.AlignmentFlag.AlignLeft, words[0])
        if QFontMetricsF(painter.font()).horizontalAdvance("".join(words)) < width:
            painter.drawText(line, Qt.AlignmentFlag.AlignRight, words[1])

    def _map_width(self, width: float) -> float:
        return (width - 2 * _GAP) / 3

    def _pixels(self, number: int) -> FloatArray:
        """Return the places of the dots in one of the maps: (taxels, 2) [px]."""
        low, size = self._box
        width = self._map_width(self.width())
        corner = np.array([number * (width + _GAP), self.height() - _LINE - _KEY - 4])
        return corner + (self._points - low) * [1.0, -1.0] * (width / size[0])

    def _taxel_at(self, place: QPointF) -> int | None:
        if not len(self._points):
            return None
        here = np.array([place.x(), place.y()])
        away = [np.linalg.norm(self._pixels(number) - here, axis=1) for number in range(3)]
        nearest = min(away, key=lambda distances: float(distances.min()))
        taxel = int(nearest.argmin())
        return taxel if nearest[taxel] <= _NEAR else None

    def _point_at(self, taxel: int | None) -> None:
        if taxel != self.hovered:
            self.hovered = taxel
            self.pointed.emit(taxel)
            self.update()
