"""The toolbar: play, step, reset, record, speed, the tools of the hand, what is being prepared, and the real-time
factor.

Two small widgets of it come first: a label that is elided where there is little room, and the progress of what is
prepared in a process beside the window while the scene before it goes on.
"""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QMenu,
    QProgressBar,
    QSizePolicy,
    QToolBar,
    QToolButton,
    QWidget,
)

from widgets.actions.icons import icon
from widgets.common.colours import Theme, mixed
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


class ProgressIndicator(QWidget):
    """Stage, progress and a way out, in the middle of the toolbar: it covers nothing and moves nothing."""

    cancelled = Signal()
    """The hand does not want it any more."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("loading-bar")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)
        self._parts = QWidget(self)
        self._text, self._progress, cancel = QLabel(), QProgressBar(), QToolButton()
        self._text.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._text.setMinimumWidth(1)  # long words are cut before the toolbar is
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedSize(120, 6)
        self._progress.setAccessibleName("Progress")
        cancel.setText("Cancel")
        cancel.setObjectName("loading-cancel")
        cancel.setToolTip("Keep the current scene")
        cancel.clicked.connect(self.cancelled)
        row = QHBoxLayout(self._parts)
        row.setContentsMargins(16, 0, 16, 0)
        row.setSpacing(8)
        row.addWidget(self._text, 1)
        row.addWidget(self._progress)
        row.addWidget(cancel)
        whole = QHBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self._parts)
        self.clear()

    @property
    def busy(self) -> bool:
        """Whether something is being prepared."""
        return not self._parts.isHidden()

    def show_progress(self, text: str, fraction: float | None) -> None:
        """The stage, and how far the whole is, 0 to 1; None where nobody knows."""
        self._text.setText(text)
        self._text.setToolTip(text)
        self._progress.setVisible(fraction is not None)
        self._progress.setValue(round(1000 * (fraction or 0.0)))
        self.setAccessibleName(text)
        self._parts.show()

    def clear(self) -> None:
        """Nothing is being prepared any more."""
        self._parts.hide()


_TOOLS = ("select_box", "select_lasso", "select_brush")
_EDITS = ("arrange", "pins", "seams", "interest")
_LEADS = ("draw_path", "set_target")
_BACK_AND_FORTH = ("undo", "redo")
_WIDTHS = {"pause": 88, "step": 78, "reset": 85, "record": 144}
_SELECT_WIDTH = 150
"""Widths of the buttons [px]: enough for the longest word each may show."""


class SessionToolbar(QToolBar):
    """Shows the session's state on its buttons.

    Args:
        actions: The window's actions, by name.
        theme: Colours of the icons.
        parent: Qt parent.
    """

    speed_chosen = Signal(float)
    """Simulated seconds per second asked for."""

    def __init__(self, actions: dict[str, QAction], theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__("Session", parent)
        self.setObjectName("toolbar")
        self._actions, self._theme = actions, theme
        self._state = ("empty", False, False)
        self.setMovable(False)
        self.setIconSize(QSize(16, 16))
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        for name in ("pause", "step", "reset", "record"):
            self.addAction(actions[name])
            # Fixed widths: a button that changes its word must not move its neighbours.
            self.widgetForAction(actions[name]).setFixedWidth(_WIDTHS[name])
        self.addSeparator()
        self.addWidget(self._make_speed())
        self.addSeparator()
        self.addAction(actions["poke"])
        self.addWidget(self._make_select())
        self.addSeparator()
        for name in (*_LEADS, "", *_EDITS, *_BACK_AND_FORTH):
            if not name:
                self.addSeparator()
                continue
            self.addAction(actions[name])
            button = self.widgetForAction(actions[name])
            assert isinstance(button, QToolButton)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            button.setAccessibleName(actions[name].text())
        self.loading = ProgressIndicator()
        self.addWidget(self.loading)
        self._title, self.factor = ElidedLabel(), QLabel()
        self.factor.setObjectName("real-time-factor")
        self.factor.setToolTip("Simulated seconds per second reached: 1.00× is real time")
        self.factor.setMinimumWidth(108)
        self.factor.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.addWidget(self._title)
        self.addWidget(self.factor)
        self.show_state("empty", playing=False, recording=False)

    def _make_speed(self) -> QComboBox:
        self.speed = QComboBox()
        self.speed.setObjectName("speed")
        self.speed.setAccessibleName("Simulation speed")
        self.speed.setToolTip("Simulated seconds per second asked for")
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
        for name in _TOOLS:
            menu.addAction(self._actions[name])
            self._actions[name].toggled.connect(self._on_select_toggled)
        self.select.setMenu(menu)
        self.select.setDefaultAction(self._actions["select_box"])
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

    def show_state(self, mode: str, *, playing: bool, recording: bool) -> None:
        """Dress and enable the buttons for a mode (``empty``, ``live``, ``paused``, ``replaying``)."""
        self._state = (mode, playing, recording)
        looks = {
            "pause": ("pause", "Pause") if playing else ("play", "Play"),
            "step": ("step", "Step"),
            "reset": ("reset", "Reset"),
            "record": ("stop", "Stop recording") if recording else ("record", "Record"),
        }
        for name, (shape, text) in looks.items():
            action = self._actions[name]
            colour = self._theme.fault if name == "record" else self._theme.text
            action.setIcon(icon(shape, colour, disabled=mixed(self._theme.panel, self._theme.quiet, 0.65)))
            action.setText(text)
            action.setEnabled(mode in ("live", "paused"))
        faint = mixed(self._theme.panel, self._theme.quiet, 0.65)
        for name in ("poke", *_TOOLS, *_LEADS, *_EDITS, *_BACK_AND_FORTH):
            self._actions[name].setIcon(icon(name, self._theme.text, disabled=faint))
        self._actions["step"].setEnabled(mode == "paused")
        self._actions["pause"].setEnabled(mode != "empty")
        self._actions["record"].setChecked(recording)
        self.speed.setEnabled(mode in ("live", "paused"))

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        mode, playing, recording = self._state
        self.show_state(mode, playing=playing, recording=recording)

    def _on_speed_chosen(self, _index: int) -> None:
        self.speed_chosen.emit(float(self.speed.currentData()))
