"""Messages in a stack at the lower right of the views, and the first hints in the status line. Neither is modal.

Messages float because a bar that resized the views would move the robot under the pointer that presses it.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QEvent, QObject, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.make import column_layout, make, row_layout
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.jobs.later import call_later

_DOWN = QBoxLayout.Direction.TopToBottom
_RIGHT = QBoxLayout.Direction.LeftToRight
_EDGE = 12
_GAP = 6
_MOST = 3
"""Maximum number of messages shown at a time; the list of messages keeps all."""
READ_SECONDS = 6.0
"""Time for which information without a possible action is shown [s]."""
OFFER_SECONDS = 30.0
"""Time for which information with a possible action is shown [s]."""
_TURNING = {
    NavigationStyle.STANDARD: "Right-drag",
    NavigationStyle.MUJOCO: "Ctrl-drag",
    NavigationStyle.BLENDER: "Middle-drag",
}
"""Gesture that turns the view from any place in it."""
_HINTS = ("Press skin or map: poke", "Tab Control: controllers")
"""The most important actions in one line, after turning the view; the sheet of keys (F1) lists all."""
_HINT_GAP = 8
_HINT_MARGINS = (8, 0, 2, 0)
_TOUR_TIP = "Take the tour: five steps to try in the window; also in Help > Take the tour"


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


@dataclass(frozen=True)
class Message:
    """A message to the user.

    Attributes:
        text: The message, or a question.
        fault: Whether the message is about a failure.
        remedies: Actions that help, shown as up to two buttons.
        dismiss: Text of the button that closes the message.
        of: Operation that the message is about, such as ``"open map"``; a newer message of the same operation, or its
            success, removes this one. Empty for none.
        kept: Whether only its buttons, or ``MessageStack.withdraw``, remove the message.
        pending: Whether the message must still be shown, for example because its remedies help only now; None if only
            the time decides.
        warning: Whether the message is about a doubtful result, which the same operation may correct.
        lasting: Whether its actions do not act on what the window shows, so that it remains when that changes.
    """

    text: str
    fault: bool = False
    remedies: Sequence[QAction] = ()
    dismiss: str = "Dismiss"
    of: str = ""
    kept: bool = False
    pending: Callable[[], bool] | None = None
    warning: bool = False
    lasting: bool = False

    @property
    def outdated(self) -> bool:
        """Whether the message is about what was shown before: failures, warnings, and actions that act on it."""
        return self.fault or self.warning or (bool(self.remedies) and not (self.lasting or self.kept))

    @property
    def informs(self) -> bool:
        """Whether the message is information, not a failure, a warning or a question."""
        return not (self.fault or self.warning or self.kept) and self.dismiss == "Dismiss"

    @property
    def seconds(self) -> float:
        """Time for which the message is shown [s]; infinite if it does not leave by itself now."""
        if not self.informs or (self.pending is not None and self.pending()):
            return math.inf
        offers = self.pending is None and any(action.isEnabled() for action in self.remedies)
        return OFFER_SECONDS if offers else READ_SECONDS


class _Toast(QWidget):
    """A message with its buttons.

    Attributes:
        placed: Whether the message has a place in the stack, where there is room.
        over: Whether the message leaves once the pointer is not over the stack.
        dismissed: Whether one of its buttons was pressed.
    """

    closed = Signal()
    """A button was pressed."""

    def __init__(self, message: Message, shown_at: float, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self.message = message
        self.shown_at = shown_at
        self.placed = False
        self.over = False
        self.dismissed = False
        self.setObjectName("message-bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self.setAccessibleName(message.text)
        self._text = text = make(
            QLabel,
            as_sentence(message.text),
            self,
            objectName="message-text",
            textFormat=Qt.TextFormat.PlainText,  # an error may quote a tag
            wordWrap=True,
            textInteractionFlags=Qt.TextInteractionFlag.TextSelectableByMouse,
        )
        text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self.row = layout = QBoxLayout(_DOWN if message.remedies else _RIGHT, self)
        layout.setContentsMargins(12, 6, 8, 6)
        layout.setSpacing(2)
        layout.addWidget(text, 1)
        buttons = QHBoxLayout()
        buttons.addStretch(1)
        layout.addLayout(buttons)
        for name, action in zip(("message-remedy", "message-second-remedy"), message.remedies, strict=False):
            button = self._button(name)
            button.setDefaultAction(action)
            buttons.addWidget(button)
        close = self._button("message-dismiss")
        close.setText(message.dismiss)
        buttons.addWidget(close)
        self.set_theme(theme)

    def set_text(self, text: str) -> None:
        """Replace the text."""
        self.message = replace(self.message, text=text)
        self._text.setText(as_sentence(text))
        self.setAccessibleName(text)

    def _button(self, name: str) -> QToolButton:
        style = Qt.ToolButtonStyle.ToolButtonTextOnly
        return make(QToolButton, self, objectName=name, toolButtonStyle=style, clicked=self.closed)

    def end(self, *, dismissed: bool = False) -> None:
        """Disable the message, or hide it if it was dismissed; it keeps its place until the stack drops it."""
        self.over = True
        self.dismissed = self.dismissed or dismissed
        self.setEnabled(False)
        keeping = self.sizePolicy()
        keeping.setRetainSizeWhenHidden(self.dismissed)
        self.setSizePolicy(keeping)
        self.setVisible(self.placed and not self.dismissed)

    def set_theme(self, theme: Theme) -> None:
        message = self.message
        edge = theme.fault if message.fault else theme.warning if message.warning else theme.accent
        self.setStyleSheet(
            f"#message-bar {{ background: {mixed(theme.panel, edge, 0.14)}; border: 1px solid {edge};"
            f" border-left: 4px solid {edge}; border-radius: 6px; }}"
        )


class MessageStack(FloatingBar):
    """Shows the newest messages at the lower right of its parent, the newest at the top, so that others do not move.

    Information leaves after ``READ_SECONDS``, after ``OFFER_SECONDS`` if an action that it offers is possible, and not
    while it is pending. Time does not count while the pointer is over the messages. Failures and warnings leave when
    their operation succeeds. ``drop_outdated`` removes them and messages with actions when something else is shown. The
    oldest message leaves for a fourth one, information first. Where not all have room, the newest are shown.

    While the pointer is over the messages, those shown keep their place, because one of their buttons may be aimed at.
    Messages that leave meanwhile are disabled, or hidden if the user dismissed them, and newer ones wait for room.

    Args:
        theme: Colours.
        parent: Widget under the messages.
        clear: Widget at the left that the messages must not cover, except where their buttons have no room.
        clock: Clock [s].
    """

    def __init__(
        self,
        theme: Theme,
        parent: QWidget,
        *,
        clear: QWidget | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(parent, widest=480)
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground, on=False)
        self._clear = clear
        while clear is not None and clear is not parent:
            clear.installEventFilter(self)
            clear = clear.parentWidget()
        self._theme = theme
        self._clock = clock
        self._toasts: list[_Toast] = []
        self._read_at = clock()
        self._read = make(QTimer, self, interval=500, timeout=self._on_read)
        self._column = column_layout(parent=self, spacing=_GAP)
        self.setObjectName("messages")
        self.hide()

    @property
    def messages(self) -> tuple[Message, ...]:
        """The messages that are shown or wait for room, the newest last."""
        return tuple(toast.message for toast in self._toasts if not toast.over)

    @property
    def text(self) -> str:
        """Text of the newest message; empty if none is shown."""
        return as_sentence(self.messages[-1].text) if self.messages else ""

    def show_message(self, message: Message) -> None:
        """Show a message above the others; it replaces those of the same operation, or with the same text."""
        self._remove(
            lambda other: other.text == message.text or bool(message.of and other.of == message.of and not other.kept)
        )
        toast = _Toast(message, self._clock(), self._theme, self)
        toast.closed.connect(self._on_closed)
        self._toasts.append(toast)
        self._column.insertWidget(0, toast)
        self._update()

    def update_fault(self, text: str, of: str) -> None:
        """Replace the text of the failure of an operation, if it is still shown."""
        for toast in self._toasts:
            if toast.message.fault and toast.message.of == of and toast.message.text != text:
                toast.set_text(text)
                self.place()

    def succeed(self, of: str) -> None:
        """Remove the failures and warnings of an operation, which succeeded now."""
        self._remove(lambda message: (message.fault or message.warning) and message.of == of)

    def drop_outdated(self) -> None:
        """Remove the messages about what was shown before; see ``Message.outdated``."""
        self._remove(lambda message: message.outdated)

    def withdraw(self) -> None:
        """Remove the messages that are kept."""
        self._remove(lambda message: message.kept)

    def clear(self) -> None:
        """Remove all messages."""
        self._remove(lambda _message: True)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        for toast in self._toasts:
            toast.set_theme(theme)

    def place(self) -> None:
        """Move and resize the stack to fit the parent, and raise it."""
        if not self._toasts:
            return
        left = 0 if self._clear is None else self._clear.mapTo(self._parent, self._clear.rect().topRight()).x()
        room = self._parent.size() - QSize(2 * _EDGE, 2 * _EDGE)
        narrowest = max(toast.row.minimumSize().width() for toast in self._toasts)
        width = min(max(room.width() - left, narrowest), room.width(), self._widest)
        height = -_GAP
        number = 0
        newest_first = self._toasts[::-1]
        for toast in sorted(self._toasts, key=lambda toast: not toast.placed) if self._held else newest_first:
            higher = height + _GAP + int(toast.row.heightForWidth(width))
            toast.placed = number == 0 or (number < _MOST and higher <= room.height())
            toast.setVisible(toast.placed and not toast.dismissed)
            if toast.placed:
                height = higher
                number += 1
        self.resize(width, min(height, room.height()))
        self.move(self._parent.width() - width - _EDGE, self._parent.height() - self.height() - _EDGE)
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Also follow the widget that must not be covered, which a splitter moves."""
        if watched is not self._parent and event.type() in (QEvent.Type.Move, QEvent.Type.Resize):
            self.place()
        return super().eventFilter(watched, event)

    def leaveEvent(self, event: QEvent) -> None:
        super().leaveEvent(event)
        self._update()

    @property
    def _held(self) -> bool:
        """Whether the pointer is over messages, so that none may move."""
        shown = any(toast.placed and not toast.dismissed for toast in self._toasts)
        return shown and self.isVisible() and self.underMouse()

    def _remove(self, which: Callable[[Message], bool]) -> None:
        found = [toast for toast in self._toasts if not toast.over and which(toast.message)]
        for toast in found:
            toast.end()
        if found:
            self._update()

    def _drop(self, toast: _Toast) -> None:
        self._toasts.remove(toast)
        self._column.removeWidget(toast)
        toast.hide()
        toast.setParent(None)
        toast.deleteLater()

    def _update(self) -> None:
        held = self._held
        # One at a time: hiding the message under the pointer sends a leave event, which updates the list as well.
        while gone := next((toast for toast in self._toasts if toast.over and not (held and toast.placed)), None):
            self._drop(gone)
        while len(self._toasts) > _MOST and not held:
            self._drop(min(self._toasts[:-1], key=lambda toast: _rank(toast.message)))
        self.setVisible(bool(self._toasts))
        if self._toasts:
            self.place()
        if not any(toast.message.informs for toast in self._toasts):
            self._read.stop()
        elif not self._read.isActive():
            self._read.start()

    def _on_closed(self) -> None:
        """Remove the message of the pressed button, unless the action of the button has removed it."""
        pressed = self.sender()
        for toast in self._toasts:
            if toast is pressed:
                toast.end(dismissed=True)
        self._update()

    def _on_read(self) -> None:
        """Remove information that was shown long enough. Time out of view or under the pointer does not count."""
        now = self._clock()
        counts = self.isVisible() and not self.underMouse()
        for toast in self._toasts:
            if not counts:
                toast.shown_at += now - max(toast.shown_at, self._read_at)
            elif now - toast.shown_at >= toast.message.seconds:
                toast.over = True
        self._read_at = now
        self._update()


