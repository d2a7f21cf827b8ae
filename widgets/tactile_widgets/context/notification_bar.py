"""Floating bars: one message at a time at the lower right of the views, and the first hints. Neither is modal.

They float because a bar that resized the views would move the robot under the pointer that presses it.
"""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QHideEvent, QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.sentence import as_sentence

_EDGE = 12
_READ_MS = 6_000
"""Time for which a message is shown that neither reports a failure nor asks something [ms]."""
HINTS = ("Right-drag: turn the view", "Press skin or map: poke", "Tab Control: choose a controller")
"""The most important actions in one line; the sheet of keys (F1) lists all."""


class FloatingBar(QWidget):
    """A bar at the top centre of its parent.

    Args:
        parent: Widget under the bar.
        widest: Maximum width [px]; the parent may leave less.
    """

    def __init__(self, parent: QWidget, *, widest: int) -> None:
        super().__init__(parent)
        self._parent = parent
        self._widest = widest
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        parent.installEventFilter(self)

    def place(self) -> None:
        """Move and resize the bar to fit the parent, and raise it."""
        width = min(self._parent.width() - 2 * _EDGE, self._widest)
        height = self.heightForWidth(width) if self.hasHeightForWidth() else self.sizeHint().height()
        self.move((self._parent.width() - width) // 2, _EDGE)
        self.resize(width, height)
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self._parent and event.type() == QEvent.Type.Resize:
            self.place()
        return False

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.place()


class NotificationBar(FloatingBar):
    """Shows a message at the lower right of its parent until it is read, closed or replaced.

    Information is hidden after some time unless the pointer is over it; failures and questions remain.

    Args:
        theme: Colours.
        parent: Widget under the bar.
        clear: Widget at the left that the bar must not cover.
    """

    def __init__(self, theme: Theme, parent: QWidget, *, clear: QWidget | None = None) -> None:
        super().__init__(parent, widest=560)
        self._clear = clear
        self._leaves = False
        self._read = QTimer(self)
        self._read.setInterval(_READ_MS)
        self._read.timeout.connect(self._on_read)
        self.setObjectName("message-bar")
        self._theme = theme
        self._fault = False
        self._shown_count = 0
        self._pressed_count = 0  # of shown messages, when a button was last pressed
        self._offered: tuple[str, Sequence[QAction], str] | None = None
        self._text = QLabel(self)
        self._text.setObjectName("message-text")
        self._text.setTextFormat(Qt.TextFormat.PlainText)  # an error may quote a tag
        self._text.setWordWrap(True)
        self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self._remedies = [self._make_button("message-remedy"), self._make_button("message-second-remedy")]
        self._close = self._make_button("message-dismiss")
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 6, 8, 6)
        layout.addWidget(self._text)
        for button in (*self._remedies, self._close):
            layout.addWidget(button)
        self.hide()

    @property
    def text(self) -> str:
        """Text of the message; empty if none is shown."""
        return self._text.text() if not self.isHidden() else ""

    def say(
        self, text: str, *, fault: bool = False, remedies: Sequence[QAction] = (), dismiss: str = "Dismiss"
    ) -> None:
        """Show a message.

        Args:
            text: The message, or a question.
            fault: Whether the message is about a failure.
            remedies: Actions that help, shown as up to two buttons.
            dismiss: Text of the button that closes the message.
        """
        self._shown_count += 1
        self._text.setText(as_sentence(text))
        for number, button in enumerate(self._remedies):
            for action in button.actions():
                button.removeAction(action)
            if number < len(remedies):
                button.setDefaultAction(remedies[number])
            button.setVisible(number < len(remedies))
        self._close.setText(dismiss)
        self._fault = fault
        self._leaves = not fault and dismiss == "Dismiss"
        self._time_out()
        self.setAccessibleName(text)
        self._update_state()
        self.show()
        self.place()

    def offer(self, text: str, *, remedies: Sequence[QAction], dismiss: str) -> None:
        """Show a message that returns after others until one of its buttons is pressed, or until ``withdraw``."""
        self._offered = text, remedies, dismiss
        self.say(text, remedies=remedies, dismiss=dismiss)

    def place(self) -> None:
        """Move and resize the bar to fit the parent, and raise it."""
        left = 0 if self._clear is None else self._clear.mapTo(self._parent, self._clear.rect().topRight()).x()
        width = min(self._parent.width() - left - 2 * _EDGE, self._widest)
        height = self.heightForWidth(width) if self.hasHeightForWidth() else self.sizeHint().height()
        self.resize(width, height)
        self.move(self._parent.width() - width - _EDGE, self._parent.height() - height - _EDGE)
        self.raise_()

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._time_out()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self._read.stop()

    def _time_out(self) -> None:
        self._read.stop()
        if self._leaves and self.isVisible():
            self._read.start()

    def forget_fault(self) -> None:
        """Hide the message of a failure, because it is outdated."""
        if self._fault and self.text:
            self._show_next()

    def _on_read(self) -> None:
        if not self.underMouse():
            self._show_next()

    def withdraw(self) -> None:
        """Hide the offer."""
        if self._offered is not None and self._text.text() == self._offered[0]:
            self.hide()
        self._offered = None

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._update_state()

    def _make_button(self, name: str) -> QToolButton:
        button = QToolButton(self)
        button.setObjectName(name)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        button.pressed.connect(self._on_pressed)
        button.clicked.connect(self._on_clicked)
        return button

    def _on_pressed(self) -> None:
        self._pressed_count = self._shown_count

    def _on_clicked(self) -> None:
        """Hide the message unless the pressed action has shown another one; then show a waiting offer."""
        if self._pressed_count == self._shown_count:
            self._show_next()

    def _show_next(self) -> None:
        """Hide the message; show a waiting offer."""
        self.hide()
        if self._offered is None:
            return
        text, remedies, dismiss = self._offered
        if self._text.text() == text:
            self._offered = None
        else:
            self.say(text, remedies=remedies, dismiss=dismiss)

    def _update_state(self) -> None:
        edge = self._theme.fault if self._fault else self._theme.accent
        background = mixed(self._theme.panel, edge, 0.14)
        self.setStyleSheet(
            f"#message-bar {{ background: {background}; border: 1px solid {edge}; border-left: 4px solid {edge};"
            " border-radius: 6px; }"
        )


