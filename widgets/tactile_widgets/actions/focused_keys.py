"""Keyboard focus: a focused control keeps the keys it uses, and returns the focus to the views afterwards.

Shortcuts of single letters work wherever the focus is, except where text is typed: Qt inserts the letter there.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDockWidget,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)

from tactile_widgets.jobs.later import call_later

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
"""Controls that return the focus at Return and Escape; lists and texts use these keys themselves."""
_RETURN = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class FocusedKeys(QObject):
    """Passes yielding keys to the focused control of a window, and returns the focus to the views afterwards.

    Qt offers a key to the focused widget before it searches for a shortcut. A control then accepts yielding keys,
    whether it uses them or not: Backspace on a slider does nothing, and in particular does not reset the scene. Return
    presses a focused button, which Qt does only in dialogs.

    The view that had the focus last receives it again after a mouse click on a button, after a drop-down closes, and
    at Return or Escape in a slider, a drop-down or a field; also once a focused button is disabled or hidden, because
    Qt then moves the focus to the next control, whose action Space would start. Only the focused widget is watched.

    Panels that float in windows of their own are parts of the window.

    Args:
        window: Window of the controls.
        keys: Shortcuts of the yielding actions.
        controls: Additional classes of widgets that use keys.
        views: Views that receive the focus; the first one, until another one had it.
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
        unusable = False
        if before is not None and before is self._watched:
            before.removeEventFilter(self)
            unusable = isinstance(before, QAbstractButton) and not (before.isEnabled() and before.isVisible())
        if now in self._views:
            self._view = now
            self._watched = None
            return
        self._watched = now if isinstance(now, self._controls) and self._contains(now) else None
        if self._watched is not None:
            self._watched.installEventFilter(self)
        list_closed = (
            isinstance(now, QComboBox)
            and isinstance(before, QAbstractItemView)
            and before.window() is not now.window()  # the list of a drop-down is a window of its own
        )
        if unusable or list_closed:
            self._return_focus_soon()

    def _contains(self, widget: QWidget) -> bool:
        window = widget.window()
        return window is self._window or (isinstance(window, QDockWidget) and window.parentWidget() is self._window)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Pass a key to the control, or return the focus after its use."""
        kind = event.type()
        if kind == QEvent.Type.MouseButtonRelease and isinstance(watched, QAbstractButton):
            self._return_focus_soon()
        elif isinstance(event, QFocusEvent):
            if (
                event.gotFocus()
                and event.reason() == Qt.FocusReason.PopupFocusReason
                and isinstance(watched, QComboBox)
            ):
                self._return_focus_soon()
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
            self._return_focus_soon()  # after the control has handled the key
        return False

    def _return_focus_soon(self) -> None:
        """Return the focus after the event, which may open a widget that takes the focus itself."""
        control = self._watched
        call_later(self, lambda: self._return_focus(control))

    def _return_focus(self, control: QWidget | None) -> None:
        now = None if control is None else control.window().focusWidget()
        if self._view is None or control is None or now is None:
            return
        if now is control or now.isAncestorOf(control):  # otherwise another widget has taken the focus
            self._window.activateWindow()  # a panel that floats may be active
            self._view.setFocus(Qt.FocusReason.OtherFocusReason)

    def _yields(self, event: QKeyEvent) -> bool:
        return QKeySequence(event.keyCombination()).toString() in self._keys
