"""Notes on forces that the skin bears and that no taxel reports, because the pressure is too low everywhere."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray, dot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.loads import Load

_LASTING = 0.1
"""Time [s] for which a force must be below the threshold: every touch begins and ends there."""
_LEAST_TAXELS = 4
"""A force is noted from the threshold times the area of so many taxels on: a body narrower than these would be felt."""


class BelowThreshold:
    """Finds links that are pressed while all of their taxels are below the threshold. Mutable.

    A body is noted only where nothing else on its link is felt.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        links = np.repeat([patch.link for patch in skin.patches], [len(patch.taxels) for patch in skin.patches])
        self._areas = skin.areas
        self._taxels: dict[str, IntArray] = {str(link): np.flatnonzero(links == link) for link in np.unique(links)}
        self._since: dict[str, float] = {}

    def reset(self) -> None:
        """Discard the past."""
        self._since.clear()

    def notes(
        self,
        time: float,
        pressures: FloatArray,
        threshold: float,
        regions: Sequence[ContactRegion],
        loads: Callable[[], Sequence[Load]],
    ) -> tuple[ContactNote, ...]:
        """Return the notes of a tick.

        Args:
            time: Simulated time [s].
            pressures: (taxels,) true pressures [Pa].
            threshold: Lowest pressure that counts as touch [Pa].
            regions: Contacts that are reported: one that began above the threshold continues below it.
            loads: Returns what presses the skin; called only for a note.

        Cost: 2 µs while nothing presses, else 4 µs a link.
        """
        if not pressures.any():
            self._since.clear()
            return ()
        reported = {region.link for region in regions}
        found = []
        for link, taxels in self._taxels.items():
            pressed = pressures[taxels]
            highest = float(pressed.max())
            force = dot(pressed, self._areas[taxels]) if 0 < highest < threshold else 0.0
            if link in reported or force <= _LEAST_TAXELS * threshold * self._areas[taxels].mean():
                self._since.pop(link, None)
            elif time - self._since.setdefault(link, time) >= _LASTING:
                by = dict.fromkeys(load.by for load in loads() if load.link == link and load.by)
                found.append(
                    ContactNote(
                        ContactNoteKind.BELOW_THRESHOLD, (*by, link), force=force, pressure=highest, threshold=threshold
                    )
                )
        return tuple(found)
