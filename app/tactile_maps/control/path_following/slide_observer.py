"""Missing map velocity of a contact that moves to a target: attempted motion of the arm less motion of the contact.

A moving target is followed with its velocity and a speed proportional to the error. The contact then lags by the
missing
velocity over the gain:

* On curved skin the point of contact rolls: an object of radius R on skin of radius r moves at r / (r + R) of the speed
  at which the skin slides.
* Friction bends the arm, and the deflection turns with the direction of motion.
* The Jacobian of the map has errors.

``SlideObserver`` estimates the missing velocity w by a first-order filter with the rate L (disturbance observer,
Ohnishi, Shibata and Murakami 1996). Added to the request of a position gain K, w = L e + K L times the integral of e:
constant disturbances leave no error, and without any the contact moves as without the observer. The poles are at K and
L.

Errors of the measured place repeat with the taxels, at 2 pi v / pitch for the speed v. The observer follows them too,
so ``observer_rate`` keeps L well below that.
"""

from __future__ import annotations

import math

import numpy as np

from tactile_maps.core.arrays import FloatArray, length, within_length

MOST_MISSING = 0.01
"""Bound of the missing velocity [m/s], and no more than the speed of the path: faster sliding disturbs the force. It is
higher where rolling takes more."""
ROLLING_RADIUS = 0.03
"""Radius R up to which the rolling of an object is made up for [m]. At the speed v that takes v R / r on skin of radius
r, which exceeds v where r is less than R."""
_MOST_ROLLING = 2.0
"""Bound of R / r: sharper edges are narrower than the object, and passed before the observer has followed."""
_JUMP = 0.005
"""A contact that moves farther within a tick has crossed a seam, behind which directions on the map differ [m]."""
COARSE = 0.0125
"""Pitch of taxels above which the observer is not used [m]: the measured place of a contact then errs by millimetres,
with the period of the taxels, and the arm would follow these errors."""
LATTICE_SHARE = 0.4
"""Greatest rate of the observer in proportion to the frequency at which the contact passes taxels."""


def observer_rate(position_gain: float, speed: float, pitch: float) -> float:
    """Return the rate of the observer [1/s].

    Args:
        position_gain: Gain of the position error [1/s], which the rate does not exceed.
        speed: Speed of the path [m/s].
        pitch: Distance between taxels [m].
    """
    return min(position_gain, LATTICE_SHARE * 2 * math.pi * speed / pitch)


class SlideObserver:
    """Estimates the missing map velocity of a contact. Mutable; ``reset`` forgets it.

    Attributes:
        missing: (2,) estimate [m/s].
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start from no missing velocity."""
        self.missing: FloatArray = np.zeros(2)
        self._contact: int | None = None
        self._point: FloatArray = np.zeros(2)

    def look(
        self,
        contact: int,
        point: FloatArray,
        tried: FloatArray,
        dt: float,
        *,
        rate: float,
        speed: float,
        curvature: float,
    ) -> FloatArray:
        """Return the missing velocity (2,) [m/s] after one more tick.

        Args:
            contact: Identifier of the contact; another one starts from zero.
            point: (2,) place of the contact on the map [m].
            tried: (2,) map velocity that the arm was to make in the last tick [m/s].
            dt: Time since the last tick [s].
            rate: Rate of the filter [1/s].
            speed: Speed of the path [m/s], for the bound.
            curvature: Curvature of the skin along the path [1/m], for the bound.
        """
        moved = point - self._point
        if contact != self._contact or length(moved) > _JUMP:
            self.reset()
        else:
            share = min(rate * dt, 1.0)
            self.missing = self.missing + share * (tried - moved / dt - self.missing)
            most = min(MOST_MISSING, speed) * min(max(1.0, ROLLING_RADIUS * curvature), _MOST_ROLLING)
            self.missing = within_length(self.missing, most)
        self._contact = contact
        self._point = point
        return self.missing


SOFT = 0.003
"""Way that joints yield along the skin to a friction equal to the force goal, above which they count as soft [m]."""
YIELD_RATE = 40.0
"""Rate with which the yielding of soft joints is made up for [1/s]; the frequency of the posture loop."""
YIELD_SHARE = 1.0
"""Share of the lost speed that is added at once. With a posture loop of the frequency w and critical damping, the rate
w and this share the poles are those of  s (s² + 2 w s + w²) + w² (w + s) = (s + w) (s² + w s + w²),  with a damping
ratio of 0.5; without the share it is 0.16."""
MOST_YIELDING = 0.1
"""Bound of the speed that makes up for yielding [m/s]."""


class YieldObserver:
    """Map velocity that makes up for the yielding of soft joints to friction. Mutable; ``reset`` forgets it.

    Where the direction of sliding turns, friction turns with it, and the desired posture has to move by twice the
    deflection before the contact does. This is a PI controller of the speed with which the measured posture moves the
    skin under the contact. Encoders have no errors that repeat with the taxels, so it may be faster than
    ``SlideObserver``.

    Attributes:
        added: (2,) velocity that makes up for yielding [m/s].
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start from zero."""
        self.added: FloatArray = np.zeros(2)
        self._integral: FloatArray = np.zeros(2)

    def look(self, tried: FloatArray, moved: FloatArray, dt: float) -> FloatArray:
        """Return the velocity to add (2,) [m/s] after one more tick.

        Args:
            tried: (2,) map velocity of the desired posture in the last tick, with ``added`` [m/s].
            moved: (2,) map velocity of the measured posture [m/s].
            dt: Time since the last tick [s].
        """
        lost = tried - self.added - moved
        self._integral = within_length(self._integral + YIELD_RATE * dt * lost, MOST_YIELDING)
        self.added = within_length(self._integral + YIELD_SHARE * lost, MOST_YIELDING)
        return self.added
