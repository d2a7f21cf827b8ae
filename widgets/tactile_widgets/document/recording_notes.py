"""Annotations of the replayed recording; each edit is saved next to the recording and can be undone."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.editing.history import NO_STEP, Step
from tactile_maps.recording.encoding.annotations import Annotations, save_annotations
from tactile_maps.recording.player import RecordingPlayer


@dataclass(frozen=True, eq=False)
class _NoteStep(Step):
    value: Annotations


class RecordingNotes(QObject):
    """Annotations with undo and redo. Mutable; the recording itself is never written."""

    changed = Signal()
    """Other annotations, or another recording."""
    failed = Signal(str)
    """Reason why annotations could not be read or saved; the previous ones are kept."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._path: Path | None = None
        self._began = ""
        self._steps = [_NoteStep("", Annotations(), number=0)]
        self._at = 0

    def open(self, player: RecordingPlayer) -> None:
        """Show the annotations of a recording; if they cannot be read, they cannot be edited either."""
        try:
            found = player.annotations()
        except TactileMapsError as error:
            self.close()
            self.failed.emit(str(error))
            return
        self._path = player.path
        self._steps = [_NoteStep("", found, number=0)]
        self._at = 0
        self._began = player.began
        self.changed.emit()

    def close(self) -> None:
        """Show no annotations."""
        self._path = None
        self._steps = [_NoteStep("", Annotations(), number=0)]
        self._at = 0
        self.changed.emit()

    @property
    def editable(self) -> bool:
        """True if a recording is open whose annotations can be edited."""
        return self._path is not None

    @property
    def value(self) -> Annotations:
        """Current annotations."""
        return self._steps[self._at].value

    def edit(self, name: str, value: Annotations) -> None:
        """Replace the annotations, and save them.

        Args:
            name: Name of the step in the menu.
            value: The new annotations.
        """
        if self._path is not None and value != self.value and self._keep(value):
            self._steps[self._at + 1 :] = [_NoteStep(name, value)]
            self._at += 1
            self.changed.emit()

    def _keep(self, value: Annotations) -> bool:
        assert self._path is not None
        try:
            save_annotations(self._path, value, of=self._began)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return False
        return True

    # Undo.

    @property
    def can_undo(self) -> bool:
        """True if there is a step to undo."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """True if there is a step to redo."""
        return self._at + 1 < len(self._steps)

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        return self._steps[self._at]

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` applies."""
        return self._steps[self._at + 1] if self.can_redo else NO_STEP

    def undo(self) -> None:
        self._go(-1)

    def redo(self) -> None:
        self._go(1)

    def _go(self, steps: int) -> None:
        at = self._at + steps
        if 0 <= at < len(self._steps) and self._keep(self._steps[at].value):
            self._at = at
            self.changed.emit()
