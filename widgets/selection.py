"""The selected taxels, one set for all views, and the colours in which they are marked and traced."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from app.arrays import BoolArray, IntArray, readonly
from widgets.tools import Change

INKS = ("#22b8cf", "#f06595", "#51cf66", "#5c7cfa", "#cc5de8")
"""Of the first few selected taxels, each its own; more are marked alike, in the first."""


@dataclass(frozen=True, eq=False)
class Choice:
    """What a hand has chosen in one view.

    Attributes:
        taxels: All that its gesture has covered so far.
        change: What that does to those selected before the gesture.
        begins: Whether the gesture begins with this.
    """

    taxels: IntArray
    change: Change
    begins: bool = True


class Selection(QObject):
    """Which taxels are selected. Mutable; ``reset`` for another skin."""

    changed = Signal()
    """Other taxels are selected now."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._chosen = self._before = _none(0)

    @property
    def mask(self) -> BoolArray:
        """(taxels,) which are selected."""
        return self._chosen

    @property
    def taxels(self) -> IntArray:
        """(k,) the selected ones, rising."""
        return np.flatnonzero(self._chosen)

    @property
    def inks(self) -> tuple[str, ...]:
        """(k,) the colour of each selected taxel."""
        count = len(self.taxels)
        return INKS[:count] if count <= len(INKS) else INKS[:1] * count

    def reset(self, count: int) -> None:
        """Nothing is selected, of another skin with ``count`` taxels."""
        self._before = _none(count)
        self._set(self._before)

    def take(self, choice: Choice) -> None:
        """A gesture chose."""
        if choice.begins:
            self._before = self._chosen
        covered = _none(len(self._chosen)).copy()
        covered[choice.taxels] = True
        self._set(_combined(self._before, covered, choice.change))

    def abandon(self) -> None:
        """The gesture was given up: as it was before it."""
        self._set(self._before)

    def select_all(self) -> None:
        """Every taxel."""
        self._set(np.ones_like(self._chosen))

    def clear(self) -> None:
        """None."""
        self._set(np.zeros_like(self._chosen))

    def invert(self) -> None:
        """Those that were not."""
        self._set(~self._chosen)

    def _set(self, chosen: BoolArray) -> None:
        if not np.array_equal(chosen, self._chosen):
            self._chosen = readonly(chosen, bool)
            self.changed.emit()


def _none(count: int) -> BoolArray:
    return readonly(np.zeros(count), bool)


def _combined(before: BoolArray, covered: BoolArray, change: Change) -> BoolArray:
    if change is Change.REPLACE:
        return covered
    if change is Change.ADD:
        return before | covered
    return before & ~covered if change is Change.REMOVE else before ^ covered
