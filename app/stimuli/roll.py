"""A roll: a fingertip that rolls over the skin to and fro, pressing as hard as it may all the while."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from app.arrays import FloatArray
from app.stimuli.place import Ground, Place, long_axes
from app.stimuli.stimulus import Stimulus
from app.stimuli.stroke import lengths
from app.stimuli.track import Track

_SAMPLES = 48


@dataclass(frozen=True, kw_only=True)
class Roll(Stimulus):
    """Press, roll the fingertip to one side, to the other, and back, as often as said, lift.

    A ball that rolls without slipping moves its contact as far over the skin as over itself: ``radius`` times the
    angle of its surface that touches. So the contact moves about ``at`` as a sine of that width, while the force,
    reached in ``hold``, stays.

    Attributes:
        at: The middle.
        heading: The way of the first roll, turned about the outward normal from the patch's long axis [deg].
        angle: Of the fingertip's surface that comes to touch, to each side [deg].
        rolls: How often to and fro.
        seconds: For each.
        hold: Time to press in before rolling [s].
    """

    kind: ClassVar[str] = "roll"
    ranges: ClassVar[Mapping[str, tuple[float, float]]] = {
        "heading": (-360.0, 360.0),
        "angle": (0.0, 180.0),
        "rolls": (1, 10_000),
        "seconds": (0.02, 3600.0),
        "hold": (0.0, 3600.0),
    }

    at: Place = (0.5, 0.25)
    heading: float = 0.0
    angle: float = 60.0
    rolls: int = 2
    seconds: float = 1.5
    hold: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_place("at", self.at)

    def tracks(self, ground: Ground) -> tuple[Track, ...]:
        """One finger that sways."""
        patch = ground.patch(self.patch)
        middle, width = ground.point(patch, self.at), self.radius * np.deg2rad(self.angle)
        heading = self._heading(ground, patch, middle)
        sides = [ground.straight(patch, middle, middle + sign * width * heading) for sign in (-1.0, 1.0)]
        line = np.concatenate([sides[0][:0:-1], sides[1]])
        turns = np.linspace(0.0, self.rolls, self.rolls * _SAMPLES + 1)
        # The middle is where the two sides meet; on a curved skin they are not quite as long as the tangent.
        place = lengths(line) - lengths(sides[0])[-1]
        sway = width * np.sin(2 * np.pi * turns)
        points = np.stack([np.interp(sway, place, line[:, k]) for k in range(3)], axis=1)
        times = np.concatenate([[0.0], self.hold + self.seconds * turns])
        points = np.concatenate([points[:1], points])
        return (Track(0, self.tip, times, np.full(len(times), patch), points),)

    def _heading(self, ground: Ground, patch: int, point: FloatArray) -> FloatArray:
        """(3,) unit vector along the skin at ``point``, link frame."""
        normal = ground.skin.normal(ground.surface_point(patch, point))
        axes = long_axes(ground.skin.patches[patch])
        # The long axis may stand on the skin, as on a cap: the next one lies on it then.
        along = axes[0] if abs(axes[0] @ normal) < 0.9 else axes[1]
        along = along - (along @ normal) * normal
        along /= np.linalg.norm(along)
        turn = np.deg2rad(self.heading)
        return np.asarray(np.cos(turn) * along + np.sin(turn) * np.cross(normal, along))
