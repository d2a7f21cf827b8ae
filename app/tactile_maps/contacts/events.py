"""Contact events: what contacts do, put into symbols frame by frame that people and programs can read.

A ``ContactEvent`` is something that a contact began or ended to do. ``ContactState`` follows one contact from touch to
release in phases (a press, a stroke, a press again), ``GraspPairs`` two contacts that hold a link between them or are
the two sides of one self-touch. ``EventDetector`` runs both.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, get_args

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.geometry.surface.mesh import SurfacePoint

EventKind = Literal["touch", "tap", "press", "stroke", "grasp", "release", "merge", "split", "self-touch"]
EventPhase = Literal["began", "ended"]
EVENT_KINDS: tuple[EventKind, ...] = get_args(EventKind)


@dataclass(frozen=True)
class ContactEvent:
    """One event.

    Attributes:
        tick: At which it was noticed.
        time: The same [s].
        kind: ``touch`` (a contact is there), ``tap`` (it was short), ``press`` (it stays), ``stroke`` (it travels),
            ``grasp`` (a link is held from two sides), ``release`` (it is gone), ``merge`` (two became one), ``split``
            (one became two), ``self-touch`` (two links touch each other).
        phase: Whether it began or ended; what has no duration began (touch, merge, split) or ended (tap, release).
        contacts: Ids of the regions; of ``merge`` the one that lives on first, of ``split`` the new one.
        links: Names of the links, one for each place.
        at: Where; of a stroke, where it began.
        to: Where a stroke is now, or the other place of a grasp or self-touch; None for others.
        force: The greatest so far [N]; of a grasp that of the weaker side. None where no force may be claimed because
            the skin is not calibrated.
        duration: From its beginning until now [s], or until it was gone.
        travelled: Of a stroke [m].
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

    @property
    def words(self) -> str:
        """Like "press on forearm, 4.2 N, 0.8 s"."""
        names = [link.replace("_", " ") for link in self.links]
        match self.kind:
            case "touch" | "merge" | "split":
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


_OPENING = {"touch": "touch on", "merge": "contacts merged on", "split": "contact split on"}


_SURE = 2.0
"""Standard uncertainties of its centre that a contact must move by to have moved."""


@dataclass(frozen=True)
class EventThresholds:
    """What counts as what.

    Attributes:
        tap: A contact that is gone again after less than this was a tap [s]; what lasts longer is a press.
        travel: A centre of pressure that has moved on by this is a stroke [m], or by twice its uncertainty if that is
            more.
        rest: A stroke that has not moved on for so long is a press again [s].
        opposed: Largest scalar product of the normals of two contacts that hold a link between them.
    """

    tap: float = 0.25
    travel: float = 0.01
    rest: float = 0.5
    opposed: float = -0.5


class ContactState:
    """What one contact has done so far. Mutable.

    It moves on in paces: a pace is done when the centre has come away from where the last one ended by as much as the
    rule says, so that noise does not add up to a way.

    Args:
        tick: Of its first frame.
        time: The same [s].
        region: As it was first.
        rule: What counts as what.

    Attributes:
        opening: The event that it began with.
        until: Until when it lasted [s]: the time of its newest frame, or of the first without it.
    """

    def __init__(self, tick: int, time: float, region: ContactRegion, rule: EventThresholds) -> None:
        self._rule = rule
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
        self._mark(time, region)
        parent = region.split_from
        contacts = (region.id,) if parent is None else (region.id, parent)
        kind: EventKind = "touch" if parent is None else "split"
        self.opening = ContactEvent(tick, time, kind, "began", contacts, (region.link,), region.at, force=region.force)

    def go_on(self, tick: int, time: float, region: ContactRegion) -> list[ContactEvent]:
        """Take the next frame; what began or ended there."""
        rule = self._rule
        self._last = region
        self.until = time
        self._there = True
        self._peak = max(self._peak, region.force)
        self._strongest = max(self._strongest, region.force)
        if region.merged:  # its centre jumps, which is no stroke
            self._mark(time, region)
            return [self._event(tick, time, "merge", "began", others=region.merged)]
        told = []
        if self._pace > max(rule.travel, _SURE * region.place_error):
            told = self._stroke(tick, time)
            self._mark(time, region)
        elif self._kind == "stroke" and time - self._marked >= rule.rest:
            told = [self._event(tick, time, "stroke", "ended"), self._turn(tick, time, "press", time, region.at)]
        elif self._kind is None and time - self._born >= rule.tap:
            told = [self._turn(tick, time, "press", self._born, self._at)]
        return told

    def leave(self, time: float) -> None:
        """It is not there in this frame. It may come back."""
        if self._there:
            self.until = time
            self._there = False

    def end(self, tick: int, time: float, *, released: bool) -> list[ContactEvent]:
        """The contact is gone for good: what ended with it. One that became part of another is not ``released``."""
        self.leave(time)
        told = [self._event(tick, time, self._kind or "tap", "ended")] if released or self._kind else []
        if released:
            last = self._last
            told.append(
                ContactEvent(
                    tick, time, "release", "ended", (last.id,), (last.link,), last.at,
                    force=self._peak, duration=self.until - self._born,
                )
            )  # fmt: skip
        return told

    @property
    def _pace(self) -> float:
        """How far the centre is from where the last pace ended [m]."""
        return length(self._last.link_position - self._from)

    def _mark(self, time: float, region: ContactRegion) -> None:
        """A pace ends here."""
        self._from: FloatArray = region.link_position
        self._marked = time
        self._marked_at = region.at

    def _stroke(self, tick: int, time: float) -> list[ContactEvent]:
        """One more pace."""
        told = []
        if self._kind != "stroke":
            told = [self._event(tick, time, self._kind, "ended")] if self._kind else []
            told.append(self._turn(tick, time, "stroke", self._marked, self._marked_at))
        self._way += self._pace
        return told

    def _turn(self, tick: int, time: float, kind: EventKind, since: float, at: SurfacePoint) -> ContactEvent:
        """Begin another phase. The first one takes over what was felt before it had a name."""
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
            tick, time, kind, phase, (last.id, *others), (last.link,), self._at,
            to=last.at if stroke else None,
            force=self._strongest,
            duration=self.until - self._began,
            travelled=self._way + self._pace if stroke else 0.0,
        )  # fmt: skip


