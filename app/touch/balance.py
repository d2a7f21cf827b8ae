"""A stiff body on a bed of springs, pressed by a force at a place: how deep it sinks and how far it tilts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from app.arrays import FloatArray, dot

_ENOUGH = 1e-9
"""Force and moment are matched when they are off by less than this share of the force, and of it times the bed's size.

The last step is exact but for rounding, which is what this leaves room for under a force of a micronewton."""
_ROUNDS = 40
_HALVINGS = 40
_RIDGE = 1e-9
"""Share of the bed's stiffness added where too few springs are under load to hold all tilts."""


class Balance(NamedTuple):
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


def balanced(gaps: FloatArray, areas: FloatArray, offsets: FloatArray, volume: float, *, level: float) -> Balance:
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
    plane, wanted = np.array([level, 0.0, 0.0]), np.array([volume, 0.0, 0.0])
    if (offsets.min(axis=0) * offsets.max(axis=0) > 0).any():  # all springs are on one side of the force
        return Balance(np.zeros(len(gaps)), plane, 0, False)
    for rounds in range(_ROUNDS):
        sunk = np.einsum("i,ij->j", plane, basis) - gaps
        borne = areas * np.maximum(sunk, 0.0)
        missing = wanted - np.einsum("ij,j->i", basis, borne)
        if np.abs(missing).max() <= _ENOUGH * volume:
            return Balance(borne, plane / [1.0, size, size], rounds, True)
        under = np.flatnonzero(borne)
        loaded = basis.take(under, axis=1)
        stiffness = np.einsum("ij,kj->ik", loaded * areas.take(under), loaded)
        ridge = _RIDGE * (np.trace(stiffness) or 1.0)
        step = np.linalg.solve(stiffness + ridge * np.eye(3), missing)
        plane = plane + step * _share(float(wanted @ step), np.einsum("i,ij->j", step, basis), areas, sunk)
    return Balance(borne, plane, _ROUNDS, False)


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

    share, enough = 1.0, -0.5 * slope(0.0)
    for _ in range(_HALVINGS):
        if slope(share) >= enough:
            break
        share *= 0.5
    return share
