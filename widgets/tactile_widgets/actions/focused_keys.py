"""Who has the keyboard: a focused control keeps the keys it uses, and gives the keyboard back to the views when done.

Tool keys and other letters act wherever the keyboard is; where text is typed, Qt gives a letter to the text first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QEvent, QObject, Qt, QTimer
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

CONTROLS: tuple[type[QWidget], ...] = (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
)
_COMMITTED = (QAbstractSlider, QAbstractSpinBox, QComboBox, QLineEdit)
"""Return and Escape end with these; a list or a text has other uses for them."""
_RETURN = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class FocusedKeys(QObject):
    """Lets the focused control of a window have the keys it uses, and gives the keyboard back to the views after it.

    Qt asks the focused widget before it looks for a shortcut. A control then says that a yielding key is its own,
    whether it does something with it or not: Backspace on a slider does nothing, and above all does not reset the
    scene. Return presses a focused button, which Qt does only in dialogs.

    The view that had the keyboard last gets it back when a button was clicked with the mouse, when a drop-down closes,
    and at Return or Escape in a slider, a drop-down or a field. Only the widget that has the focus is watched.

    Args:
        window: Whose controls.
        keys: Those of the actions that yield.
        controls: Widgets of our own that take keys.
        views: Who gets the keyboard back; the first until another had it.
    """

    def __init__(
        self,
        window: QWidget,
        keys: Iterable[str],
        controls: tuple[type[QWidget], ...] = (),
        views: Sequence[QWidget] = (),
    ) -> None:
        super().__init__(window)
        self._window = window
        self._keys = {QKeySequence(key).toString() for key in keys}
        self._controls = (*CONTROLS, *controls)
        self._views = tuple(views)
        self._view = views[0] if views else None
        self._watched: QWidget | None = None
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._on_focus_changed)

    def _on_focus_changed(self, before: QWidget | None, now: QWidget | None) -> None:
        if before is not None and before is self._watched:
            before.removeEventFilter(self)
        if now in self._views:
            self._view = now
            self._watched = None
            return
        ours = isinstance(now, self._controls) and now.window() is self._window
        self._watched = now if ours else None
        if self._watched is not None:
            self._watched.installEventFilter(self)
        # The list of a drop-down is a window of its own.
        if isinstance(now, QComboBox) and isinstance(before, QAbstractItemView) and before.window() is not self._window:
            self._give_back_soon()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: a key for the control, or the end of what the control was for."""
        kind = event.type()
        if kind == QEvent.Type.MouseButtonRelease and isinstance(watched, QAbstractButton):
            self._give_back_soon()
        elif isinstance(event, QFocusEvent):
            if (
                event.gotFocus()
                and event.reason() == Qt.FocusReason.PopupFocusReason
                and isinstance(watched, QComboBox)
            ):
                self._give_back_soon()
        elif isinstance(event, QKeyEvent):
            return self._key(watched, event)
        return False

    def _key(self, watched: QObject, event: QKeyEvent) -> bool:
        if event.type() == QEvent.Type.ShortcutOverride and self._yields(event):
            event.accept()
            return True
        if event.type() != QEvent.Type.KeyPress or event.isAutoRepeat() or event.modifiers():
            return False
        if event.key() in _RETURN and isinstance(watched, QAbstractButton):
            watched.click()
            return True
        if event.key() in (*_RETURN, Qt.Key.Key_Escape) and isinstance(watched, _COMMITTED):
            self._give_back_soon()  # once it has done with the key what it does
        return False

    def _give_back_soon(self) -> None:
        """After the event: what is clicked or chosen comes first, and may open something that wants the keyboard."""
        control = self._watched
        QTimer.singleShot(0, self, lambda: self._give_back(control))

    def _give_back(self, control: QWidget | None) -> None:
        now = self._window.focusWidget()
        if self._view is None or control is None or now is None:
            return
        if now is control or now.isAncestorOf(control):  # else it has gone elsewhere by itself
            self._view.setFocus(Qt.FocusReason.OtherFocusReason)

    def _yields(self, event: QKeyEvent) -> bool:
        return QKeySequence(event.keyCombination()).toString() in self._keys
