"""What is said of the recording that is replayed, as a document: each edit is kept beside the recording and undone."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.encoding.annotations import Annotations, save_annotations
from tactile_maps.recording.player import RecordingPlayer


class RecordingNotes(QObject):
    """Annotations and their steps. Mutable; the recording itself is never written."""

    changed = Signal()
    """Other annotations, or another recording."""
    failed = Signal(str)
    """They could not be read or kept; the sentence says why, and what was there stays."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._path: Path | None = None
        self._began = ""
        self._steps: list[tuple[str, Annotations]] = [("", Annotations())]
        self._at = 0

    def open(self, player: RecordingPlayer) -> None:
        """Show what is said of a recording; where that cannot be read, nothing can be said of it."""
        try:
            found = player.annotations()
        except TactileMapsError as error:
            self.close()
            self.failed.emit(str(error))
            return
        self._path = player.path
        self._steps = [("", found)]
        self._at = 0
        self._began = player.began
        self.changed.emit()

    def close(self) -> None:
        """There is no recording any more."""
        self._path = None
        self._steps = [("", Annotations())]
        self._at = 0
        self.changed.emit()

    @property
    def editable(self) -> bool:
        """Whether there is a recording of which something can be said."""
        return self._path is not None

    @property
    def value(self) -> Annotations:
        """What is said now."""
        return self._steps[self._at][1]

    def edit(self, name: str, value: Annotations) -> None:
        """Say this instead, and keep it.

        Args:
            name: Of the step, for people.
            value: All that is said from now on.
        """
        if self._path is not None and value != self.value and self._keep(value):
            self._steps[self._at + 1 :] = [(name, value)]
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
        """Whether there is a step."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was taken back."""
        return self._at + 1 < len(self._steps)

    @property
    def undo_name(self) -> str:
        """The step that ``undo`` takes back."""
        return self._steps[self._at][0]

    @property
    def redo_name(self) -> str:
        """The step that ``redo`` does again."""
        return self._steps[self._at + 1][0] if self.can_redo else ""

    def undo(self) -> None:
        """One step back."""
        self._go(-1)

    def redo(self) -> None:
        """One step on."""
        self._go(1)

    def _go(self, steps: int) -> None:
        at = self._at + steps
        if 0 <= at < len(self._steps) and self._keep(self._steps[at][1]):
            self._at = at
            self.changed.emit()
