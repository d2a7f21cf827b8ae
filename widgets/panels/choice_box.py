"""A quiet combo box for a column of many: words and a chevron; a frame only under the pointer or the keys."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPalette, QPen, QPolygonF, QWheelEvent
from PySide6.QtWidgets import QComboBox, QWidget

_PAD, _CHEVRON, _ROUND = 6.0, 3.5, 4.0
"""Beside the words, half the chevron's width, radius of the frame's corners [px]."""


class ChoiceBox(QComboBox):
    """Says what is in force, whatever its list calls that; a passing wheel does not turn it."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._words, self._quiet = "", False
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)

    @property
    def words(self) -> str:
        """What it says."""
        return self._words

    def say(self, words: str, *, quiet: bool = False) -> None:
        """Say this from now on; ``quiet`` for what is off."""
        self._words, self._quiet = words, quiet
        self.setAccessibleDescription(words)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt: words, chevron, and a frame where it is about to be used."""
        painter, palette = QPainter(self), self.palette()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        used = self.isEnabled() and (self.underMouse() or self.hasFocus())
        if used:
            painter.setPen(palette.color(QPalette.ColorRole.Link if self.hasFocus() else QPalette.ColorRole.Mid))
            painter.setBrush(palette.color(QPalette.ColorRole.Button))
            painter.drawRoundedRect(box, _ROUND, _ROUND)
            painter.setBrush(Qt.BrushStyle.NoBrush)
        quiet = palette.color(QPalette.ColorRole.PlaceholderText)
        painter.setPen(quiet if self._quiet and self.isEnabled() else palette.color(QPalette.ColorRole.ButtonText))
        words = box.adjusted(_PAD, 0, -4 * _CHEVRON, 0)
        text = self.fontMetrics().elidedText(self._words, Qt.TextElideMode.ElideRight, int(words.width()))
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)
        if self.isEnabled():
            painter.setPen(QPen(quiet, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.translate(box.right() - _PAD - _CHEVRON, box.center().y() - _CHEVRON / 4)
            corners = [QPointF(x, _CHEVRON / 2 if x == 0 else -_CHEVRON / 2) for x in (-_CHEVRON, 0.0, _CHEVRON)]
            painter.drawPolyline(QPolygonF(corners))

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the wheel scrolls the panel; it never changes what is simulated."""
        event.ignore()
