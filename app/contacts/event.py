"""A contact event: something that a contact began or ended to do, as a symbol that people and programs can read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from app.geometry.surface_point import SurfacePoint

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
        force: The greatest so far [N]; of a grasp that of the weaker side.
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
    force: float = 0.0
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
                facts = [f"stroke on {names[0]}", f"{1e3 * self.travelled:.0f}\u2009mm"]
            case kind:
                facts = [f"{kind} {'of' if kind == 'grasp' else 'on'} {names[0]}"]
        facts.append(f"{self.force:.1f}\u2009N")
        if self.phase == "ended":
            facts.append(f"{self.duration:.1f}\u2009s")
        return ", ".join(facts)


_OPENING = {"touch": "touch on", "merge": "two contacts become one on", "split": "one contact becomes two on"}
