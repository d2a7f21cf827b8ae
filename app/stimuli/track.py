"""One finger's way over the skin in time, from its press to its lift."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.touch.poke import Finger


@dataclass(frozen=True, eq=False)
class Track:
    """Where one finger is, from the press at ``times[0]`` to the lift at ``times[-1]``.

    Attributes:
        finger: Which finger of the stimulus, from 0; tracks of one finger do not overlap in time.
        tip: The finger itself.
        times: (k,) [s] since the stimulus began, not decreasing, k >= 2.
        patches: (k,) index of the patch under it; where two differ, the finger steps over at the later time.
        points: (k, 3) on the patch's surface, link frame [m]; straight between two.
    """

    finger: int
    tip: Finger
    times: FloatArray
    patches: IntArray
    points: FloatArray

    def __post_init__(self) -> None:
        for name in ("times", "points"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        object.__setattr__(self, "patches", readonly(self.patches, np.int64))

    def at(self, seconds: float) -> tuple[int, FloatArray]:
        """Patch and point (3,) [m] under the finger; before the press and after the lift those of press and lift."""
        last = len(self.times) - 1
        now = int(np.clip(np.searchsorted(self.times, seconds, side="right") - 1, 0, last))
        here, patch = self.points[now], int(self.patches[now])
        if now == last or patch != self.patches[now + 1]:
            return patch, here
        share = (seconds - self.times[now]) / (self.times[now + 1] - self.times[now])
        return patch, here + max(share, 0.0) * (self.points[now + 1] - here)


def still(finger: int, tip: Finger, patch: int, point: FloatArray, *, press: float, lift: float) -> Track:
    """A finger that stays where it is, from ``press`` to ``lift`` [s]."""
    return Track(finger, tip, np.array([press, lift]), np.array([patch, patch]), np.stack([point, point]))