def _rank(message: Message) -> tuple[bool, bool, bool]:
    """Rank of a message: the lowest leaves first."""
    return message.kept, not message.informs, bool(message.remedies)


class HintBar(FloatingBar):
    """Hints for new users at the left of the status line; hidden once the skin is touched, or when dismissed.

    They are not over the views, because there they would hide the robot or the map, and take no row of their own. Where
    not all of them fit, the last ones are left out; none is cut. The buttons follow the hints, so that they do not move
    when the room ends further left.

    Args:
        theme: Colours.
        parent: The status line.
        clear: Widgets at the right that the hints must not cover.
    """

    dismissed = Signal()
    tour_requested = Signal()

    def __init__(self, theme: Theme, parent: QWidget, *, clear: Sequence[QWidget] = ()) -> None:
        super().__init__(parent, widest=0)
        self._clear = tuple(clear)
        self.setObjectName("hint-bar")
        self._labels = [make(QLabel, self, objectName=f"hint-{number}") for number in range(1, len(_HINTS) + 2)]
        tour = make(
            QToolButton,
            self,
            objectName="hint-tour",
            text="Tour",
            toolTip=_TOUR_TIP,
            clicked=self.tour_requested,
        )
        close = make(QToolButton, self, objectName="hint-dismiss", text="Got it", clicked=self.dismissed)
        row_layout(*self._labels, tour, close, None, parent=self, spacing=_HINT_GAP, margins=_HINT_MARGINS)
        self._parts = (close, tour, *self._labels)
        self.set_navigation(NavigationStyle.STANDARD)
        self.set_theme(theme)

    def set_navigation(self, style: NavigationStyle) -> None:
        """Set the mouse buttons that the hints name."""
        texts = (f"{_TURNING[style]}: turn", *_HINTS)
        for number, (label, text) in enumerate(zip(self._labels, texts, strict=True), start=1):
            label.setText(f"{number}  {text}")
        self.place()

    def place(self) -> None:
        """Show the buttons, and as many hints as fit to the left of the widgets that must not be covered."""
        shown = (part for part in self._clear if part.isVisible())
        kept = (part for part in shown if not isinstance(part, QLabel) or part.text())
        room = min((part.x() for part in kept), default=self._parent.width()) - _HINT_GAP
        needed = sum(_HINT_MARGINS)
        for part in self._parts:
            needed += part.sizeHint().width() + _HINT_GAP
            part.setVisible(needed <= room)
        self.setGeometry(4, 2, room, self._parent.height() - 4)
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if watched is self._parent and event.type() == QEvent.Type.LayoutRequest and self.isVisible():
            call_later(self, self.place)  # after the parent has laid out its parts
        return super().eventFilter(watched, event)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        background = mixed(theme.panel, theme.accent, 0.10)
        self.setStyleSheet(
            f"#hint-bar {{ background: {background}; border: 1px solid {theme.line}; border-radius: 6px; }}"
        )
