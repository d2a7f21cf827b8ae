"""Keys that are the window's, but first those of the control that has the focus: Space, Home, Backspace, Return."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent, QKeySequence
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
_RETURN = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class FocusedKeys(QObject):
    """Lets the focused control of a window have the keys that it would otherwise lose to a shortcut.

    Qt asks the focused widget before it looks for a shortcut. A control then says that the key is its own, whether it
    does something with it or not: Backspace on a slider does nothing, and above all does not reset the scene. Return
    presses a focused button, which Qt does only in dialogs. Only the widget that has the focus is watched.

    Args:
        window: Whose controls.
        keys: Those of the actions that yield.
        controls: Widgets of our own that take keys.
    """

    def __init__(self, window: QWidget, keys: Iterable[str], controls: tuple[type[QWidget], ...] = ()) -> None:
        super().__init__(window)
        self._window, self._keys = window, {QKeySequence(key).toString() for key in keys}
        self._controls = (*CONTROLS, *controls)
        self._watched: QWidget | None = None
        application = QApplication.instance()
        assert isinstance(application, QApplication)
        application.focusChanged.connect(self._on_focus_changed)

    def _on_focus_changed(self, before: QWidget | None, now: QWidget | None) -> None:
        if before is not None and before is self._watched:
            before.removeEventFilter(self)
        ours = isinstance(now, self._controls) and now.window() is self._window
        self._watched = now if ours else None
        if self._watched is not None:
            self._watched.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: a key for the control."""
        if not isinstance(event, QKeyEvent):
            return False
        if event.type() == QEvent.Type.ShortcutOverride and self._yields(event):
            event.accept()
            return True
        pressed = event.type() == QEvent.Type.KeyPress and not event.isAutoRepeat() and not event.modifiers()
        if pressed and event.key() in _RETURN and isinstance(watched, QAbstractButton):
            watched.click()
            return True
        return False

    def _yields(self, event: QKeyEvent) -> bool:
        return QKeySequence(event.keyCombination()).toString() in self._keys
