"""A tap: short pokes at one place, one after the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from app.stimuli.place import Ground, Place
from app.stimuli.stimulus import Stimulus
from app.stimuli.track import Track, still


@dataclass(frozen=True, kw_only=True)
class Tap(Stimulus):
    """Short, quick pokes at one place.

    Attributes:
        at: Where.
        taps: How many.
        down: From each press to its lift [s].
        up: From each lift to the next press [s].
    """

    kind: ClassVar[str] = "tap"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {
        "taps": (1, 10_000),
        "down": (0.001, 3600.0),
        "up": (0.001, 3600.0),
    }

    at: Place = (0.5, 0.25)
    taps: int = 5
    down: float = 0.08
    up: float = 0.12
    press: float = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_place("at", self.at)

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One finger that comes and goes."""
        patch, each = ground.patch(self.patch), self.down + self.up
        point = ground.point(patch, self.at)
        return tuple(
            still(0, self.tip, patch, point, press=number * each, lift=number * each + self.down)
            for number in range(self.taps)
        )
