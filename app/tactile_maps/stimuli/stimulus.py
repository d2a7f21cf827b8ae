"""What every kind of stimulus shares: its finger, its begin and repetition, and the tracks of its fingers.

A track is one finger's path over the skin in time, from its press to its lift; every kind becomes a few tracks.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import SceneError
from tactile_maps.stimuli.skin_locations import SkinLocation, SkinLocator
from tactile_maps.tactile.poke import Finger


@dataclass(frozen=True, eq=False)
class FingerTrack:
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
        freeze_arrays(self, "times", "points")
        freeze_arrays(self, "patches", dtype=np.int64)

    def at(self, seconds: float) -> tuple[int, FloatArray]:
        """Patch and point (3,) [m] under the finger; before the press and after the lift those of press and lift."""
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
    """A finger that stays where it is, from ``press`` to ``lift`` [s]."""
    return FingerTrack(finger, tip, np.array([press, lift]), np.array([patch, patch]), np.stack([point, point]))


_LONG = 3600.0
_FAR = 100.0


@dataclass(frozen=True, kw_only=True)
class Stimulus(ABC):
    """A scripted touch, as a value. The kinds add where and how.

    Attributes:
        patch: Name of the patch; empty for the first.
        force: The finger never pushes harder [N].
        press: How fast the fingertip goes into the skin while it pushes less than that [m/s].
        radius: Of the fingertip [m].
        stiffness: Of the finger [N/m].
        rest: Time after the lift before the stimulus counts as ended [s]; at least one tick.
        begin: When, since the script began [s]; None when the stimulus before it in the script has ended.
        repeat: How often it is done, once after the other.

    Raises:
        SceneError: A number is out of its range.
    """

    kind: ClassVar[str] = ""
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {}

    patch: str = ""
    force: float = 4.0
    press: float = 0.012
    radius: float = 0.008
    stiffness: float = 1000.0
    rest: float = 0.6
    begin: float | None = None
    repeat: int = 1

    def __post_init__(self) -> None:
        ranges = {
            "force": (0.0, 100.0),
            "press": (0.0, 1.0),
            "radius": (1e-4, 0.1),
            "stiffness": (1e-3, 1e6),
            "rest": (0.0, _LONG),
            "begin": (0.0, 1e6),
            "repeat": (1, 100_000),
            **self.ranges,
        }
        for name, (low, high) in ranges.items():
            value = getattr(self, name)
            if value is not None and not low <= value <= high:
                raise self.refusal(name, value, f"Choose {low:g} to {high:g}")

    @property
    def tip(self) -> Finger:
        """The finger that does it."""
        return Finger(self.stiffness, self.radius, self.force, self.press)

    @abstractmethod
    def tracks(self, locator: SkinLocator) -> tuple[FingerTrack, ...]:
        """What its fingers do, each from its press to its lift.

        Raises:
            SceneError: There is no such place on this skin.
        """

    def refusal(self, name: str, value: object, remedy: str) -> SceneError:
        """The error that says that a field is out of range."""
        return SceneError(
            f"a setting of the {self.kind} is out of range", place=f"{self.kind}.{name}", value=value, remedy=remedy
        )

    def check_place(self, name: str, place: SkinLocation) -> None:
        """Refuse what is neither two fractions nor three coordinates.

        Raises:
            SceneError: Naming the field.
        """
        low, high = (0.0, 1.0) if len(place) == 2 else (-_FAR, _FAR)
        if len(place) not in (2, 3) or not all(low <= value <= high for value in place):
            raise self.refusal(
                name, list(place), "Write [along, around], each 0 to 1, or [x, y, z] in metres of the link's frame"
            )
