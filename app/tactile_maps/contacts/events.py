"""Contact events: the behaviour of contacts as symbols, detected frame by frame.

A ``ContactEvent`` marks the begin or end of a touch, press, stroke, grasp and so on. ``ContactState`` tracks one
contact from touch to release in phases (a press, a stroke, a press again). ``GraspPairs`` tracks two contacts that hold
a link between them or are the two sides of a self-touch. ``EventDetector`` runs both.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, NamedTuple, get_args

from tactile_maps.contacts.detection.contact_shear import Slip
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.geometry.surface.mesh import SurfacePoint

EventKind = Literal[
    "touch", "tap", "press", "stroke", "grasp", "release", "merge", "split", "self-touch", "incipient-slip", "slip"
]
EventPhase = Literal["began", "ended"]
EVENT_KINDS: tuple[EventKind, ...] = get_args(EventKind)


@dataclass(frozen=True)
class ContactEvent:
    """A contact event.

    Attributes:
        tick: Tick at which it was detected.
        time: Time of that tick [s].
        kind: ``touch`` (a contact begins), ``tap`` (it was short), ``press`` (it stays), ``stroke`` (it travels),
            ``grasp`` (a link is held from two sides), ``release`` (it has ended), ``merge`` (two became one), ``split``
            (one became two), ``self-touch`` (two links touch each other), ``incipient-slip`` (a contact begins to slip
            at its border), ``slip`` (it slides). The last two need taxels that measure shear.
        phase: Begin or end. Events without duration are a begin (touch, merge, split, incipient-slip) or an end (tap,
            release).
        contacts: Ids of the regions; for ``merge`` the remaining one first, for ``split`` the new one first.
        links: Names of the links, one for each place.
        at: Place of the event; for a stroke its start.
        to: Present place of a stroke, or the other place of a grasp or self-touch; None for other kinds.
        force: Largest force so far [N]; for a grasp that of the weaker side. None if the skin is not calibrated in
            force.
        duration: Time from the begin until now, or until the contact was lost or, of a slip, stuck [s]. A stroke begins
            when it leaves its start.
        travelled: Length of a stroke [m].
    """

    tick: int
    time: float
    kind: EventKind
    phase: EventPhase
    contacts: tuple[int, ...]
    links: tuple[str, ...]
    at: SurfacePoint
    to: SurfacePoint | None = None
    force: float | None = 0.0
    duration: float = 0.0
    travelled: float = 0.0

    @cached_property
    def words(self) -> str:
        """Short text such as "press on forearm, 4.2 N, 0.8 s"."""
        names = [link.replace("_", " ") for link in self.links]
        match self.kind:
            case "touch" | "merge" | "split" | "incipient-slip":
                return f"{_OPENING[self.kind]} {names[0]}"
            case "self-touch":
                facts = [f"{names[0]} touches {names[-1]}"]
            case "stroke":
                facts = [f"stroke on {names[0]}", f"{1e3 * self.travelled:.0f}\u202fmm"]
            case kind:
                facts = [f"{kind} {'of' if kind == 'grasp' else 'on'} {names[0]}"]
        if self.force is not None:
            facts.append(f"{self.force:.1f}\u202fN")
        if self.phase == "ended":
            facts.append(f"{self.duration:.1f}\u202fs")
        return ", ".join(facts)


_OPENING = {
    "touch": "touch on",
    "merge": "contacts merged on",
    "split": "contact split on",
    "incipient-slip": "incipient slip on",
}


_SURE = 2.0
"""Smallest motion of a contact, in standard uncertainties of its centre."""


TAP = 0.25
"""Longest duration of a tap [s]; a longer contact is a press."""
TRAVEL = 0.01
"""Motion of the centre of pressure from which a contact is a stroke [m]; twice the uncertainty of the centre if that is
larger."""
STILL = 0.0025
"""Motion of the centre of pressure that continues a stroke [m]; twice the uncertainty of the centre if that is larger.
"""
REST = 0.5
"""Time without such a motion after which a stroke becomes a press [s]. Strokes slower than 5 mm/s are interrupted."""
ENDS_SLIP = 0.85
"""Friction usage below which a contact that slid sticks."""
STICKS = 0.1
"""Time for which a contact has to stick until its slip has ended [s]: in stick-slip it sticks for shorter times."""
_SLIPS = (Slip.STICKING, Slip.INCIPIENT, Slip.SLIDING)
"""States of friction, the later the more of it is in use."""
OPPOSED = -0.5
"""Largest scalar product of the normals of two contacts that hold a link between them."""


class ContactState:
    """State of one contact. Mutable.

    Motion is counted in steps: a step ends when the centre has moved by the threshold from the end of the previous
    step, so that noise does not add up to a stroke. A smaller motion shows that a stroke continues, because a slow
    one takes longer for a step than a rest lasts.

    Args:
        tick: Tick of its first frame.
        time: Time of that frame [s].
        region: The region in that frame.

    Attributes:
        opening: The first event of the contact.
        until: End of the contact so far [s]: the time of its newest frame, or of the first frame without it.
    """

    def __init__(self, tick: int, time: float, region: ContactRegion) -> None:
        self._born = time
        self._peak = region.force
        self._last = region
        self.until = time
        self._there = True
        self._kind: EventKind | None = None
        self._began = time
        self._at = region.at
        self._strongest = region.force
        self._way = 0.0
        self._slip = Slip.STICKING
        self._slid = time
        self._kept = time
        self._near: FloatArray = region.link_position
        self._moved = time
        self._left = time
        self._mark(time, region)
        parent = region.split_from
        contacts = (region.id,) if parent is None else (region.id, parent)
        kind: EventKind = "touch" if parent is None else "split"
        self.opening = ContactEvent(tick, time, kind, "began", contacts, (region.link,), region.at, force=region.force)

    def advance(self, tick: int, time: float, region: ContactRegion) -> list[ContactEvent]:
        """Process the next frame and return its events."""
        self._last = region
        self.until = time
        self._there = True
        self._peak = max(self._peak, region.force)
        self._strongest = max(self._strongest, region.force)
        if region.merged:  # the centre jumps, which is not a stroke
            self._mark(time, region)
            return [self._event(tick, time, "merge", "began", others=region.merged)]
        return [*self._phase(tick, time, region), *self._friction(tick, time, region)]

    def _phase(self, tick: int, time: float, region: ContactRegion) -> list[ContactEvent]:
        """Return the events of strokes and presses."""
        events = []
        still = max(STILL, _SURE * region.place_error)
        if length(region.link_position - self._near) > still:
            self._near = region.link_position
            self._moved = time
        if self._pace <= still:
            self._left = time
        if self._pace > max(TRAVEL, _SURE * region.place_error):
            events = self._stroke(tick, time)
            self._mark(time, region)
        elif self._kind == "stroke" and time - self._moved >= REST:
            events = [self._event(tick, time, "stroke", "ended"), self._turn(tick, time, "press", time, region.at)]
            self._mark(time, region)
        elif self._kind is None and time - self._born >= TAP:
            events = [self._turn(tick, time, "press", self._born, self._at)]
        return events

    def _friction(self, tick: int, time: float, region: ContactRegion) -> list[ContactEvent]:
        """Return the events of slip. It ends once the contact has used clearly less friction for ``STICKS``."""
        shear = region.shear
        if shear is None:
            return []
        more = _SLIPS.index(shear.slip) - _SLIPS.index(self._slip)
        if more >= 0 or (self._slip is Slip.SLIDING and shear.usage > ENDS_SLIP):
            self._kept = time
        if more == 0 or (more < 0 and time - self._kept < STICKS):
            return []
        before = self._slip
        self._slip = shear.slip
        if before is Slip.SLIDING:
            return [self._slip_ended(tick, time)]
        if more < 0:
            return []
        self._slid = time
        return [self._slip_event(tick, time, "slip" if shear.slip is Slip.SLIDING else "incipient-slip", "began")]

    def _slip_ended(self, tick: int, time: float) -> ContactEvent:
        return self._slip_event(tick, time, "slip", "ended", lasted=self._kept - self._slid)

    def _slip_event(
        self, tick: int, time: float, kind: EventKind, phase: EventPhase, *, lasted: float = 0.0
    ) -> ContactEvent:
        last = self._last
        return ContactEvent(
            tick, time, kind, phase, (last.id,), (last.link,), last.at, force=last.force, duration=lasted
        )

    def forget_force(self) -> None:
        """Find the largest force from the next frame on."""
        self._peak = 0.0
        self._strongest = 0.0

    def leave(self, time: float) -> None:
        """Process a frame without the contact. It may come back."""
        if self._there:
            self._kept = time if self._kept == self.until else self._kept
            self.until = time
            self._there = False

    def end(self, tick: int, time: float, *, released: bool) -> list[ContactEvent]:
        """End the contact and return the events. A contact that merged into another is not ``released``."""
        self.leave(time)
        events = [self._slip_ended(tick, self.until)] if self._slip is Slip.SLIDING else []
        events += [self._event(tick, time, self._kind or "tap", "ended")] if released or self._kind else []
        if released:
            last = self._last
            events.append(
                ContactEvent(
                    tick,
                    time,
                    "release",
                    "ended",
                    (last.id,),
                    (last.link,),
                    last.at,
                    force=self._peak,
                    duration=self.until - self._born,
                )
            )
        return events

    @property
    def _pace(self) -> float:
        """Distance of the centre from the end of the last step [m]."""
        return length(self._last.link_position - self._from)

    def _mark(self, time: float, region: ContactRegion) -> None:
        self._from: FloatArray = region.link_position
        self._near = region.link_position
        self._moved = time
        self._left = time  # newest time at which the centre was there
        self._marked_at = region.at

    def _stroke(self, tick: int, time: float) -> list[ContactEvent]:
        events = []
        if self._kind != "stroke":
            events = [self._event(tick, time, self._kind, "ended")] if self._kind else []
            events.append(self._turn(tick, time, "stroke", self._left, self._marked_at))
        self._way += self._pace
        return events

    def _turn(self, tick: int, time: float, kind: EventKind, since: float, at: SurfacePoint) -> ContactEvent:
        """Begin another phase. The first phase includes the largest force since the touch."""
        if self._kind is not None:
            self._strongest = self._last.force
        self._kind = kind
        self._began = since
        self._at = at
        self._way = 0.0
        return self._event(tick, time, kind, "began")

    def _event(
        self, tick: int, time: float, kind: EventKind, phase: EventPhase, *, others: tuple[int, ...] = ()
    ) -> ContactEvent:
        last = self._last
        stroke = kind == "stroke"
        return ContactEvent(
            tick,
            time,
            kind,
            phase,
            (last.id, *others),
            (last.link,),
            self._at,
            to=last.at if stroke else None,
            force=self._strongest,
            duration=self.until - self._began,
            travelled=self._way + self._pace if stroke else 0.0,
        )


class _Pair(NamedTuple):
    """Two contacts that belong together, with begin and end of that [s]; the end is inf while it lasts."""

    since: float
    until: float
    one: ContactRegion
    other: ContactRegion
    force: float

    @property
    def ids(self) -> frozenset[int]:
        return frozenset((self.one.id, self.other.id))


class GraspPairs:
    """Grasps and self-touches, frame by frame. Mutable; create a new one to reset."""

    def __init__(self) -> None:
        self._bonds: dict[tuple[EventKind, str], _Pair] = {}

    def read(
        self, tick: int, time: float, regions: Mapping[int, ContactRegion], *, awaited: Collection[int] = ()
    ) -> list[ContactEvent]:
        """Return the events of this tick. Cost: 0.3 µs unless there are two or more regions.

        Args:
            tick: Tick of the frame.
            time: Its time [s].
            regions: Contact regions by id.
            awaited: Ids of lost contacts that may come back; their grasps continue until then.
        """
        if len(regions) < 2 and not self._bonds:
            return []
        found = self._found(regions)
        apart = sorted(self._bonds.keys() - found.keys())
        for key in apart:
            self._bonds[key] = self._bonds[key]._replace(until=min(self._bonds[key].until, time))
        gone = [key for key in apart if not self._bonds[key].ids.intersection(awaited)]
        events = [_pair_event(tick, time, key[0], "ended", self._bonds.pop(key)) for key in gone]
        for key, (one, other) in sorted(found.items(), key=lambda item: item[0]):
            old = self._bonds.get(key)
            force = min(one.force, other.force)
            if old is None:
                self._bonds[key] = bond = _Pair(time, math.inf, one, other, force)
                events.append(_pair_event(tick, time, key[0], "began", bond))
            else:
                self._bonds[key] = _Pair(old.since, math.inf, one, other, max(force, old.force))
        return events

    def forget_forces(self) -> None:
        """Find the largest forces from the next frame on."""
        self._bonds = {key: bond._replace(force=0.0) for key, bond in self._bonds.items()}

    def _found(
        self, regions: Mapping[int, ContactRegion]
    ) -> dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]]:
        """Return grasps by link and self-touches by contacts."""
        found: dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]] = {}
        ordered = [regions[number] for number in sorted(regions)]
        for place, one in enumerate(ordered):
            if one.partner is not None and one.partner > one.id and one.partner in regions:
                found["self-touch", f"{one.id} {one.partner}"] = one, regions[one.partner]
            for other in ordered[place + 1 :]:
                if one.link == other.link and float(one.link_normal.dot(other.link_normal)) <= OPPOSED:
                    best = found.get(("grasp", one.link))
                    squeeze = min(one.force, other.force)
                    if best is None or squeeze > min(best[0].force, best[1].force):
                        found["grasp", one.link] = one, other
        return found


def _pair_event(tick: int, time: float, kind: EventKind, phase: EventPhase, bond: _Pair) -> ContactEvent:
    one = bond.one
    other = bond.other
    links = (one.link,) if kind == "grasp" else (one.link, other.link)
    contacts = (one.id, other.id)
    lasted = min(bond.until, time) - bond.since
    return ContactEvent(tick, time, kind, phase, contacts, links, one.at, other.at, bond.force, lasted)


RECENT_EVENTS = 100
"""Length of ``EventDetector.recent``."""


class EventDetector:
    """Detector of events in regions over time. Mutable; ``reset`` discards the past. Deterministic.

    Attributes:
        recent: Newest events first, at most ``RECENT_EVENTS``; the same tuple while nothing is added.
        claims_force: Whether events have forces; False while the readings are not calibrated.

    Cost: 1 µs, and 3 µs a contact.
    """

    def __init__(self) -> None:
        self.claims_force = True
        self.reset()

    def reset(self) -> None:
        """Forget all contacts and events."""
        self._contacts: dict[int, ContactState] = {}
        self._pairs = GraspPairs()
        self.recent: tuple[ContactEvent, ...] = ()

    def forget_forces(self) -> None:
        """Find the largest forces from now on, because earlier readings had another unit."""
        for contact in self._contacts.values():
            contact.forget_force()
        self._pairs.forget_forces()

    @property
    def touched(self) -> bool:
        """Whether any contact is not released yet: it is present, or lost and awaited."""
        return bool(self._contacts)

    def read(
        self, tick: int, time: float, regions: Sequence[ContactRegion], *, awaited: Collection[int] = ()
    ) -> tuple[ContactEvent, ...]:
        """Return the events of this tick, in the order of the contacts' ids.

        Args:
            tick: Tick of the frame, increasing.
            time: Its time [s].
            regions: Contact regions of the frame.
            awaited: Ids of lost contacts that may come back and are not released yet.
        """
        if not regions and not self._contacts:
            return ()
        now = {region.id: region for region in regions}
        merged = {old for region in regions for old in region.merged}
        events: list[ContactEvent] = []
        for number in sorted(self._contacts.keys() | now.keys()):
            if number not in now:
                state = self._contacts[number]
                state.leave(time)
                if number in merged or number not in awaited:
                    events += self._contacts.pop(number).end(tick, time, released=number not in merged)
            elif number in self._contacts:
                events += self._contacts[number].advance(tick, time, now[number])
            else:
                self._contacts[number] = ContactState(tick, time, now[number])
                events.append(self._contacts[number].opening)
        events += self._pairs.read(tick, time, now, awaited=awaited)
        if not self.claims_force:
            events = [replace(event, force=None) for event in events]
        if events:
            self.recent = (*reversed(events), *self.recent)[:RECENT_EVENTS]
        return tuple(events)
