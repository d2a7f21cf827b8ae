"""A path: a finger point by point in time, as a hand went."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, TypeAlias

import numpy as np

from app.stimuli.place import Ground
from app.stimuli.stimulus import Stimulus
from app.stimuli.track import Track

Points: TypeAlias = tuple[tuple[float, float, float, float], ...]
"""(seconds, x, y, z): when, and where in the frame of the patch's link [m]."""


@dataclass(frozen=True, kw_only=True)
class Path(Stimulus):
    """Press at the first point, be at each of the others when it says, straight between them, lift at the last.

    Attributes:
        points: At least two, from 0 seconds on, each later than the one before.
        patches: Names of each point's patch where the finger goes over several; ``patch`` for all when empty.
    """

    kind: ClassVar[str] = "path"

    points: Points
    patches: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        times = [point[0] for point in self.points]
        if len(times) < 2 or times[0] != 0.0 or not all(0 < b - a < 3600.0 for a, b in pairwise(times)):
            remedy = "Write at least two [seconds, x, y, z], from 0 seconds on, each later than the one before"
            raise self.refusal("points", times, remedy)
        if self.patches and len(self.patches) != len(self.points):
            remedy = f"Name one for each of the {len(self.points)} points, or none"
            raise self.refusal("patches", list(self.patches), remedy)
        for point in self.points:
            self.check_place("points", point[1:])

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One finger that goes from point to point."""
        patches = [ground.patch(name) for name in self.patches or (self.patch,) * len(self.points)]
        points = [ground.point(patch, point[1:]) for patch, point in zip(patches, self.points, strict=True)]
        times = np.array([point[0] for point in self.points])
        return (Track(0, self.tip, times, np.array(patches), np.array(points)),)
