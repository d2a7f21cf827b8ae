"""Undo and redo: a list of immutable documents with names, and where in it we are."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument

MOST_STEPS = 1000
MOST_BYTES = 2**28
_STEP_BYTES = 4096
"""What a step takes besides arrays, rounded up."""


@dataclass(frozen=True, eq=False)
class _Step:
    name: str
    document: MapDocument


class History:
    """The documents so far. Mutable; nothing in a document is ever copied, and undone documents come back themselves.

    A gesture (a drag, a slider) is one step however often it changes the document: ``begin``, ``change`` at each move
    of the mouse, then ``end`` or ``cancel``. Documents that are not the present let go of all that can be computed
    again, so that a step costs what it changed.

    Args:
        first: Where it starts; everything undone, it is the present again.
        name: What the first step is called in a list.
        most_steps: More are forgotten, the oldest first; at least 1.
        most_bytes: Likewise, for the arrays that all steps hold together [bytes]. The present is always kept.

    Attributes:
        present: The document as it is now, in a gesture as far as it has gone.
        gesture: The name of the gesture that is going on; empty if there is none.
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
        self._steps: list[_Step] = []
        self._steps.append(self._count(_Step(name, first)))
        self.present = first
        self.gesture = ""
        self.position = 0

    @property
    def names(self) -> tuple[str, ...]:
        """Of all steps, oldest first, those that could be redone too; ``position`` is the present's."""
        return tuple(step.name for step in self._steps)

    @property
    def bytes(self) -> int:
        """That all steps take together; what steps share counts once."""
        return self._bytes

    @property
    def can_undo(self) -> bool:
        """Whether ``undo`` would change anything."""
        return bool(self.gesture) or self.position > 0

    @property
    def can_redo(self) -> bool:
        """Whether ``redo`` would change anything."""
        return not self.gesture and self.position < len(self._steps) - 1

    def do(self, name: str, document: MapDocument) -> None:
        """``document`` is the present from now on; what was undone is forgotten. Nothing if it is the present already.

        Raises:
            MapError: A gesture is going on.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        if document is self.present:
            return
        while len(self._steps) > self.position + 1:
            self._forget(self._steps.pop())
        self._steps.append(self._count(_Step(name, document)))
        while len(self._steps) > 1 and (len(self._steps) > self._most_steps + 1 or self._bytes > self._most_bytes):
            self._forget(self._steps.pop(0))
        self.position = len(self._steps) - 1
        self._show(document)

    def refine(self, document: MapDocument) -> None:
        """A better version of what the present step did, as a worker's exact result after a drag: no step of its own.

        Raises:
            MapError: A gesture is going on.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        old = self._steps[self.position]
        self._steps[self.position] = self._count(_Step(old.name, document))
        self._forget(old)
        self._show(document)

    def begin(self, name: str) -> None:
        """A gesture starts.

        Raises:
            MapError: One is going on already.
        """
        if self.gesture:
            raise MapError("an edit is in progress", value=self.gesture, remedy="Finish or cancel it first")
        self.gesture = name

    def change(self, document: MapDocument) -> None:
        """The gesture's document so far.

        Raises:
            MapError: There is no gesture.
        """
        if not self.gesture:
            raise MapError("no edit is in progress", remedy="Begin one first")
        self.present = document

    def end(self) -> None:
        """The gesture is done: one step, or none if it changed nothing. Nothing without a gesture."""
        name = self.gesture
        document = self.present
        self.cancel()
        if name:
            self.do(name, document)

    def cancel(self) -> None:
        """The gesture never was. Nothing without a gesture."""
        self.gesture = ""
        self.present = self._steps[self.position].document

    def undo(self) -> MapDocument:
        """One step back, or out of the gesture that is going on; the present."""
        return self.go(self.position - 1) if not self.gesture and self.can_undo else self._cancelled()

    def redo(self) -> MapDocument:
        """One step on, if there is one; the present."""
        return self.go(self.position + 1) if self.can_redo else self.present

    def go(self, position: int) -> MapDocument:
        """To any step of ``names``, a gesture being cancelled; the present.

        Raises:
            MapError: There is no such step.
        """
        if not 0 <= position < len(self._steps):
            raise MapError("there is no such step", value=position, remedy=f"0 to {len(self._steps) - 1}")
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

    def _count(self, step: _Step) -> _Step:
        for array in step.document.arrays():
            self._bytes += array.nbytes if not self._held[id(array)] else 0
            self._held[id(array)] += 1
        self._bytes += _STEP_BYTES
        return step

    def _forget(self, step: _Step) -> None:
        for array in step.document.arrays():
            self._held[id(array)] -= 1
            if not self._held[id(array)]:
                del self._held[id(array)]
                self._bytes -= array.nbytes
        self._bytes -= _STEP_BYTES
