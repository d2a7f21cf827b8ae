"""Toolbar: play, step, reset, record, speed, and tools in named groups.

In a narrower window first the names of the groups are hidden, then the texts of the buttons; buttons that still do not
fit move into the extension menu of Qt.
"""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QAction, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QComboBox, QMenu, QToolBar, QToolButton, QWidget, QWidgetAction

from tactile_widgets.actions.registry import ActionRegistry
from tactile_widgets.actions.state import WindowState
from tactile_widgets.common.make import add_items, caption_label, make, select_data
from tactile_widgets.plots.timeline.playhead import SPEEDS

_WIDTHS = {"pause": 88, "step": 78, "reset": 85, "record": 144, "poke": 92}
_SELECT_WIDTH = 150
"""Widths of the buttons with texts, sufficient for their longest text [px]."""
_ICON_WIDTH = 34
_MENU_WIDTH = 16
"""Widths of a button without text, and of the arrow that opens its menu [px]."""


class SessionToolbar(QToolBar):
    """Toolbar with the buttons of actions, and the speed.

    Args:
        actions: The window's actions.
        parent: Qt parent.
    """

    speed_chosen = Signal(float)
    """Simulated seconds per second requested."""

    def __init__(self, actions: ActionRegistry, parent: QWidget | None = None) -> None:
        super().__init__("Session", parent)
        self.setObjectName("toolbar")
        self._actions = actions
        self._captions = list[QAction]()
        self.setMovable(False)
        self.setIconSize(QSize(16, 16))
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.PreventContextMenu)
        self._add_buttons("session")
        self.addSeparator()
        self.addWidget(self._make_speed())
        self._add_caption("Touch")
        self._add_buttons("poke")
        self._add_caption("Select")
        self.addWidget(self._make_select())
        self._add_caption("Task")
        self._add_buttons("control", text=False)
        self._add_caption("Map")
        self._add_buttons("edit", text=False)
        self._add_buttons("undo", text=False)
        self._full = 0  # width with names and texts
        self._names = 0  # of that, the width of the names
        self.show_state(WindowState())

    def _add_buttons(self, group: str, *, text: bool = True) -> None:
        for spec in self._actions.in_toolbar(group):
            action = self._actions[spec.name]
            self.addAction(action)
            button = self._button(spec.name)
            if text:
                # Fixed widths: a button that changes its text must not move its neighbours.
                button.setFixedWidth(_WIDTHS[spec.name])
            else:
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            button.setAccessibleName(spec.text)

    def _add_caption(self, text: str) -> None:
        """Begin a group of buttons with its name."""
        self.addSeparator()
        label = caption_label(self, f"toolbar-{text.lower()}", text)
        label.setContentsMargins(4, 0, 0, 0)
        # Made here, not by QToolBar.addWidget: PySide may mistake an object that Qt made for one that was at the same
        # address in a window that is gone, and invalidates it with that window.
        caption = QWidgetAction(self)
        caption.setDefaultWidget(label)
        self.addAction(caption)
        self._captions.append(caption)

    def _button(self, name: str) -> QToolButton:
        """Return the button of an action; it is looked up each time for the same reason."""
        button = self.widgetForAction(self._actions[name])
        assert isinstance(button, QToolButton)
        return button

    def _make_speed(self) -> QComboBox:
        tip = "Requested speed relative to real time"
        self.speed = make(QComboBox, objectName="speed", accessibleName="Simulation speed", toolTip=tip)
        add_items(self.speed, ((f"{speed:g}×", speed, "") for speed in SPEEDS))
        select_data(self.speed, 1.0)
        self.speed.currentIndexChanged.connect(self._on_speed_chosen)
        return self.speed

    def _make_select(self) -> QToolButton:
        """Return one button for all selection tools: it shows the last one, and its menu lists all."""
        self.select = make(
            QToolButton,
            objectName="select",
            accessibleName="Select taxels",
            popupMode=QToolButton.ToolButtonPopupMode.MenuButtonPopup,
            toolButtonStyle=Qt.ToolButtonStyle.ToolButtonTextBesideIcon,
            iconSize=self.iconSize(),
        )
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

    @property
    def has_text(self) -> bool:
        """Whether the texts of the buttons fit."""
        return self.width() >= self._full - self._names

    def showEvent(self, event: QShowEvent) -> None:
        """Measure the buttons, whose size is known only once their style is applied."""
        if not self._full:
            self._full = self.sizeHint().width()
            self._names = sum(self.widgetForAction(caption).sizeHint().width() for caption in self._captions)
        super().showEvent(event)
        self._update_texts()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Show or hide the texts."""
        super().resizeEvent(event)
        self._update_texts()

    def _update_texts(self) -> None:
        styles = Qt.ToolButtonStyle
        style = styles.ToolButtonTextBesideIcon if self.has_text else styles.ToolButtonIconOnly
        for caption in self._captions:
            caption.setVisible(self.width() >= self._full)
        buttons = [(self._button(name), width, _ICON_WIDTH) for name, width in _WIDTHS.items()]
        for button, wide, narrow in [*buttons, (self.select, _SELECT_WIDTH, _ICON_WIDTH + _MENU_WIDTH)]:
            if button.toolButtonStyle() is not style:
                button.setToolButtonStyle(style)
                button.setFixedWidth(wide if self.has_text else narrow)

    def show_state(self, state: WindowState) -> None:
        """Disable the speed during a replay, which has its own."""
        self.speed.setEnabled(state.mode.takes_input)

    def _on_speed_chosen(self, _index: int) -> None:
        self.speed_chosen.emit(float(self.speed.currentData()))
