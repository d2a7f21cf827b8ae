"""Depth and tilt of a body on a bed of springs (a Winkler foundation; Johnson, Contact Mechanics, 4.3).

``winkler_level`` finds the level d with  sum A max(0, d - g) = volume  exactly, for a body that does not tilt.
``winkler_tilt`` finds the plane d + t x for a body pressed by a force at a place. Both use Newton's method on a convex,
piecewise polynomial function, so both end exactly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, dot


class Support(NamedTuple):
    """Springs under load, in the picture of floors under water.

    Attributes:
        points: (k,) indices of the floors, increasing.
        floors: (k,) their heights.
        areas: (k,) their areas.
        level: Level of the water, at least as high as the floors.
    """

    points: IntArray
    floors: FloatArray
    areas: FloatArray
    level: float


class WarmStart:
    """Floors under water at the last call, the initial guess of the next. It does not change results. Mutable.

    Attributes:
        mask: (n,) whether each floor was under water, as bytes; empty before the first call.
        points: (k,) indices of these floors.
        areas: (k,) their areas.
        total: Sum of the areas.
    """

    __slots__ = ("areas", "mask", "points", "total")

    def __init__(self) -> None:
        self.mask = b""

    def update(self, wet: BoolArray, floors: FloatArray, areas: FloatArray) -> None:
        """Store the floors that are ``wet`` (n,), or the lowest if none is."""
        self.mask = wet.tobytes()
        points = wet.nonzero()[0]
        self.points: IntArray = points if points.size else floors.argmin(0, keepdims=True)
        self.areas: FloatArray = areas.take(self.points)
        self.total = float(self.areas.sum())


def winkler_level(floors: FloatArray, areas: FloatArray, volume: float, *, guess: WarmStart | None = None) -> Support:
    """Find the level d with  sum areas max(0, d - floors) = volume  exactly.

    Newton's method on a convex, piecewise linear function: each set of floors determines a level, and if the floors
    below that level are the same set, it is the solution. The first step leads to the solution or above, and all others
    down, so it ends. Nothing is sorted, and the result does not depend on the guess.

    Args:
        floors: (n,) heights, not all inf; floors at inf stay dry.
        areas: (n,) areas, > 0.
        volume: Volume, >= 0; one that rounds to 0 wets the lowest floor alone.
        guess: Guess for the same floors at other heights; it is updated.

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
    here = floors.take(guess.points)  # two levels that differ by rounding alternate: a floor is between them
    return Support(guess.points, here, guess.areas, float(np.max(here, initial=level)))


_TOLERANCE = 1e-9
"""Tolerance of force and moment, as a share of the force and of the force times the bed's size.

The last step is exact up to rounding, for which this is sufficient down to a force of a micronewton."""
_MAX_ITERATIONS = 40
_HALVINGS = 40
_RIDGE = 1e-9
"""Share of the bed's stiffness that is added where the loaded springs do not determine all tilts."""


class TiltedSupport(NamedTuple):
    """Depths and forces of a bed under a tilted body.

    Attributes:
        borne: (n,) volume by which each spring yields [m³]; times the foundation's stiffness it is the spring's force.
        plane: (3,) depth [m] at the place of the force and tilts about it (see ``balanced``).
        rounds: Number of Newton steps.
        matched: Whether force and place are matched; otherwise ``borne`` is undefined.
    """

    borne: FloatArray
    plane: FloatArray
    rounds: int
    matched: bool


def winkler_tilt(
    gaps: FloatArray, areas: FloatArray, offsets: FloatArray, volume: float, *, level: float
) -> TiltedSupport:
    """Find the plane d + t·x for which  sum A max(0, d + t·x - g) = volume  with its mean place at x = 0.

    It minimizes the bed's energy,  1/2 sum A max(0, d + t·x - g)² - volume d,  which is convex, by Newton's method with
    a line search: its pieces are quadratic, so the last step is exact. No plane exists if x = 0 is outside the hull of
    the springs.

    Args:
        gaps: (n,) gaps between body and springs without tilt [m].
        areas: (n,) areas of the springs [m²].
        offsets: (n, 2) offsets x of the springs along the bed from the place of the force [m].
        volume: Force over the foundation's stiffness [m³], > 0.
        level: Initial depth [m]; that of the body without tilt is best.

    Cost: 2 to 7 rounds of 30 µs for a few hundred springs, more where a small force is far from the lowest of them.
    """
    # einsum uses one thread; BLAS uses several from 3,000 springs on, which is slower here (see arrays.dot).
    size = float(np.sqrt(np.einsum("ij,ij->i", offsets, offsets).max())) or 1.0
    basis = np.stack([np.ones(len(gaps)), *(offsets.T / size)])
    plane = np.array([level, 0.0, 0.0])
    target = np.array([volume, 0.0, 0.0])
    if (offsets.min(axis=0) * offsets.max(axis=0) > 0).any():  # all springs are on one side of the force
        return TiltedSupport(np.zeros(len(gaps)), plane, 0, False)
    for rounds in range(_MAX_ITERATIONS):
        sunk = np.einsum("i,ij->j", plane, basis) - gaps
        borne = areas * np.maximum(sunk, 0.0)
        missing = target - np.einsum("ij,j->i", basis, borne)
        if np.abs(missing).max() <= _TOLERANCE * volume:
            return TiltedSupport(borne, plane / [1.0, size, size], rounds, True)
        under = np.flatnonzero(borne)
        loaded = basis.take(under, axis=1)
        stiffness = np.einsum("ij,kj->ik", loaded * areas.take(under), loaded)
        ridge = _RIDGE * (np.trace(stiffness) or 1.0)
        step = np.linalg.solve(stiffness + ridge * np.eye(3), missing)
        plane = plane + step * _share(float(target @ step), np.einsum("i,ij->j", step, basis), areas, sunk)
    return TiltedSupport(borne, plane, _MAX_ITERATIONS, False)


def _share(work: float, bending: FloatArray, areas: FloatArray, sunk: FloatArray) -> float:
    """Return the share of a step to take, less than 1 if it overshoots, from the slope of the energy.

    The slope is used because differences of energies are lost in rounding.

    Args:
        work: Work of the force over the whole step, over the foundation's stiffness.
        bending: (n,) change of ``sunk`` by the step.
        areas: (n,) areas of the springs.
        sunk: (n,) depth of the body below the springs' free ends.
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
