"""The window's lower edge: selection, readout, what is being prepared, the scene and the real-time factor.

What a person must never lose stands here and not in the toolbar, whose last buttons go into a menu where there is
little room: the lower edge elides words instead. What varies least is nearest the right, so that *Cancel* does not move
under the pointer when the readout changes.
"""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QStatusBar, QStyle, QStyleOption, QWidget

from tactile_widgets.context.progress_indicator import ProgressIndicator

_LEAST_PX = 24
_MARGINS_PX = 14
"""Above and below the words, so that a button has room among them."""
_FACTOR = "100.00× real time"
"""The longest words of the real-time factor: the room that is kept."""


class ElidedLabel(QLabel):
    """As wide as its words, and down to a few letters; what is cut is in the tool tip."""

    def __init__(self, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setContentsMargins(8, 0, 8, 0)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Ignored)

    @property
    def shown(self) -> str:
        """The words as they are drawn."""
        return self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, self.contentsRect().width())

    def minimumSizeHint(self) -> QSize:
        """Qt: a few letters."""
        return QSize(min(_LEAST_PX, super().sizeHint().width()), super().sizeHint().height())

    def setText(self, text: str) -> None:
        """Qt: other words."""
        super().setText(text)
        self._tell_what_is_cut()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: more or fewer of them can be seen."""
        super().resizeEvent(event)
        self._tell_what_is_cut()

    def _tell_what_is_cut(self) -> None:
        self.setToolTip("" if self.shown == self.text() else self.text())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: draw what has room."""
        painter = QPainter(self)
        painter.setPen(self.palette().windowText().color())
        painter.drawText(self.contentsRect(), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.shown)
        painter.end()


class StatusLine(QStatusBar):
    """Shows them; messages that pass appear at its left end.

    It keeps its height from the first: made, or grown, by words it would move the views.

    Attributes:
        selection: How many taxels are selected, or which.
        readout: What is under the pointer.
        loading: What is being prepared, with a way out.
        factor: The real-time factor, or how often a real skin is read.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("status-line")
        self.setSizeGripEnabled(False)
        self.selection = ElidedLabel("selection-count")
        self.readout = ElidedLabel("readout")
        self.loading = ProgressIndicator()
        self._scene = ElidedLabel("scene-title")
        self.factor = QLabel()
        self._scene.setAccessibleName("Scene")
        self.factor.setObjectName("real-time-factor")
        self.factor.setToolTip("Simulated seconds per second reached (1.00× is real time), or readings of a real skin")
        self.factor.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.factor.setContentsMargins(0, 0, 12, 0)
        self.factor.setMinimumWidth(self.factor.fontMetrics().horizontalAdvance(_FACTOR) + 12)
        self.addWidget(self.selection)
        self._kept = (self.readout, self.loading, self._scene, self.factor)
        for part in self._kept:
            self.addPermanentWidget(part)
        self.messageChanged.connect(self.setToolTip)
        self.setFixedHeight(self.fontMetrics().height() + _MARGINS_PX)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: a message that passes ends in an ellipsis where it has too little room; the tool tip says all of it."""
        message = self.currentMessage()
        if not message:
            super().paintEvent(event)
            return
        right = min(part.x() for part in self._kept if part.isVisible())
        room = self.rect().adjusted(6, 0, right - self.width() - 6, 0)
        painter = QPainter(self)
        option = QStyleOption()
        option.initFrom(self)
        self.style().drawPrimitive(QStyle.PrimitiveElement.PE_PanelStatusBar, option, painter, self)
        painter.setPen(self.palette().windowText().color())
        words = self.fontMetrics().elidedText(message, Qt.TextElideMode.ElideRight, room.width())
        painter.drawText(room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, words)
        painter.end()

    def show_title(self, text: str) -> None:
        """Name the scene."""
        self._scene.setText(text)

    def show_factor(self, factor: float | None) -> None:
        """The real-time factor reached; None in a replay."""
        self._show_pace("Replay" if factor is None else f"{factor:.2f}× real time")

    def show_rate(self, rate: float) -> None:
        """Readings of a real skin a second [Hz]."""
        self._show_pace(f"{rate:.0f}\u202fHz")

    def _show_pace(self, text: str) -> None:
        if text != self.factor.text():
            self.factor.setText(text)
