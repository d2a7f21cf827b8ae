"""The command palette: all actions, settings and files, found by a few letters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QDialog, QLineEdit, QListWidget, QListWidgetItem, QWidget

from tactile_widgets.common.make import STYLE_SPACING, column_layout, make

MOST = 60
"""Maximum number of listed entries."""
WIDTH = 600
HEIGHT = 420


@dataclass(frozen=True)
class Command:
    """An entry of the palette.

    Attributes:
        text: Name with its menu: ``Edit > Undo``.
        run: Executes the command.
        keys: Shortcut as displayed; empty if there is none.
        tip: Tool tip.
        enabled: Whether it can be executed now; otherwise it is listed and has no effect.
        words: More words by which it is found.
    """

    text: str
    run: Callable[[], object]
    keys: str = ""
    tip: str = ""
    enabled: bool = True
    words: str = ""


def match_score(letters: str, text: str) -> float | None:
    """Return the cost of matching letters in order with a text; None if the text lacks one.

    Letters that begin a word or follow the previous letter cost little, others as much as they skip.
    """
    lowered = text.lower()
    cost = 0.0
    at = -1
    for letter in letters.lower().replace(" ", ""):
        places = [place for place in range(at + 1, len(lowered)) if lowered[place] == letter]
        if not places:
            return None
        if at + 1 in places and at >= 0:
            at += 1
            continue
        starts = [place for place in places if place == 0 or not lowered[place - 1].isalnum()]
        best = starts[0] if starts else places[0]
        cost += 1.0 + (0.0 if starts else 4.0) + 0.02 * (best - at)
        at = best
    return cost + 0.01 * len(text)


def matching(typed: str, commands: Sequence[Command]) -> list[Command]:
    """Return the commands that match the typed text, the best first; all in their order for an empty text."""
    if not typed.strip():
        return list(commands)
    words = typed.lower().split()
    scored: list[tuple[float, int]] = []
    for number, command in enumerate(commands):
        lowered = f"{command.text} {command.words}".lower()
        score = match_score(typed, command.text)
        if all(word in lowered for word in words):
            score = min(score or 0.0, 0.5) + 0.01 * lowered.index(words[0])
        if score is not None:
            scored.append((score + (0 if command.enabled else 0.3), number))
    return [commands[number] for _, number in sorted(scored)]


class CommandPalette(QDialog):
    """A field above a list: letters filter it, Up and Down select, Return executes, Escape cancels."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("palette")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Commands")
        self.setModal(True)
        self._commands: Sequence[Command] = ()
        self._found: list[Command] = []
        placeholder = "Action, setting, scene, robot or file"
        self.field = make(
            QLineEdit, self, objectName="palette-field", placeholderText=placeholder, textChanged=self._on_text_changed
        )
        no_focus = Qt.FocusPolicy.NoFocus
        self.list = make(
            QListWidget, self, objectName="palette-list", focusPolicy=no_focus, itemClicked=self._on_chosen
        )
        self.field.installEventFilter(self)
        column_layout(self.field, self.list, parent=self, spacing=STYLE_SPACING, margins=None)
        self.resize(WIDTH, HEIGHT)

    def ask(self, commands: Sequence[Command]) -> None:
        """Open the palette with these commands."""
        self._commands = commands
        self.field.clear()
        self._on_text_changed("")
        self.open()
        self.field.setFocus()

    @property
    def found(self) -> tuple[Command, ...]:
        """Listed commands, the best first."""
        return tuple(self._found)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move the selection in the list by keys while the field has the focus."""
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
        if not self._found:
            nothing = QListWidgetItem("Nothing found")
            nothing.setFlags(Qt.ItemFlag.NoItemFlags)
            self.list.addItem(nothing)
        self.list.setCurrentRow(next((row for row, command in enumerate(self._found) if command.enabled), 0))

    def _on_chosen(self, item: QListWidgetItem) -> None:
        self._run(self.list.row(item))

    def _run(self, row: int) -> None:
        if 0 <= row < len(self._found) and self._found[row].enabled:
            self.accept()
            self._found[row].run()
