"""Notes on forces that the skin bears and that contacts lack, because the pressure is too low for the taxels."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray, dot
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind
from tactile_maps.tactile.mechanics.loads import Load

_LASTING = 0.1
"""Time [s] for which a force must be below the threshold, with shorter gaps: every touch begins and ends there."""
_LEAST_TAXELS = 4
"""A force is noted from the threshold times the area of so many taxels on: a body narrower than these would be felt."""
_PART = 1 / 3
"""Share of the force on a link with contacts from which on it is noted that contacts lack it."""


class BelowThreshold:
    """Finds links that are pressed on taxels below the threshold, whose force is no part of a contact. Mutable.

    Where contacts report the rest of the force on a link, the note states the part that they lack.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        links = np.repeat([patch.link for patch in skin.patches], [len(patch.taxels) for patch in skin.patches])
        self._areas = skin.areas
        self._taxels: dict[str, IntArray] = {str(link): np.flatnonzero(links == link) for link in np.unique(links)}
        self._lacking: dict[str, tuple[float, float]] = {}  # since when, and when last: taxels at the threshold flicker

    def reset(self) -> None:
        """Discard the past."""
        self._lacking.clear()

    def notes(
        self,
        time: float,
        pressures: FloatArray,
        readings: FloatArray,
        threshold: float,
        regions: Sequence[ContactRegion],
        loads: Callable[[], Sequence[Load]],
    ) -> tuple[ContactNote, ...]:
        """Return the notes of a tick.

        Args:
            time: Simulated time [s].
            pressures: (taxels,) true pressures [Pa].
            readings: (taxels,) pressures with the effects of the sensor [Pa].
            threshold: Lowest pressure that counts as touch [Pa].
            regions: Contacts that are reported: one that began above the threshold continues below it.
            loads: Returns what presses the skin; called only for a note.

        Cost: 2 µs while nothing presses, else 4 µs a link.
        """
        if not pressures.any():
            self._lacking.clear()
            return ()
        reported = dict[str, float]()
        for region in regions:
            reported[region.link] = reported.get(region.link, 0.0) + region.force
        found = []
        for link, taxels in self._taxels.items():
            pressed = pressures[taxels]
            areas = self._areas[taxels]
            highest = float(pressed.max())
            force = dot(pressed, areas)
            low = dot(np.where(readings[taxels] < threshold, pressed, 0.0), areas)
            lacking = min(low, force - reported.get(link, 0.0))
            since, last = self._lacking.get(link, (time, time))
            if lacking <= max(_PART * force, _LEAST_TAXELS * threshold * areas.mean()):
                if time - last >= _LASTING or not force:
                    self._lacking.pop(link, None)
                continue
            self._lacking[link] = since, time
            if time - since >= _LASTING:
                pressing = [load for load in loads() if load.link == link]
                by = dict.fromkeys(load.by for load in pressing if load.by)
                share = lacking / force if link in reported or highest >= threshold else None
                found.append(
                    ContactNote(
                        ContactNoteKind.BELOW_THRESHOLD,
                        (*by, link),
                        force=sum(load.force for load in pressing) or force,
                        pressure=highest,
                        threshold=threshold,
                        share=share,
                    )
                )
        return tuple(found)
