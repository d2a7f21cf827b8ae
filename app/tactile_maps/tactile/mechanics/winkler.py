"""How a bed of springs (a Winkler foundation; Johnson, Contact Mechanics, 4.3) carries a body: how deep it sinks, and
how far it tilts.

``winkler_level`` finds the level d with  sum A max(0, d - g) = volume  exactly, for a body that stands straight;
``winkler_tilt`` the plane d + t x for a body pressed by a force at a place. Both are Newton's method on a convex
function made of polynomial pieces, so both end exactly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, dot


class Support(NamedTuple):
    """The floors under water, and the level.

    Attributes:
        points: (k,) indices of the floors, rising.
        floors: (k,) their heights.
        areas: (k,) theirs.
        level: Of the water, at least as high as they.
    """

    points: IntArray
    floors: FloatArray
    areas: FloatArray
    level: float


class WarmStart:
    """Which floors were under water the last time: where to begin, never the answer. Mutable.

    Attributes:
        mask: (n,) whether each was, as bytes; empty before the first time.
        points: (k,) which.
        areas: (k,) theirs.
        total: Their sum.
    """

    __slots__ = ("areas", "mask", "points", "total")

    def __init__(self) -> None:
        self.mask = b""

    def update(self, wet: BoolArray, floors: FloatArray, areas: FloatArray) -> None:
        """Take the floors that are ``wet`` (n,), or the lowest if none is."""
        self.mask = wet.tobytes()
        points = wet.nonzero()[0]
        self.points: IntArray = points if points.size else floors.argmin(0, keepdims=True)
        self.areas: FloatArray = areas.take(self.points)
        self.total = float(self.areas.sum())


def winkler_level(floors: FloatArray, areas: FloatArray, volume: float, *, guess: WarmStart | None = None) -> Support:
    """The level d with  sum areas max(0, d - floors) = volume,  exactly.

    Newton's method on a convex function made of straight pieces: for the floors of one piece the level is known, and if
    those are the floors below it, it is the answer. From any piece the first step leads to the answer or above, and
    from there down, so it ends. Nothing is sorted, and the answer does not depend on the guess.

    Args:
        floors: (n,) heights, not all inf; those of inf stay dry.
        areas: (n,) > 0.
        volume: >= 0; one so small that it rounds to nothing wets the lowest floor alone.
        guess: Of the same floors at another height; it is brought up to date.

    Cost: 2 µs when the guess is right, else 4 µs more for each of one to four steps, for 100 floors.
    """
    guess = WarmStart() if guess is None else guess
    if not guess.mask:
        guess.update(floors < math.inf, floors, areas)
    for _ in range(len(floors) + 2):
        here = floors.take(guess.points)
        level = (volume + dot(guess.areas, here)) / guess.total
        below = floors < level
        if below.tobytes() == guess.mask:
            return Support(guess.points, here, guess.areas, level)
        guess.update(below, floors, areas)
    here = floors.take(guess.points)  # two levels apart by rounding take turns: a floor lies just between
    return Support(guess.points, here, guess.areas, float(np.max(here, initial=level)))


_TOLERANCE = 1e-9
"""Force and moment are matched when they are off by less than this share of the force, and of it times the bed's size.

The last step is exact but for rounding, which is what this leaves room for under a force of a micronewton."""
_MAX_ITERATIONS = 40
_HALVINGS = 40
_RIDGE = 1e-9
"""Share of the bed's stiffness added where too few springs are under load to hold all tilts."""


class TiltedSupport(NamedTuple):
    """How a bed bears a body.

    Attributes:
        borne: (n,) volume that each spring gives way [m³]; times the foundation's stiffness it is the spring's force.
        plane: (3,) depth [m] at the place of the force and tilts about it (see ``balanced``).
        rounds: Newton's steps that it took.
        matched: Whether force and place are matched; where not, ``borne`` means nothing.
    """

    borne: FloatArray
    plane: FloatArray
    rounds: int
    matched: bool


def winkler_tilt(
    gaps: FloatArray, areas: FloatArray, offsets: FloatArray, volume: float, *, level: float
) -> TiltedSupport:
    """Find the plane d + t·x for which  sum A max(0, d + t·x - g) = volume  with its mean place at x = 0.

    It is the least of the bed's energy,  1/2 sum A max(0, d + t·x - g)² - volume d,  which is convex, by Newton's
    method with a line search: its pieces are quadratic, so the last step is exact. There is none when x = 0 lies
    outside the hull of the springs.

    Args:
        gaps: (n,) of the body over each spring when it stands straight [m].
        areas: (n,) of the springs [m²].
        offsets: (n, 2) of the springs along the bed from where the force acts, x [m].
        volume: Force over the foundation's stiffness [m³], > 0.
        level: Depth to start from [m]; the straight body's is best.

    Cost: 2 to 7 rounds of 30 µs for a few hundred springs, more where a small force is far from the lowest of them.
    """
    # einsum stays on this thread; BLAS wakes others from 3,000 springs on, which costs more than it saves (arrays.dot).
    size = float(np.sqrt(np.einsum("ij,ij->i", offsets, offsets).max())) or 1.0
    basis = np.stack([np.ones(len(gaps)), *(offsets.T / size)])
    plane = np.array([level, 0.0, 0.0])
    wanted = np.array([volume, 0.0, 0.0])
    if (offsets.min(axis=0) * offsets.max(axis=0) > 0).any():  # all springs are on one side of the force
        return TiltedSupport(np.zeros(len(gaps)), plane, 0, False)
    for rounds in range(_MAX_ITERATIONS):
        sunk = np.einsum("i,ij->j", plane, basis) - gaps
        borne = areas * np.maximum(sunk, 0.0)
        missing = wanted - np.einsum("ij,j->i", basis, borne)
        if np.abs(missing).max() <= _TOLERANCE * volume:
            return TiltedSupport(borne, plane / [1.0, size, size], rounds, True)
        under = np.flatnonzero(borne)
        loaded = basis.take(under, axis=1)
        stiffness = np.einsum("ij,kj->ik", loaded * areas.take(under), loaded)
        ridge = _RIDGE * (np.trace(stiffness) or 1.0)
        step = np.linalg.solve(stiffness + ridge * np.eye(3), missing)
        plane = plane + step * _share(float(wanted @ step), np.einsum("i,ij->j", step, basis), areas, sunk)
    return TiltedSupport(borne, plane, _MAX_ITERATIONS, False)


def _share(work: float, bending: FloatArray, areas: FloatArray, sunk: FloatArray) -> float:
    """How much of a step to take: less than all where it overshoots. The energy's slope tells; energies round off.

    Args:
        work: Of the force over the whole step, over the foundation's stiffness.
        bending: (n,) what the step adds to ``sunk``.
        areas: (n,) of the springs.
        sunk: (n,) how far below the springs' free ends the body is.
    """

    def slope(share: float) -> float:
        return work - dot(areas * np.maximum(sunk + share * bending, 0.0), bending)

    share = 1.0
    enough = -0.5 * slope(0.0)
    for _ in range(_HALVINGS):
        if slope(share) >= enough:
            break
        share *= 0.5
    return share
