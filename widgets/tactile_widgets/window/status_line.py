"""Status line: selection, readout, progress of background work, scene and real-time factor.

Information that must always be visible is shown here and not in the toolbar, whose last buttons move into a menu in a
narrow window; the status line elides texts instead. The parts that change least are at the right, so that *Cancel*
does not move under the pointer when the readout changes.
"""

from __future__ import annotations

from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QSizePolicy, QStatusBar, QStyle, QStyleOption, QWidget

from tactile_widgets.common.make import ElidedLabel
from tactile_widgets.context.progress_indicator import ProgressIndicator

_MARGINS_PX = 14
"""Height added to that of the text, so that a button fits [px]."""
_FACTOR = "100.00× real time"
"""Longest text of the real-time factor, which determines its width."""


class StatusLine(QStatusBar):
    """Status line; temporary messages appear at its left end.

    Its height is fixed: a change would move the views.

    Attributes:
        selection: Number or names of the selected taxels.
        readout: Values under the pointer.
        loading: Progress of background work, with *Cancel*.
        factor: Real-time factor, or rate of the readings of a real skin.
        kept: The parts that temporary messages do not cover.
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
        self.factor.setToolTip("Speed relative to real time (1.00×), or rate of readings of a real skin")
        self.factor.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.factor.setContentsMargins(0, 0, 12, 0)
        self.factor.setMinimumWidth(self.factor.fontMetrics().horizontalAdvance(_FACTOR) + 12)
        self.addWidget(self.selection)
        for label in (self.selection, self.readout, self._scene):
            label.setContentsMargins(8, 0, 8, 0)
            label.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Ignored)
        self.kept = (self.readout, self.loading, self._scene, self.factor)
        for part in self.kept:
            self.addPermanentWidget(part)
        self.messageChanged.connect(self.setToolTip)
        self.setFixedHeight(self.fontMetrics().height() + _MARGINS_PX)

    @property
    def shown(self) -> str:
        """Temporary message as drawn."""
        return self.fontMetrics().elidedText(self.currentMessage(), Qt.TextElideMode.ElideRight, self._room.width())

    @property
    def _room(self) -> QRect:
        right = min(part.x() for part in self.kept if part.isVisible())
        return self.rect().adjusted(6, 0, right - self.width() - 6, 0)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Elide a temporary message that does not fit; the tool tip shows the whole message."""
        if not self.currentMessage():
            super().paintEvent(event)
            return
        painter = QPainter(self)
        option = QStyleOption()
        option.initFrom(self)
        self.style().drawPrimitive(QStyle.PrimitiveElement.PE_PanelStatusBar, option, painter, self)
        painter.setPen(self.palette().windowText().color())
        painter.drawText(self._room, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.shown)
        painter.end()

    def show_title(self, text: str) -> None:
        """Show the title of the scene."""
        self._scene.setText(text)

    def show_factor(self, factor: float | None) -> None:
        """Show the real-time factor reached; None for a replay."""
        self._show_pace("Replay" if factor is None else f"{factor:.2f}× real time")

    def show_rate(self, rate: float) -> None:
        """Show the rate of the readings of a real skin [Hz]."""
        self._show_pace(f"{rate:.0f}\u202fHz")

    def _show_pace(self, text: str) -> None:
        if text != self.factor.text():
            self.factor.setText(text)
