"""Gives an action another key: press it; what has that key already is named, and a swap is offered."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QKeySequence
from PySide6.QtWidgets import QHBoxLayout, QLabel, QLineEdit, QPushButton, QVBoxLayout, QWidget

from tactile_widgets.actions.keymap import KeyMap, Keys
from tactile_widgets.actions.registry import key_text

_MODIFIERS = (Qt.Key.Key_Shift, Qt.Key.Key_Control, Qt.Key.Key_Alt, Qt.Key.Key_AltGr, Qt.Key.Key_Meta)
_LOCKS = (Qt.Key.Key_CapsLock, Qt.Key.Key_NumLock, Qt.Key.Key_ScrollLock, Qt.Key.Key_unknown)
_HOW = "Choose an action and press Change, or double-click it, to give it another key."


def pressed_key(event: QKeyEvent) -> str:
    """The key of an event as Qt writes it; empty for a modifier alone. A sign needs no Shift: it is ``?`` alone."""
    key = Qt.Key(event.key())
    if key in (*_MODIFIERS, *_LOCKS):
        return ""
    held = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
    sign = event.text()
    if len(sign) == 1 and sign.isprintable() and not sign.isalnum() and not sign.isspace() and key.value == ord(sign):
        held &= ~Qt.KeyboardModifier.ShiftModifier
    return QKeySequence(held.value | key.value).toString(QKeySequence.SequenceFormat.PortableText)


class KeyField(QLineEdit):
    """Waits for one key, whatever that does elsewhere; Escape and another click give up."""

    pressed = Signal(str)
    """The key, as Qt writes it."""
    given_up = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("keys-field")
        self.setReadOnly(True)
        self.setPlaceholderText("Press the new key")
        self.setAccessibleName("The new key")

    def event(self, event: QEvent) -> bool:
        """Qt: every key comes here, Tab and the window's shortcuts too."""
        if isinstance(event, QKeyEvent):
            if event.type() == QEvent.Type.KeyPress:
                self._take(event)
            event.accept()
            return True
        return super().event(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: something else was clicked."""
        super().focusOutEvent(event)
        self.given_up.emit()

    def _take(self, event: QKeyEvent) -> None:
        if event.key() == Qt.Key.Key_Escape and not event.modifiers():
            self.given_up.emit()
        elif key := pressed_key(event):
            self.pressed.emit(key)


class KeyEditor(QWidget):
    """A line that says what is going on, above the buttons for it.

    Args:
        keymap: The keys now.
        titles: Of the actions, by their names.
        taken: Keys that no action can have, and what they are for.
        parent: Qt parent.
    """

    changed = Signal(KeyMap)
    """The keys that a person wants."""
    done = Signal()
    """Nothing is waited for any more."""

    def __init__(self, keymap: KeyMap, titles: Mapping[str, str], taken: Mapping[str, str], parent: QWidget) -> None:
        super().__init__(parent)
        self._keymap = keymap
        self._titles = titles
        self._taken = taken
        self._name: str | None = None
        self._wanted: KeyMap | None = None
        self.told, self.field = QLabel(_HOW, self), KeyField(self)
        self.told.setObjectName("keys-told")
        self.told.setWordWrap(True)
        self.told.setMinimumHeight(2 * self.fontMetrics().lineSpacing())  # nothing moves when it takes two lines
        self.change = self._button("Change", "Press another key for the chosen action", self.begin)
        self.remove = self._button("No key", "The chosen action is asked for by menu or palette alone", self._remove)
        self.reset = self._button("Reset", "Give the chosen action the key it came with", self._reset)
        self.swap = self._button("Swap", "Take the key; the other action gets the one that is free now", self._take)
        self.keep = self._button("Keep", "Leave both as they are", self.give_up)
        self.reset_all = self._button("Reset all", "Give every action the key it came with", self._reset_all)
        self.field.pressed.connect(self._on_pressed)
        self.field.given_up.connect(self._on_given_up)
        self._lay_out()
        self._show(_HOW)

    def _lay_out(self) -> None:
        buttons = QHBoxLayout()
        for widget in (self.change, self.remove, self.reset, self.field, self.swap, self.keep):
            buttons.addWidget(widget)
        buttons.addStretch(1)
        buttons.addWidget(self.reset_all)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.told)
        column.addLayout(buttons)

    def _button(self, text: str, tip: str, does: object) -> QPushButton:
        button = QPushButton(text, self)
        button.setObjectName(f"keys-{text.lower().replace(' ', '-')}")
        button.setToolTip(tip)
        button.setAutoDefault(False)
        button.clicked.connect(does)
        return button

    @property
    def keymap(self) -> KeyMap:
        """The keys now."""
        return self._keymap

    @keymap.setter
    def keymap(self, keymap: KeyMap) -> None:
        self._keymap = keymap
        self.choose(self._name)

    def choose(self, name: str | None) -> None:
        """Be about another action; None for none."""
        self._name = name
        self._wanted = None
        self._show(_HOW if name is None else f"{self._titles[name]}: {self._words(self._keymap.keys(name))}.")

    def begin(self) -> None:
        """Wait for a key."""
        if self._name is not None:
            self._wanted = None
            self._show(f"Press the new key of {self._titles[self._name]}; Escape leaves it as it is.", waiting=True)
            self.field.setFocus(Qt.FocusReason.OtherFocusReason)

    def give_up(self) -> None:
        """Leave everything as it is."""
        self.choose(self._name)
        self.done.emit()

    def _on_given_up(self) -> None:
        if not self.field.isHidden():
            self.give_up()

    def _on_pressed(self, key: str) -> None:
        if (use := self._taken.get(key)) is not None:
            self.told.setText(f"{key_text(key)} is for {use}. Press another; Escape leaves it as it is.")
        elif self._name is not None:
            self._want(self._name, (key,))

    def _remove(self) -> None:
        if self._name is not None:
            self._want(self._name, ())

    def _reset(self) -> None:
        if self._name is not None:
            self._want(self._name, self._keymap.defaults[self._name])

    def _reset_all(self) -> None:
        self._give(KeyMap(self._keymap.defaults))

    def _want(self, name: str, keys: Keys) -> None:
        """Give them at once where they are free; else say whose they are, and offer to swap."""
        wanted = self._keymap.with_keys(name, keys)
        conflicts = self._keymap.conflicts(name, keys)
        if not conflicts:
            self._give(wanted)
            return
        self._wanted = wanted
        told = [f"{key_text(key)} is the key of {self._titles.get(owner, owner)}" for key, owner in conflicts.items()]
        after = [
            f"{self._titles.get(owner, owner)} then has {self._words(wanted.keys(owner))}"
            for owner in dict.fromkeys(conflicts.values())
        ]
        self._show(f"{', '.join(told)}. Swap? {'; '.join(after)}.")
        self.keep.setFocus(Qt.FocusReason.OtherFocusReason)

    def _take(self) -> None:
        if self._wanted is not None:
            self._give(self._wanted)

    def _give(self, keymap: KeyMap) -> None:
        self.keymap = keymap
        self.changed.emit(keymap)
        self.done.emit()

    def _words(self, keys: Keys) -> str:
        return ", ".join(map(key_text, keys)) or "no key"

    def _show(self, text: str, *, waiting: bool = False) -> None:
        self.told.setText(text)
        asks = self._wanted is not None
        known = self._name is not None
        self.field.setVisible(waiting)
        for button in (self.swap, self.keep):
            button.setVisible(asks)
        for button in (self.change, self.remove, self.reset):
            button.setVisible(not asks and not waiting)
            button.setEnabled(known)
        if self._name is not None:
            self.remove.setEnabled(bool(self._keymap.keys(self._name)))
            self.reset.setEnabled(self._keymap.changed(self._name))
        self.reset_all.setEnabled(bool(self._keymap.changes))
