"""The selected taxels and contact region, the same for all views, and the colours in which they are traced."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.core.arrays import BoolArray, IntArray, readonly
from tactile_widgets.common.tool_kinds import SelectionMode

TAXEL_COLOURS = ("#22b8cf", "#f06595", "#51cf66", "#5c7cfa", "#cc5de8")
"""Of the first few selected taxels, each its own; more are marked alike, in the first."""
REGION_COLOURS = ("#5c7cfa", "#51cf66", "#cc5de8", "#f06595", "#22b8cf", "#a9e34b")
"""Of contact regions, by turns; ordered unlike ``TAXEL_COLOURS``, so that first region and first taxel differ."""


def region_colour(region: int) -> str:
    """The colour of a contact region, the same wherever it is traced and as long as it lives."""
    return REGION_COLOURS[region % len(REGION_COLOURS)]


@dataclass(frozen=True, eq=False)
class SelectionUpdate:
    """What a user has chosen in one view.

    Attributes:
        taxels: All that its gesture has covered so far.
        change: What that does to those selected before the gesture.
        begins: Whether the gesture begins with this.
    """

    taxels: IntArray
    change: SelectionMode
    begins: bool = True


class TaxelSelection(QObject):
    """Which taxels are selected, and which contact region. Mutable; ``reset`` for another skin."""

    changed = Signal()
    """Other taxels are selected now."""
    region_changed = Signal(object)
    """Another contact region is selected: its id, or None."""

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
        """(taxels,) which are selected."""
        return self._chosen

    @property
    def taxels(self) -> IntArray:
        """(k,) the selected ones, rising."""
        return np.flatnonzero(self._chosen)

    @property
    def inks(self) -> tuple[str, ...]:
        """(k,) the colour of each selected taxel; while there are few it keeps its own as others come and go."""
        taxels = self.taxels.tolist()
        return tuple(TAXEL_COLOURS[self._ink_of.get(taxel, 0)] for taxel in taxels)

    def reset(self, count: int) -> None:
        """Nothing is selected, of another skin with ``count`` taxels."""
        self.select_region(None)
        self._before = _none(count)
        self._set(self._before)

    def take(self, choice: SelectionUpdate) -> None:
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
        """None, and no region."""
        self.select_region(None)
        self._set(np.zeros_like(self._chosen))

    def invert(self) -> None:
        """Those that were not."""
        self._set(~self._chosen)

    def select_region(self, region: int | None) -> None:
        """Select a contact region by its id; None for none."""
        if region != self._region:
            self._region = region
            self.region_changed.emit(region)

    def forget_region(self, region: int) -> None:
        """A region is gone for good: it cannot be selected any more."""
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
    """Numbers of each taxel's ink: those that had one keep it, the others take what is free; none where many are."""
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
