"""A stroke: press at one place, move to another over the skin, lift."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from app.arrays import FloatArray
from app.stimuli.place import Ground, Place
from app.stimuli.stimulus import Stimulus
from app.stimuli.track import Track


@dataclass(frozen=True, kw_only=True)
class Stroke(Stimulus):
    """Press at one place, move to another over the skin at an even speed, lift. See ``Ground.way`` for the way.

    Attributes:
        start: Where to press.
        end: Where to lift.
        speed: Along the skin [m/s].
        hold: Time to press in before moving [s].
        stay: Time at the end before the lift [s].
    """

    kind: ClassVar[str] = "stroke"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {
        "speed": (1e-3, 10.0),
        "hold": (0.0, 3600.0),
        "stay": (0.0, 3600.0),
    }

    start: Place = (0.25, 0.25)
    end: Place = (0.75, 0.25)
    speed: float = 0.06
    hold: float = 0.8
    stay: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_place("start", self.start)
        self.check_place("end", self.end)

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One finger that moves."""
        patch = ground.patch(self.patch)
        line = ground.way(patch, self.start, self.end)
        times = self.hold + lengths(line) / self.speed
        times = np.concatenate([[0.0], times, [times[-1] + self.stay]])
        return (Track(0, self.tip, times, np.full(len(times), patch), np.concatenate([line[:1], line, line[-1:]])),)


def lengths(line: FloatArray) -> FloatArray:
    """(k,) how far along a polyline (k, 3) each of its points is [m]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
