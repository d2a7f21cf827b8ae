"""How well the joints move a touched point off the skin, and what becomes of a force where they hardly do.

Where every motion of the joints takes a point mostly along the skin, the little that it goes off hangs on the normal: a
normal that errs by more than the angle of that motion to the skin turns the answer to a force around, and the arm
presses where it means to yield. Links with hollow skin collide as convex pieces, of which 95 % of the normals err by at
most 8 to 13 degrees; flat and convex links collide as their hull.

So there a point is moved straight along the normal as far as the joints can (the least squares of all three
directions), it slides no faster than lets the force rise slowly, and where the force still rises, the arm stands.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.core.arrays import FloatArray, length

LEAST_TILT = math.radians(15)
ENOUGH_TILT = math.radians(25)
"""Errors of a normal that have to be expected [rad]: of the pieces that collide, of misplaced taxels; and what is
enough for any speed."""
LEAST_ASIDE = 0.01
MOST_ASIDE = 1.0
"""Of a point that slides on its way along such a normal [m/s]. With an error of 15 degrees and 2e4 N/m the force then
rises by 1 N in 20 ms; and what is no bound any more."""


def bearable_tilt(outward: FloatArray, move: FloatArray) -> float:
    """By how much a normal may err [rad] until the joint motion that presses most by it presses less.

    It is the angle from the skin at which that motion takes the point off. Where it is small the point slides a long
    way for little force, and a normal that errs by more turns the force's answer around.

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
    wanted: float = 0.0,
) -> FloatArray:
    """The joint velocity (n,), all of it slower if it takes a point along the skin much faster than wanted.

    Args:
        move: (3, n) velocity of the point per joint velocity.
        normal: (3,) there.
        tilt: That it bears [rad].
        speed: (n,).
        limits: Told if so.
        wanted: Along the skin [m/s].
    """
    if tilt >= ENOUGH_TILT:
        return speed
    share = max(tilt - LEAST_TILT, 0.0) / (ENOUGH_TILT - LEAST_TILT)
    most = wanted + LEAST_ASIDE * (MOST_ASIDE / LEAST_ASIDE) ** share
    way = move.dot(speed)
    along = way - normal.dot(way) * normal
    aside = length(along)
    if aside <= most:
        return speed
    x, y, z = (along / aside).tolist()
    limits.add(Limit(LimitKind.WEAK_DIRECTION, value=aside - most, direction=(x, y, z)))
    return speed * (most / aside)


RISE_SHARE = 0.25
"""Of the greatest force that is allowed, by which one may rise that is to fall, until the arm stands."""


class RisingForces:
    """Notices that a force rises which the arm lets fall. Mutable.

    One that bears much tilt is never judged: what presses it harder is something else.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Nothing touches."""
        self._least: dict[tuple[int, float], float] = {}
        self._standing = False

    def look(self, contacts: Iterable[tuple[int, float, float, float]], max_force: float) -> bool:
        """Whether the arm has to stand: until the force is half way back.

        Args:
            contacts: Number, force [N], goal [N] and the tilt that is borne [rad] of each.
            max_force: At which the arm is stopped [N].
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
