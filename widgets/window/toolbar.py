"""The toolbar: play, step, reset, record, speed, the tools, what is being prepared, and the real-time
factor.

A label that is elided where there is little room comes first.
"""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QComboBox,
    QLabel,
    QMenu,
    QSizePolicy,
    QToolBar,
    QToolButton,
    QWidget,
)

from widgets.actions.registry import ActionRegistry
from widgets.actions.state import WindowState
from widgets.common.progress_indicator import ProgressIndicator
from widgets.timeline.playhead import SPEEDS

_LEAST = 24


class ElidedLabel(QLabel):
    """As wide as its words, and down to a few letters."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setProperty("role", "heading")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Preferred)

    @property
    def shown(self) -> str:
        """The words as they are drawn."""
        return self.fontMetrics().elidedText(self.text(), Qt.TextElideMode.ElideRight, self.width())

    def minimumSizeHint(self) -> QSize:
        """Qt: a few letters."""
        return QSize(min(_LEAST, super().sizeHint().width()), super().sizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: what is cut is in the tool tip."""
        super().resizeEvent(event)
        self.setToolTip("" if self.shown == self.text() else self.text())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: draw what has room."""
        painter = QPainter(self)
        painter.setPen(self.palette().windowText().color())
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.shown)
        painter.end()


_WIDTHS = {"pause": 88, "step": 78, "reset": 85, "record": 144}
_SELECT_WIDTH = 150
"""Widths of the buttons [px]: enough for the longest word each may show."""


class SessionToolbar(QToolBar):
    """Holds the buttons of the actions that have one, the speed, and what is being prepared.

    Args:
        actions: The window's actions.
        loading: Shows what is being prepared, in the middle.
        parent: Qt parent.
    """

    speed_chosen = Signal(float)
    """Simulated seconds per second requested."""

    def __init__(self, actions: ActionRegistry, loading: ProgressIndicator, parent: QWidget | None = None) -> None:
        super().__init__("Session", parent)
        self.setObjectName("toolbar")
        self._actions = actions
        self.setMovable(False)
        self.setIconSize(QSize(16, 16))
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._add_buttons("session")
        self.addSeparator()
        self.addWidget(self._make_speed())
        self.addSeparator()
        self._add_buttons("poke")
        self.addWidget(self._make_select())
        self.addSeparator()
        self._add_buttons("control", words=False)
        self.addSeparator()
        self._add_buttons("edit", words=False)
        self._add_buttons("undo", words=False)
        self.addWidget(loading)
        self._title, self.factor = ElidedLabel(), QLabel()
        self.factor.setObjectName("real-time-factor")
        self.factor.setToolTip("Simulated seconds per second reached: 1.00× is real time")
        self.factor.setMinimumWidth(108)
        self.factor.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.addWidget(self._title)
        self.addWidget(self.factor)
        self.show_state(WindowState())

    def _add_buttons(self, group: str, *, words: bool = True) -> None:
        for spec in self._actions.in_toolbar(group):
            action = self._actions[spec.name]
            self.addAction(action)
            button = self.widgetForAction(action)
            assert isinstance(button, QToolButton)
            if spec.name in _WIDTHS:
                # Fixed widths: a button that changes its word must not move its neighbours.
                button.setFixedWidth(_WIDTHS[spec.name])
            if not words:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
                button.setAccessibleName(spec.text)

    def _make_speed(self) -> QComboBox:
        self.speed = QComboBox()
        self.speed.setObjectName("speed")
        self.speed.setAccessibleName("Simulation speed")
        self.speed.setToolTip("Simulated seconds per second requested")
        for speed in SPEEDS:
            self.speed.addItem(f"{speed:g}×", speed)
        self.speed.setCurrentIndex(SPEEDS.index(1.0))
        self.speed.currentIndexChanged.connect(self._on_speed_chosen)
        return self.speed

    def _make_select(self) -> QToolButton:
        """One button for three ways of selecting: it takes the last one, its menu offers all."""
        self.select = QToolButton()
        self.select.setObjectName("select")
        self.select.setAccessibleName("Select taxels")
        self.select.setPopupMode(QToolButton.ToolButtonPopupMode.MenuButtonPopup)
        self.select.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.select.setIconSize(self.iconSize())
        menu = QMenu(self.select)
        specs = self._actions.in_toolbar("select")
        for spec in specs:
            menu.addAction(self._actions[spec.name])
            self._actions[spec.name].toggled.connect(self._on_select_toggled)
        self.select.setMenu(menu)
        self.select.setDefaultAction(self._actions[specs[0].name])
        self.select.setFixedWidth(_SELECT_WIDTH)
        return self.select

    def _on_select_toggled(self, down: bool) -> None:
        action = self.sender()
        if down and isinstance(action, QAction):
            self.select.setDefaultAction(action)

    def show_title(self, text: str) -> None:
        """Name the scene."""
        self._title.setText(text)

    def show_factor(self, factor: float | None) -> None:
        """The real-time factor reached; None in a replay."""
        text = "Replay" if factor is None else f"{factor:.2f}× real time"
        if text != self.factor.text():
            self.factor.setText(text)

    def show_state(self, state: WindowState) -> None:
        """What is replayed has a speed of its own."""
        self.speed.setEnabled(state.mode.running)

    def _on_speed_chosen(self, _index: int) -> None:
        self.speed_chosen.emit(float(self.speed.currentData()))
