"""What was drawn so far, without Qt: undo and redo of paths, targets and forces, beside that of the map.

A step changes a few settings and remembers only those: what was turned in the controller panel in between stays as it
is when the step is taken back.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from app.control.command import ControlSettings

MOST_STEPS = 200


@dataclass(frozen=True)
class Wish:
    """One step.

    Attributes:
        name: For people, a verb.
        before: The settings it changed, as they were.
        after: And as they became.
    """

    name: str
    before: dict[str, Any]
    after: dict[str, Any]


class Wishes:
    """The steps, and where in them we are. Mutable; ``reset`` forgets all."""

    def __init__(self) -> None:
        self._steps: list[Wish] = []
        self._position = 0

    def reset(self) -> None:
        """Nothing can be taken back or done again."""
        self._steps, self._position = [], 0

    @property
    def undo_name(self) -> str:
        """What ``undo`` takes back; empty for nothing."""
        return self._steps[self._position - 1].name if self._position else ""

    @property
    def redo_name(self) -> str:
        """What ``redo`` does again; empty for nothing."""
        return self._steps[self._position].name if self._position < len(self._steps) else ""

    def done(self, name: str, before: ControlSettings, after: ControlSettings, *, goes_on: bool = False) -> None:
        """A step was made; what had been taken back is forgotten. Nothing where nothing changed.

        Args:
            name: For people.
            before: All settings before it.
            after: And after.
            goes_on: Whether it makes one step with the last, where that has its name and changed the same settings.
        """
        names = [f.name for f in fields(after) if getattr(before, f.name) != getattr(after, f.name)]
        if not names:
            return
        step = Wish(name, *({known: getattr(each, known) for known in names} for each in (before, after)))
        kept = self._steps[: self._position]
        if goes_on and kept and kept[-1].name == name and kept[-1].before.keys() == step.before.keys():
            step = replace(step, before=kept.pop().before)
        self._steps = [*kept, step][-MOST_STEPS:]
        self._position = len(self._steps)

    def undo(self, settings: ControlSettings) -> ControlSettings:
        """``settings`` without the last step; the same where there is none."""
        if not self._position:
            return settings
        self._position -= 1
        return replace(settings, **self._steps[self._position].before)

    def redo(self, settings: ControlSettings) -> ControlSettings:
        """``settings`` with the step that was taken back last; the same where there is none."""
        if self._position == len(self._steps):
            return settings
        self._position += 1
        return replace(settings, **self._steps[self._position - 1].after)
