"""The selected taxels and contact region, shared by all views, and the colours of their curves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.core.arrays import BoolArray, IntArray, readonly
from tactile_widgets.common.tool_kinds import SelectionMode

TAXEL_COLOURS = ("#22b8cf", "#f06595", "#51cf66", "#5c7cfa", "#cc5de8")
"""Colours of the first selected taxels; larger selections use the first colour for all."""
_SECOND_GROUP = 2
REGION_COLOURS = ("#5c7cfa", "#51cf66", "#cc5de8", "#f06595", "#22b8cf", "#a9e34b")
"""Colours of contact regions, in rotation; ordered unlike ``TAXEL_COLOURS``, so that first region and taxel differ."""


def region_colour(region: int) -> str:
    """Return the colour of a contact region, the same everywhere and during its whole life."""
    return REGION_COLOURS[region % len(REGION_COLOURS)]


@dataclass(frozen=True, eq=False)
class SelectionUpdate:
    """A step of a selection gesture in one view.

    Attributes:
        taxels: All taxels that the gesture has covered so far.
        change: How they change the selection from before the gesture.
        begins: True for the first step of the gesture.
    """

    taxels: IntArray
    change: SelectionMode
    begins: bool = True


class TaxelSelection(QObject):
    """Selected taxels and contact region. Mutable; ``reset`` for another skin."""

    changed = Signal()
    """Other taxels are selected."""
    region_changed = Signal(object)
    """Id of the contact region that is selected now, or None."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._chosen = self._before = _none(0)
        self._ink_of: dict[int, int] = {}
        self._region: int | None = None

    @property
    def region(self) -> int | None:
        """Id of the selected contact region."""
        return self._region

    @property
    def mask(self) -> BoolArray:
        """(taxels,) True for selected taxels."""
        return self._chosen

    @property
    def taxels(self) -> IntArray:
        """(k,) numbers of the selected taxels, ascending."""
        return np.flatnonzero(self._chosen)

    @property
    def inks(self) -> tuple[str, ...]:
        """(k,) colours of the selected taxels; in a small selection a taxel keeps its colour while others change."""
        taxels = self.taxels.tolist()
        return tuple(TAXEL_COLOURS[self._ink_of.get(taxel, 0)] for taxel in taxels)

    def reset(self, count: int) -> None:
        """Clear the selection for another skin with ``count`` taxels."""
        self.select_region(None)
        self._before = _none(count)
        self._set(self._before)

    def take(self, choice: SelectionUpdate) -> None:
        """Apply a step of a gesture."""
        if choice.begins:
            self._before = self._chosen
        covered = _none(len(self._chosen)).copy()
        covered[choice.taxels] = True
        self._set(_combined(self._before, covered, choice.change))

    def mark(self, taxels: IntArray, second: IntArray) -> None:
        """Select two groups of taxels, (k,) and (m,), in the first and in the third colour."""
        chosen = _none(len(self._chosen)).copy()
        chosen[taxels] = True
        chosen[second] = True
        inks = dict.fromkeys(second.tolist(), _SECOND_GROUP)
        if not np.array_equal(chosen, self._chosen) or inks != self._ink_of:
            self._chosen = readonly(chosen, bool)
            self._ink_of = inks
            self.changed.emit()

    def abandon(self) -> None:
        """Restore the selection from before the gesture."""
        self._set(self._before)

    def select_all(self) -> None:
        self._set(np.ones_like(self._chosen))

    def clear(self) -> None:
        """Clear the selection of taxels and of the region."""
        self.select_region(None)
        self._set(np.zeros_like(self._chosen))

    def invert(self) -> None:
        self._set(~self._chosen)

    def select_region(self, region: int | None) -> None:
        """Select a contact region by its id, or none."""
        if region != self._region:
            self._region = region
            self.region_changed.emit(region)

    def forget_region(self, region: int) -> None:
        """Deselect a region that has ended."""
        if region == self._region:
            self.select_region(None)

    def _set(self, chosen: BoolArray) -> None:
        if not np.array_equal(chosen, self._chosen):
            self._chosen = readonly(chosen, bool)
            self._ink_of = _colour_numbers(self._ink_of, self.taxels.tolist())
            self.changed.emit()


def _none(count: int) -> BoolArray:
    return readonly(np.zeros(count), bool)


def _colour_numbers(before: dict[int, int], taxels: list[int]) -> dict[int, int]:
    """Return the colour number of each taxel: kept if it had one, else a free one; empty for a large selection."""
    if len(taxels) > len(TAXEL_COLOURS):
        return {}
    kept = {taxel: before[taxel] for taxel in taxels if taxel in before}
    free = (number for number in range(len(TAXEL_COLOURS)) if number not in kept.values())
    return kept | dict(zip((taxel for taxel in taxels if taxel not in kept), free, strict=False))


def _combined(before: BoolArray, covered: BoolArray, change: SelectionMode) -> BoolArray:
    if change is SelectionMode.REPLACE:
        return covered
    if change is SelectionMode.ADD:
        return before | covered
    return before & ~covered if change is SelectionMode.REMOVE else before ^ covered
