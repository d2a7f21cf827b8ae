"""Motion of a contact point along its normal where the joints hardly provide it.

Where every joint motion moves a point mostly along the skin, the small normal part depends on the normal: if the normal
errs by more than the angle between that motion and the skin, the response to a force changes its sign, and the arm
presses where it should yield. Links with hollow skin collide as convex pieces, whose normals err by at most 8 to 13
degrees in 95 % of cases; flat and convex links collide as their hull.

There a point is moved straight along the normal as far as the joints can (least squares in all three directions), it
slides only as fast as the force may rise, and the arm stops if the force still rises.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray, length

LEAST_TILT = math.radians(15)
ENOUGH_TILT = math.radians(25)
"""Errors of a normal [rad]: those to be expected from collision pieces and misplaced taxels, and the tolerance that is
enough for any speed."""
LEAST_ASIDE = 0.01
MOST_ASIDE = 1.0
"""Speeds along the skin of a point that moves along such a normal [m/s]: the allowed one, at which an error of 15
degrees and 2e4 N/m raise the force by 1 N in 20 ms, and one that is no longer a bound."""


def bearable_tilt(outward: FloatArray, move: FloatArray) -> float:
    """Return the error of a normal [rad] at which the joint motion that presses most stops pressing.

    It is the angle between that motion of the point and the skin. If it is small, the point slides far for little
    force, and a larger error of the normal changes the sign of the response.

    Args:
        outward: (n,) outward speed of the point per joint velocity.
        move: (3, n) velocity of the point per joint velocity.
    """
    way = length(move.dot(outward))
    return math.asin(min(float(outward.dot(outward)) / way, 1.0)) if way > 0 else math.pi / 2


def slow_aside(
    move: FloatArray,
    normal: FloatArray,
    tilt: float,
    speed: FloatArray,
    limits: ActiveLimits,
    *,
    desired: float = 0.0,
) -> FloatArray:
    """Return the joint velocity (n,), scaled down if it moves a point along the skin much faster than desired.

    Args:
        move: (3, n) velocity of the point per joint velocity.
        normal: (3,) normal at the point.
        tilt: Tolerated error of the normal [rad].
        speed: (n,) joint velocity.
        limits: Collects a ``WEAK_DIRECTION`` entry if the speed is scaled.
        desired: Desired speed along the skin [m/s].
    """
    if tilt >= ENOUGH_TILT:
        return speed
    share = max(tilt - LEAST_TILT, 0.0) / (ENOUGH_TILT - LEAST_TILT)
    most = desired + LEAST_ASIDE * (MOST_ASIDE / LEAST_ASIDE) ** share
    way = move.dot(speed)
    along = way - normal.dot(way) * normal
    aside = length(along)
    if aside <= most:
        return speed
    x, y, z = (along / aside).tolist()
    limits.add(Limit(LimitKind.WEAK_DIRECTION, value=aside - most, direction=(x, y, z)))
    return speed * (most / aside)


RISE_SHARE = 0.25
"""Share of the largest allowed force by which a force above its goal may rise until the arm stops."""


class RisingForces:
    """Detects that a force rises although the arm yields. Mutable.

    Contacts with a large tolerated error of the normal do not count: there something else presses harder.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard all contacts."""
        self._least: dict[tuple[int, float], float] = {}
        self._standing = False

    def look(self, contacts: Iterable[tuple[int, float, float, float]], max_force: float) -> bool:
        """Return whether the arm must stop: from a rise above the bound until half of it has gone.

        Args:
            contacts: Number, force [N], goal [N] and tolerated error of the normal [rad] of each contact.
            max_force: Force at which the safety monitor stops the arm [N].
        """
        least = dict[tuple[int, float], float]()
        risen = 0.0
        for contact, force, goal, tilt in contacts:
            if tilt < ENOUGH_TILT:
                above = max(force - goal, 0.0)
                least[contact, goal] = min(self._least.get((contact, goal), above), above)
                risen = max(risen, above - least[contact, goal])
        self._least = least
        self._standing = risen > RISE_SHARE * max_force * (0.5 if self._standing else 1.0)
        return self._standing
