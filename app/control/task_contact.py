"""What a task wants of a contact, and that contact as a law meets it: rows of Jacobians and errors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from app.arrays import FloatArray, length
from app.contacts.region import ContactRegion
from app.maps.map_jacobian import least_motion


@dataclass(frozen=True, eq=False)
class Want:
    """What a task wants of one contact.

    Attributes:
        region: Which.
        force: Goal [N].
        error: (2,) the way to go on the map [m]; None where the contact may slide as it likes.
        velocity: (2,) at which the goal itself moves on the map [m/s].
        to_map: (2, 3) the map's Jacobian at the contact, world frame, where it was asked for already.
    """

    region: ContactRegion
    force: float
    error: FloatArray | None = None
    velocity: FloatArray | None = None
    to_map: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class TaskContact:
    """A contact with what is wanted of it, at one posture, world frame.

    Attributes:
        id: Of the region.
        force: Measured [N].
        force_error: Wanted minus measured [N].
        normal: (3,) outward.
        point: (3,) [m].
        move: (3, n) velocity of the point of the skin per joint velocity.
        to_map: (2, 3) map velocity per velocity along the skin; what stands still in the world moves by minus that.
            Zero where the contact may slide: nobody asks.
        error: (2,) on the map [m]; None where the contact may slide.
        velocity: (2,) of the goal on the map [m/s].
    """

    id: int
    force: float
    force_error: float
    normal: FloatArray
    point: FloatArray
    move: FloatArray
    to_map: FloatArray
    error: FloatArray | None
    velocity: FloatArray

    @cached_property
    def outward(self) -> FloatArray:
        """(n,) outward speed of the point per joint velocity: it presses more."""
        return self.normal.dot(self.move)

    @cached_property
    def map_axes(self) -> FloatArray:
        """(2, 3) the map's two axes along the skin as nearly as can be: of length one and square to each other."""
        left, _, right = np.linalg.svd(self.to_map, full_matrices=False)
        return left.dot(right)

    def along(self, gain: float, most: float) -> FloatArray:
        """(3,) velocity of the skin [m/s] that brings the contact on: what stands still in the world slides back on it.

        Args:
            gain: Speed per error [1/s].
            most: Greatest speed [m/s].
        """
        if self.error is None:
            return np.zeros(3)
        wanted = -least_motion(self.to_map, gain * self.error + self.velocity)
        speed = length(wanted)
        return wanted * (most / speed) if speed > most else wanted