class _Pair(NamedTuple):
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


class GraspPairs:
    """Grasps and self-touches frame by frame. Mutable; made anew to forget.

    Args:
        opposed: Largest scalar product of the normals of two contacts that hold a link between them.
    """

    def __init__(self, opposed: float) -> None:
        self._opposed = opposed
        self._bonds: dict[tuple[EventKind, str], _Pair] = {}

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
        told = [_pair_event(tick, time, key[0], "ended", self._bonds.pop(key)) for key in gone]
        for key, (one, other) in sorted(found.items(), key=lambda item: item[0]):
            old = self._bonds.get(key)
            force = min(one.force, other.force)
            if old is None:
                self._bonds[key] = bond = _Pair(time, math.inf, one, other, force)
                told.append(_pair_event(tick, time, key[0], "began", bond))
            else:
                self._bonds[key] = _Pair(old.since, math.inf, one, other, max(force, old.force))
        return told

    def _found(
        self, regions: Mapping[int, ContactRegion]
    ) -> dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]]:
        """Grasps by their link, self-touches by their contacts."""
        found: dict[tuple[EventKind, str], tuple[ContactRegion, ContactRegion]] = {}
        ordered = [regions[number] for number in sorted(regions)]
        for place, one in enumerate(ordered):
            if one.partner is not None and one.partner > one.id and one.partner in regions:
                found["self-touch", f"{one.id} {one.partner}"] = one, regions[one.partner]
            for other in ordered[place + 1 :]:
                if one.link == other.link and float(one.link_normal.dot(other.link_normal)) <= self._opposed:
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
"""Events that ``EventDetector.recent`` goes back."""


_RULE = EventThresholds()


class EventDetector:
    """Turns regions and time into events. Mutable; ``reset`` forgets the past. The same frames give the same events.

    Args:
        rule: What counts as what.

    Attributes:
        recent: The newest events, newest first, at most ``RECENT_EVENTS``; the same tuple while nothing new happens.
        claims_force: Whether events may tell forces; not while the readings are not calibrated.

    Cost: 1 µs, and 3 µs a contact.
    """

    def __init__(self, *, rule: EventThresholds = _RULE) -> None:
        self._rule = rule
        self.claims_force = True
        self.reset()

    def reset(self) -> None:
        """No contact is known, nothing has happened."""
        self._courses: dict[int, ContactState] = {}
        self._pairs = GraspPairs(self._rule.opposed)
        self.recent: tuple[ContactEvent, ...] = ()

    @property
    def touched(self) -> bool:
        """Whether any contact has not been released yet: it is there, or gone but awaited."""
        return bool(self._courses)

    def read(
        self, tick: int, time: float, regions: Sequence[ContactRegion], *, awaited: Collection[int] = ()
    ) -> tuple[ContactEvent, ...]:
        """What began or ended at this tick, in the order of the contacts' ids.

        Args:
            tick: Of the frame; rising.
            time: The same [s].
            regions: Contact regions of the frame.
            awaited: Ids of those that are gone but may come back: not released yet.
        """
        if not regions and not self._courses:
            return ()
        now = {region.id: region for region in regions}
        merged = {old for region in regions for old in region.merged}
        told: list[ContactEvent] = []
        for number in sorted(self._courses.keys() | now.keys()):
            if number not in now:
                course = self._courses[number]
                course.leave(time)
                if number in merged or number not in awaited:
                    told += self._courses.pop(number).end(tick, time, released=number not in merged)
            elif number in self._courses:
                told += self._courses[number].go_on(tick, time, now[number])
            else:
                self._courses[number] = ContactState(tick, time, now[number], self._rule)
                told.append(self._courses[number].opening)
        told += self._pairs.read(tick, time, now, awaited=awaited)
        if not self.claims_force:
            told = [replace(event, force=None) for event in told]
        if told:
            self.recent = (*reversed(told), *self.recent)[:RECENT_EVENTS]
        return tuple(told)
