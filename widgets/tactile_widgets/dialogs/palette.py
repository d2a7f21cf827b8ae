"""The command palette: everything a person can ask for, found by a few of its letters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QListWidget, QListWidgetItem, QVBoxLayout, QWidget

MOST = 60
"""Entries listed at once; a letter more finds the others."""
WIDTH = 600
HEIGHT = 420


@dataclass(frozen=True)
class Command:
    """One entry.

    Attributes:
        text: What it does, with where it belongs: ``Edit > Undo``.
        run: Do it.
        keys: Of it, as a person reads them; empty for none.
        tip: A sentence about it.
        enabled: Whether it can be asked for now; if not, it is listed and does nothing.
    """

    text: str
    run: Callable[[], object]
    keys: str = ""
    tip: str = ""
    enabled: bool = True


def match_score(wanted: str, text: str) -> float | None:
    """How well a text has the letters wanted, in order; less is better, None where it lacks one.

    Letters that begin a word or follow the one before cost nothing, others what they skip.
    """
    told = text.lower()
    cost = 0.0
    at = -1
    for letter in wanted.lower().replace(" ", ""):
        places = [place for place in range(at + 1, len(told)) if told[place] == letter]
        if not places:
            return None
        if at + 1 in places and at >= 0:
            at += 1
            continue
        starts = [place for place in places if place == 0 or not told[place - 1].isalnum()]
        best = starts[0] if starts else places[0]
        cost += 1.0 + (0.0 if starts else 4.0) + 0.02 * (best - at)
        at = best
    return cost + 0.01 * len(text)


def matching(wanted: str, commands: Sequence[Command]) -> list[Command]:
    """The commands whose text has the letters wanted, the best first; all in their order where nothing is wanted."""
    if not wanted.strip():
        return list(commands)
    words = wanted.lower().split()
    scored: list[tuple[float, int]] = []
    for number, command in enumerate(commands):
        told = command.text.lower()
        score = match_score(wanted, command.text)
        if all(word in told for word in words):
            score = min(score or 0.0, 0.5) + 0.01 * told.index(words[0])
        if score is not None:
            scored.append((score + (0 if command.enabled else 0.3), number))
    return [commands[number] for _, number in sorted(scored)]


class CommandPalette(QDialog):
    """A field over a list: letters narrow it, Up and Down choose, Return does it, Escape gives up."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("palette")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Commands")
        self.setModal(True)
        self._commands: Sequence[Command] = ()
        self._found: list[Command] = []
        self.field, self.list = QLineEdit(self), QListWidget(self)
        self.field.setObjectName("palette-field")
        self.field.setPlaceholderText("Action, setting, scene, robot or file")
        self.list.setObjectName("palette-list")
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.field.textChanged.connect(self._on_text_changed)
        self.list.itemClicked.connect(self._on_chosen)
        self.field.installEventFilter(self)
        column = QVBoxLayout(self)
        column.addWidget(self.field)
        column.addWidget(self.list)
        self.resize(WIDTH, HEIGHT)

    def ask(self, commands: Sequence[Command]) -> None:
        """Offer these."""
        self._commands = commands
        self.field.clear()
        self._on_text_changed("")
        self.open()
        self.field.setFocus()

    @property
    def found(self) -> tuple[Command, ...]:
        """What is listed, the best first."""
        return tuple(self._found)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: keys that move in the list, while the field has the keyboard."""
        if not isinstance(event, QKeyEvent) or event.type() != QEvent.Type.KeyPress:
            return False
        steps = {Qt.Key.Key_Down: 1, Qt.Key.Key_Up: -1, Qt.Key.Key_PageDown: 10, Qt.Key.Key_PageUp: -10}
        if event.key() in steps and self.list.count():
            row = min(max(self.list.currentRow() + steps[Qt.Key(event.key())], 0), self.list.count() - 1)
            self.list.setCurrentRow(row)
            return True
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._run(self.list.currentRow())
            return True
        return False

    def _on_text_changed(self, text: str) -> None:
        self._found = matching(text, self._commands)[:MOST]
        self.list.clear()
        for command in self._found:
            item = QListWidgetItem(f"{command.text}    {command.keys}" if command.keys else command.text)
            item.setToolTip(command.tip)
            if not command.enabled:
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEnabled)
            self.list.addItem(item)
        self.list.setCurrentRow(0)

    def _on_chosen(self, item: QListWidgetItem) -> None:
        self._run(self.list.row(item))

    def _run(self, row: int) -> None:
        if 0 <= row < len(self._found) and self._found[row].enabled:
            self.accept()
            self._found[row].run()
