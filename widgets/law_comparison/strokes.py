"""How one contender's curve is told from another's: by colour, by dash, and by its letter."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from widgets.colours import Theme
from widgets.panels.curve_marks import ink

LETTERS = "ABCD"
"""Names of contenders; more than these could not be told apart."""
_DASHES = ((), (7.0, 5.0), (1.5, 3.5), (9.0, 3.0, 1.5, 3.0))
"""In widths of the pen; none for a solid line."""
_WIDE = 34


def stroke(theme: Theme, letter: str, *, width: float = 1.5) -> QPen:
    """The pen that draws a contender."""
    number = LETTERS.index(letter)
    pen = QPen(ink(theme, number), width)
    if _DASHES[number]:
        pen.setDashPattern(_DASHES[number])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    pen.setCosmetic(True)
    return pen


class Stroke(QWidget):
    """A piece of a contender's curve."""

    def __init__(self, letter: str, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._letter, self._theme = letter, theme
        self.setFixedSize(QSize(_WIDE, 16))

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt."""
        painter = QPainter(self)
        painter.setPen(stroke(self._theme, self._letter, width=2.0))
        middle = self.height() / 2
        painter.drawLine(QPointF(1, middle), QPointF(self.width() - 1, middle))
