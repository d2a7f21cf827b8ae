"""Steps of an editor that can be undone and redone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Generic, TypeVar

from tactile_maps.editing.history import NO_STEP, Step

V = TypeVar("V")


@dataclass(frozen=True, eq=False)
class Change(Step, Generic[V]):
    """A step that stores the previous and the new value."""

    before: V
    after: V


class StepList(Generic[V]):
    """Steps in their order, and the current position among them. Mutable.

    Args:
        most: Largest number of steps; the oldest are discarded first.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._steps: list[Change[V]] = []
        self._position = 0

    def reset(self) -> None:
        """Discard all steps."""
        self._steps = []
        self._position = 0

    @property
    def undo_step(self) -> Step:
        """The step that ``back`` reverts."""
        return self._steps[self._position - 1] if self._position else NO_STEP

    @property
    def redo_step(self) -> Step:
        """The step that ``forward`` repeats."""
        return self._steps[self._position] if self._position < len(self._steps) else NO_STEP

    @property
    def done_steps(self) -> list[Change[V]]:
        """The steps that are not undone, oldest first."""
        return self._steps[: self._position]

    def push(self, name: str, before: V, after: V, *, extend: bool = False) -> None:
        """Add a step and discard undone ones; with ``extend``, merge it with a last step of the same name."""
        self.discard_undone()
        if extend and self.undo_step.name == name:
            before = self._steps.pop().before
        self._steps = [*self._steps, Change(name, before, after)][-self._most :]
        self._position = len(self._steps)

    def discard_undone(self) -> None:
        """Discard the steps after the current position."""
        del self._steps[self._position :]

    def back(self) -> V:
        """Return the previous value of the last step, which is then undone."""
        self._position -= 1
        return self._steps[self._position].before

    def forward(self) -> V:
        """Return the new value of the first undone step, which is then redone."""
        self._position += 1
        return self._steps[self._position - 1].after
