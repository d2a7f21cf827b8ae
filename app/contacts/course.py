"""The course of one contact from touch to release, in phases: a press, a stroke, a press again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.contacts.event import ContactEvent, EventKind, EventPhase
from app.contacts.region import ContactRegion
from app.geometry.surface_point import SurfacePoint

_SURE = 2.0
"""Standard uncertainties of its centre that a contact must move by to have moved."""


@dataclass(frozen=True)
class EventRule:
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


class Course:
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

    def __init__(self, tick: int, time: float, region: ContactRegion, rule: EventRule) -> None:
        self._rule, self._born, self._peak, self._last = rule, time, region.force, region
        self.until, self._there = time, True
        self._kind: EventKind | None = None
        self._began, self._at, self._strongest, self._way = time, region.at, region.force, 0.0
        self._mark(time, region)
        parent = region.split_from
        contacts = (region.id, parent) if parent else (region.id,)
        kind: EventKind = "split" if parent else "touch"
        self.opening = ContactEvent(tick, time, kind, "began", contacts, (region.link,), region.at, force=region.force)

    def go_on(self, tick: int, time: float, region: ContactRegion) -> list[ContactEvent]:
        """Take the next frame; what began or ended there."""
        rule, self._last = self._rule, region
        self.until, self._there = time, True
        self._peak, self._strongest = max(self._peak, region.force), max(self._strongest, region.force)
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
            self.until, self._there = time, False

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
        return float(np.linalg.norm(self._last.point - self._from))

    def _mark(self, time: float, region: ContactRegion) -> None:
        """A pace ends here."""
        self._from: FloatArray = region.point
        self._marked, self._marked_at = time, region.at

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
        self._kind, self._began, self._at, self._way = kind, since, at, 0.0
        return self._event(tick, time, kind, "began")

    def _event(
        self, tick: int, time: float, kind: EventKind, phase: EventPhase, *, others: tuple[int, ...] = ()
    ) -> ContactEvent:
        last, stroke = self._last, kind == "stroke"
        return ContactEvent(
            tick, time, kind, phase, (last.id, *others), (last.link,), self._at,
            to=last.at if stroke else None,
            force=self._strongest,
            duration=self.until - self._began,
            travelled=self._way + self._pace if stroke else 0.0,
        )  # fmt: skip
