"""Base of all stimuli: finger, begin and repetition, and the tracks of fingers.

A track is the path of one finger over the skin in time, from press to lift. Every kind consists of tracks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.skin_locations import SkinLocation, SkinLocator
from tactile_maps.tactile.poke import Finger


@dataclass(frozen=True, eq=False)
class FingerTrack(ArrayFields):
    """Path of one finger, from the press at ``times[0]`` to the lift at ``times[-1]``.

    Attributes:
        finger: Number of the finger in the stimulus, from 0; tracks of one finger do not overlap in time.
        tip: Properties of the finger.
        times: (k,) times since the start of the stimulus [s], not decreasing, k >= 2.
        patches: (k,) index of the patch under it; it changes at the later of two times.
        points: (k, 3) points on the patch's surface, link frame [m]; straight between two.
    """

    finger: int
    tip: Finger
    times: FloatArray
    patches: IntArray
    points: FloatArray

    def at(self, seconds: float) -> tuple[int, FloatArray]:
        """Return patch and point (3,) [m] under the finger; outside the track those of press or lift."""
        last = len(self.times) - 1
        now = int(np.clip(np.searchsorted(self.times, seconds, side="right") - 1, 0, last))
        here = self.points[now]
        patch = int(self.patches[now])
        if now == last or patch != self.patches[now + 1]:
            return patch, here
        share = (seconds - self.times[now]) / (self.times[now + 1] - self.times[now])
        return patch, here + max(share, 0.0) * (self.points[now + 1] - here)


def stationary_track(
    finger: int, tip: Finger, patch: int, point: FloatArray, *, press: float, lift: float
) -> FingerTrack:
    """Return the track of a finger that does not move, from ``press`` to ``lift`` [s]."""
    return FingerTrack(finger, tip, np.array([press, lift]), np.array([patch, patch]), np.stack([point, point]))


_RANGES = (
    ("force", 0.0, 100.0),
    ("press", 0.0, 1.0),
    ("radius", 1e-4, 0.1),
    ("stiffness", 1e-3, 1e6),
    ("rest", 0.0, 3600.0),
    ("begin", 0.0, 1e6),
    ("repeat", 1, 100_000),
)
_TIMES = ("rest", "begin", "hold", "down", "up", "stay", "seconds", "pause")
_UNITS = {
    "force": " N",
    "press": " m/s",
    "speed": " m/s",
    "stiffness": " N/m",
    **dict.fromkeys(("radius", "length"), " metres"),
    **dict.fromkeys(("heading", "angle"), " degrees"),
    **dict.fromkeys(_TIMES, " seconds"),
}
_FAR = 100.0


@dataclass(frozen=True, kw_only=True)
class Stimulus(ABC):
    """A scripted touch, as a value. The kinds add place and motion.

    Attributes:
        patch: Name of the patch; empty for the first.
        force: Largest force of the finger [N].
        press: Speed of the fingertip into the skin below that force [m/s].
        radius: Radius of the fingertip [m].
        stiffness: Stiffness of the finger [N/m].
        rest: Time from the lift to the end of the stimulus [s]; at least one tick.
        begin: Time since the start of the script [s]; None for the end of the previous stimulus.
        repeat: Number of repetitions, one after the other.

    Raises:
        SceneError: A number is out of its range.
    """

    kind: ClassVar[str] = ""
    places: ClassVar[tuple[str, ...]] = ()
    ranges: ClassVar[tuple[tuple[str, float, float], ...]] = ()

    patch: str = ""
    force: float = 4.0
    press: float = 0.012
    radius: float = 0.008
    stiffness: float = 1000.0
    rest: float = 0.6
    begin: float | None = None
    repeat: int = 1

    def __post_init__(self) -> None:
        for name, low, high in (*_RANGES, *self.ranges):
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise self.refusal(name, value, f"Choose {low:g} to {high:g}{_UNITS.get(name, '')}")
        for name in self.places:
            self.check_place(name, getattr(self, name))

    @property
    def tip(self) -> Finger:
        """Properties of the finger."""
        return Finger(self.stiffness, self.radius, self.force, self.press)

    @abstractmethod
    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        """Return the tracks of the fingers.

        Raises:
            SceneError: A place is not on this skin.
        """

    def refusal(self, name: str, value: object, remedy: str) -> SceneError:
        """Return the error for a field that is out of range."""
        return SceneError(
            f"a setting of the {self.kind} is out of range", place=f"{self.kind}.{name}", value=value, remedy=remedy
        )

    def check_place(self, name: str, place: SkinLocation) -> None:
        """Reject a place that is neither two fractions nor three coordinates.

        Raises:
            SceneError: The place is invalid; the error names the field.
        """
        low, high = (0.0, 1.0) if len(place) == 2 else (-_FAR, _FAR)
        if len(place) not in (2, 3) or not all(low <= value <= high for value in place):
            raise self.refusal(
                name, list(place), "Write [along, around], each 0 to 1, or [x, y, z] in metres of the link's frame"
            )
