"""A heading that folds what is below it."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QFont, QPainter, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QAbstractButton, QSizePolicy, QWidget

_CHEVRON = 4.0
"""Half its width [px]."""


class FoldHeading(QAbstractButton):
    """Bold words and a chevron at the end of the line: up and it is open; checked means folded."""

    def __init__(self, text: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(text)
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)  # a click leaves the keys to the view that has them
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.toggled.connect(self._on_toggled)
        self._on_toggled(False)

    def sizeHint(self) -> QSize:
        """Qt: a line of words, and the chevron."""
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance(self.text()) + 32, metrics.height() + 4)

    def minimumSizeHint(self) -> QSize:
        """Qt: as much as the words need."""
        return self.sizeHint()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt: words at the left, the chevron at the right, a line below while the keys come here."""
        painter, palette = QPainter(self), self.palette()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = QFont(self.font())
        font.setWeight(QFont.Weight.DemiBold)
        painter.setFont(font)
        painter.setPen(palette.color(QPalette.ColorRole.WindowText))
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.text())
        marked = self.underMouse() or self.hasFocus()
        role = QPalette.ColorRole.Link if marked else QPalette.ColorRole.PlaceholderText
        painter.setPen(QPen(palette.color(role), 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        middle = QRectF(self.rect()).center()
        tip = -_CHEVRON / 2 if not self.isChecked() else _CHEVRON / 2
        corners = [QPointF(x, tip if x == 0 else -tip) for x in (-_CHEVRON, 0.0, _CHEVRON)]
        painter.translate(self.width() - _CHEVRON - 2, middle.y())
        painter.drawPolyline(QPolygonF(corners))

    def _on_toggled(self, folded: bool) -> None:
        self.setToolTip("Unfold" if folded else "Fold")
        self.setAccessibleName(f"{self.text()}, folded" if folded else self.text())
