"""The toolbar: play, step, reset, record, speed, the tools of the hand, and how simulated time keeps up."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QComboBox, QLabel, QMenu, QToolBar, QToolButton, QWidget

from widgets.colours import Theme, mixed
from widgets.icons import icon
from widgets.loading_bar import LoadingBar
from widgets.timeline.playhead import SPEEDS
from widgets.title_label import TitleLabel

_TOOLS = ("select_box", "select_lasso", "select_brush")
_EDITS = ("arrange", "pins", "seams", "interest")
_LEADS = ("draw_path", "set_target")
_BACK_AND_FORTH = ("undo", "redo")
_WIDTHS = {"pause": 88, "step": 78, "reset": 85, "record": 144}
_SELECT_WIDTH = 150
"""Widths of the buttons [px]: enough for the longest word each may show."""


class SessionBar(QToolBar):
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
        self.loading = LoadingBar()
        self.addWidget(self.loading)
        self._title, self.factor = TitleLabel(), QLabel()
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