class HintBar(FloatingBar):
    """Hints for new users, over a row that is not needed at first; hidden once the skin is touched, or when dismissed.

    They are not over the views, because there they would hide the robot or the map.
    """

    dismissed = Signal()
    tour_requested = Signal()

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent, widest=0)
        self.setObjectName("hint-bar")
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 0, 6, 0)
        layout.setSpacing(12)
        for number, text in enumerate(HINTS, start=1):
            label = QLabel(f"{number}  {text}", self)
            label.setObjectName(f"hint-{number}")
            label.setWordWrap(True)
            layout.addWidget(label, 1)
        tour = QToolButton(self)
        tour.setText("Take the tour")
        tour.setToolTip("Five steps to try in the window; also in Help > Take the tour")
        tour.setObjectName("hint-tour")
        tour.clicked.connect(self.tour_requested)
        layout.addWidget(tour)
        close = QToolButton(self)
        close.setText("Got it")
        close.setObjectName("hint-dismiss")
        close.clicked.connect(self.dismissed)
        layout.addWidget(close)
        self.set_theme(theme)

    def place(self) -> None:
        """Fill the parent."""
        self.setGeometry(self._parent.rect().adjusted(0, 3, 0, -3))
        self.raise_()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        background = mixed(theme.panel, theme.accent, 0.10)
        self.setStyleSheet(
            f"#hint-bar {{ background: {background}; border: 1px solid {theme.line}; border-radius: 6px; }}"
        )
