"""Editor of shortcuts: it records the pressed key, names the action that already has it, and offers to swap."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QLabel, QLineEdit, QPushButton, QWidget

from tactile_widgets.actions.keymap import KeyMap, Keys
from tactile_widgets.actions.registry import key_text
from tactile_widgets.common.make import STYLE_SPACING, column_layout, push_button, row_layout

_MODIFIERS = (Qt.Key.Key_Shift, Qt.Key.Key_Control, Qt.Key.Key_Alt, Qt.Key.Key_AltGr, Qt.Key.Key_Meta)
_LOCKS = (Qt.Key.Key_CapsLock, Qt.Key.Key_NumLock, Qt.Key.Key_ScrollLock, Qt.Key.Key_unknown)
_HOW = "Choose an action and press Change, or double-click it, to give it another key."


def pressed_key(event: QKeyEvent) -> str:
    """Return the key of an event in Qt's notation; empty for a modifier alone. Punctuation has no Shift: ``?``."""
    key = Qt.Key(event.key())
    if key in (*_MODIFIERS, *_LOCKS):
        return ""
    held = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
    sign = event.text()
    if len(sign) == 1 and sign.isprintable() and not sign.isalnum() and not sign.isspace() and key.value == ord(sign):
        held &= ~Qt.KeyboardModifier.ShiftModifier
    return QKeySequence(held | key).toString(QKeySequence.SequenceFormat.PortableText)


class KeyField(QLineEdit):
    """Field that records one key, including shortcuts; Escape and a click elsewhere cancel."""

    pressed = Signal(str)
    """Pressed key in Qt's notation."""
    cancelled = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("keys-field")
        self.setReadOnly(True)
        self.setPlaceholderText("Press the new key")
        self.setAccessibleName("The new key")

    def event(self, event: QEvent) -> bool:
        """Receive every key, including Tab and the shortcuts of the window."""
        if isinstance(event, QKeyEvent):
            if event.type() == QEvent.Type.KeyPress:
                self._take(event)
            event.accept()
            return True
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Cancel after a click elsewhere."""
        super().focusOutEvent(event)
        self.cancelled.emit()

    def _take(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and not event.modifiers():
            self.cancelled.emit()
        elif key := pressed_key(event):
            self.pressed.emit(key)


class KeyEditor(QWidget):
    """Message above the buttons that change the shortcut of the selected action.

    Args:
        keymap: Current shortcuts.
        titles: Title of each action by name.
        reserved: Keys that cannot be shortcuts, each with its use.
        parent: Qt parent.

    Attributes:
        keymap: Current shortcuts.
    """

    changed = Signal(KeyMap)
    """Changed shortcuts."""
    done = Signal()
    """No key is awaited any more."""

    def __init__(self, keymap: KeyMap, titles: Mapping[str, str], reserved: Mapping[str, str], parent: QWidget) -> None:
        super().__init__(parent)
        self.keymap = keymap
        self._titles = titles
        self._reserved = reserved
        self._name: str | None = None
        self._proposed: KeyMap | None = None
        self.message = QLabel(_HOW, self)
        self.field = KeyField(self)
        self.message.setObjectName("keys-told")
        self.message.setWordWrap(True)
        self.message.setMinimumHeight(2 * self.fontMetrics().lineSpacing())  # room for two lines, so that nothing moves
        self.change = self._button("Change", "Press a new key for the selected action", self.begin)
        self.remove = self._button("No key", "Remove the shortcut of the selected action", self._remove)
        self.reset = self._button("Reset", "Restore the default key of the selected action", self._reset)
        self.swap = self._button("Swap", "Use the key; the other action gets the key that becomes free", self._swap)
        self.keep = self._button("Keep", "Change neither action", self.cancel)
        self.reset_all = self._button("Reset all", "Restore the default keys of all actions", self._reset_all)
        self.field.pressed.connect(self._on_pressed)
        self.field.cancelled.connect(self._on_cancelled)
        self._lay_out()
        self._show(_HOW)

    def _lay_out(self) -> None:
        row = (self.change, self.remove, self.reset, self.field, self.swap, self.keep, None, self.reset_all)
        buttons = row_layout(*row, spacing=STYLE_SPACING)
        column_layout(self.message, buttons, parent=self, spacing=STYLE_SPACING)

    def _button(self, text: str, tip: str, handler: object) -> QPushButton:
        return push_button(self, f"keys-{text.lower().replace(' ', '-')}", text, tip, handler, autoDefault=False)

    def choose(self, name: str | None) -> None:
        """Show the keys of an action, or with None how to choose one."""
        self._name = name
        self._proposed = None
        self._show(_HOW if name is None else f"{self._titles[name]}: {self._words(self.keymap.keys(name))}.")

    def begin(self) -> None:
        """Record a key."""
        if self._name is not None:
            self._proposed = None
            self._show(f"Press the new key of {self._titles[self._name]}; Escape keeps the current key.", waiting=True)
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)

    def cancel(self) -> None:
        """Change nothing."""
        self.choose(self._name)
        self.done.emit()

    def _on_cancelled(self) -> None:
        if not self.field.isHidden():
            self.cancel()

    def _on_pressed(self, key: str) -> None:
        if (use := self._reserved.get(key)) is not None:
            self.message.setText(f"{key_text(key)} is reserved for {use}. Press another; Escape keeps the current key.")
        elif self._name is not None:
            self._propose(self._name, (key,))

    def _remove(self) -> None:
        if self._name is not None:
            self._propose(self._name, ())

    def _reset(self) -> None:
        if self._name is not None:
            self._propose(self._name, self.keymap.defaults[self._name])

    def _reset_all(self) -> None:
        self._set(KeyMap(self.keymap.defaults))

    def _propose(self, name: str, keys: Keys) -> None:
        """Set keys that are free; for others, name their actions and offer to swap."""
        proposed = self.keymap.with_keys(name, keys)
        conflicts = self.keymap.conflicts(name, keys)
        if not conflicts:
            self._set(proposed)
            return
        self._proposed = proposed
        owners = [f"{key_text(key)} is the key of {self._titles.get(owner, owner)}" for key, owner in conflicts.items()]
        after = [
            f"{self._titles.get(owner, owner)} then has {self._words(proposed.keys(owner))}"
            for owner in dict.fromkeys(conflicts.values())
        ]
        self._show(f"{', '.join(owners)}. Swap? {'; '.join(after)}.")
        self.keep.setFocus(Qt.FocusReason.OtherFocusReason)

    def _swap(self) -> None:
        if self._proposed is not None:
            self._set(self._proposed)

    def _set(self, keymap: KeyMap) -> None:
        self.keymap = keymap
        self.choose(self._name)
        self.changed.emit(keymap)
        self.done.emit()

    def _words(self, keys: Keys) -> str:
        return ", ".join(map(key_text, keys)) or "no key"

    def _show(self, text: str, *, waiting: bool = False) -> None:
        self.message.setText(text)
        conflict = self._proposed is not None
        known = self._name is not None
        self.field.setVisible(waiting)
        for button in (self.swap, self.keep):
            button.setVisible(conflict)
        for button in (self.change, self.remove, self.reset):
            button.setVisible(not conflict and not waiting)
            button.setEnabled(known)
        if self._name is not None:
            self.remove.setEnabled(bool(self.keymap.keys(self._name)))
            self.reset.setEnabled(self.keymap.changed(self._name))
        self.reset_all.setEnabled(bool(self.keymap.changes))
