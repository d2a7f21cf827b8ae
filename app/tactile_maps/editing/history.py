"""Undo and redo: a list of named immutable documents with a current position."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import count

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument

MOST_STEPS = 1000
MOST_BYTES = 2**28
_STEP_BYTES = 4096
"""Memory of a step besides arrays, rounded up [bytes]."""


@dataclass(frozen=True, eq=False)
class Step:
    """A step that can be undone.

    Attributes:
        name: Name shown to the user; empty if there is no step.
        number: Larger than that of every step made before, in this or another history; 0 if there is no step.
    """

    name: str
    number: int = field(default_factory=partial(next, count(1)), kw_only=True)


NO_STEP = Step("", number=0)


@dataclass(frozen=True, eq=False)
class _DocumentStep(Step):
    document: MapDocument


class History:
    """Undo history of a document. Mutable; documents are never copied, so undo returns the same objects.

    A gesture (a drag, a slider) is one step regardless of the number of changes: ``begin``, ``change`` at each mouse
    move, then ``end`` or ``cancel``. Documents other than the current one drop cached values, so that a step only takes
    the memory of its changes.

    Args:
        first: Initial document.
        name: Name of the first step.
        most_steps: Largest number of steps, at least 1; the oldest are dropped first.
        most_bytes: Largest memory of the arrays of all steps [bytes]. The current document is always kept.

    Attributes:
        present: The current document, including an unfinished gesture.
        gesture: Name of the unfinished gesture; empty without one.
    """

    def __init__(
        self, first: MapDocument, *, name: str = "Open", most_steps: int = MOST_STEPS, most_bytes: int = MOST_BYTES
    ) -> None:
        if most_steps < 1:
            raise MapError("a history keeps at least one step", value=most_steps)
        self._most_steps = most_steps
        self._most_bytes = most_bytes
        self._held: Counter[int] = Counter()
        self._bytes = 0
        self._steps: list[_DocumentStep] = []
        self._steps.append(self._count(_DocumentStep(name, first, number=0)))
        self.present = first
        self.gesture = ""
        self.position = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all steps, oldest first, including undone ones; ``position`` is the index of the current step."""
        return tuple(step.name for step in self._steps)

    @property
    def can_undo(self) -> bool:
        """Whether ``undo`` would change anything."""
        return bool(self.gesture) or self.position > 0

    @property
    def can_redo(self) -> bool:
        """Whether ``redo`` would change anything."""
        return not self.gesture and self.position < len(self._steps) - 1

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        return self._steps[self.position] if self.position else NO_STEP

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` repeats."""
        return self._steps[self.position + 1] if self.can_redo else NO_STEP

    def reaches(self, document: MapDocument) -> bool:
        """Whether ``document`` is that of the current step or of an undone one."""
        return any(step.document is document for step in self._steps[self.position :])

    def do(self, name: str, document: MapDocument) -> None:
        """Add ``document`` as a step and drop undone steps. Does nothing if it is the current document.

        Raises:
            MapError: A gesture is in progress.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        if document is self.present:
            return
        while len(self._steps) > self.position + 1:
            self._forget(self._steps.pop())
        self._steps.append(self._count(_DocumentStep(name, document)))
        while len(self._steps) > 1 and (len(self._steps) > self._most_steps + 1 or self._bytes > self._most_bytes):
            self._forget(self._steps.pop(0))
        self.position = len(self._steps) - 1
        self._show(document)

    def refine(self, document: MapDocument) -> None:
        """Replace the document of the current step, for example by a worker's exact result after a drag.

        Raises:
            MapError: A gesture is in progress.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        old = self._steps[self.position]
        self._steps[self.position] = self._count(replace(old, document=document))
        self._forget(old)
        self._show(document)

    def begin(self, name: str) -> None:
        """Start a gesture.

        Raises:
            MapError: Another gesture is in progress.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        self.gesture = name

    def change(self, document: MapDocument) -> None:
        """Set the current document of the gesture.

        Raises:
            MapError: No gesture is in progress.
        """
        if not self.gesture:
            raise MapError("no edit is in progress", remedy="Begin one first")
        self.present = document

    def end(self) -> None:
        """Finish the gesture as one step, or none without a change. Does nothing without a gesture."""
        name = self.gesture
        document = self.present
        self.cancel()
        if name:
            self.do(name, document)

    def cancel(self) -> None:
        """Discard the gesture. Does nothing without one."""
        self.gesture = ""
        self.present = self._steps[self.position].document

    def undo(self) -> MapDocument:
        """Undo a step or the unfinished gesture; return the current document."""
        return self.go(self.position - 1) if not self.gesture and self.can_undo else self._cancelled()

    def redo(self) -> MapDocument:
        """Redo a step if possible; return the current document."""
        return self.go(self.position + 1) if self.can_redo else self.present

    def go(self, position: int) -> MapDocument:
        """Go to any step of ``names`` and cancel a gesture; return the current document.

        Raises:
            MapError: Unknown step.
        """
        if not 0 <= position < len(self._steps):
            raise MapError("unknown step of the history", value=position, remedy=f"0 to {len(self._steps) - 1}")
        self.cancel()
        self.position = position
        self._show(self._steps[position].document)
        return self.present

    def _cancelled(self) -> MapDocument:
        self.cancel()
        return self.present

    def _show(self, document: MapDocument) -> None:
        self.present.release_caches(document)
        self.present = document

    def _count(self, step: _DocumentStep) -> _DocumentStep:
        for array in step.document.arrays():
            self._bytes += array.nbytes if not self._held[id(array)] else 0
            self._held[id(array)] += 1
        self._bytes += _STEP_BYTES
        return step

    def _forget(self, step: _DocumentStep) -> None:
        for array in step.document.arrays():
            self._held[id(array)] -= 1
            if not self._held[id(array)]:
                del self._held[id(array)]
                self._bytes -= array.nbytes
        self._bytes -= _STEP_BYTES
