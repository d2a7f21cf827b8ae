"""Overlay over the window while files are dragged over it: what a drop will do."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.painting import caption_fonts, chip_size, faint, paint_chip

_EDGE = 16.0


class DropOverlay(QWidget):
    """Covers its parent with a dashed border and a text; it takes no mouse events.

    Args:
        theme: Colours.
        parent: Widget that is covered.

    Attributes:
        text: Text that is shown.
    """

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self._theme = theme
        self.text = ""
        self.setObjectName("drop-overlay")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hide()

    def show_text(self, text: str) -> None:
        """Cover the parent and show a text."""
        self.text = text
        self.setAccessibleName(text)
        parent = self.parentWidget()
        assert parent is not None
        self.setGeometry(parent.rect())
        self.raise_()
        self.show()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw a veil, the border and the text in the middle."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.fillRect(self.rect(), faint(self._theme.window, 170))
        painter.setPen(QPen(QColor(self._theme.accent), 2.0, Qt.PenStyle.DashLine))
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(_EDGE, _EDGE, -_EDGE, -_EDGE), 8, 8)
        _, font = caption_fonts(self.font())
        font.setPixelSize(16)
        painter.setFont(font)
        room = self.width() - 4 * _EDGE
        text = painter.fontMetrics().elidedText(self.text, Qt.TextElideMode.ElideMiddle, int(room))
        box = QRectF(0.0, 0.0, *chip_size(text, font).toTuple())
        box.moveCenter(QRectF(self.rect()).center())
        paint_chip(painter, box, text, font, self._theme.text, self._theme.panel, alpha=255)
        painter.end()
