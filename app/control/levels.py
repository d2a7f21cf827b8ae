"""Joint velocities from wanted velocities of rows, level by level: what is less wanted keeps out of what is more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, length
from app.control.reference import DAMPING, WEAK

_RANK = 1e-6
"""Singular values below this share of the largest carry nothing."""


@dataclass(frozen=True, eq=False)
class Level:
    """Rows that are wanted equally.

    Attributes:
        rows: (m, n) in metres per unit of joint velocity.
        speed: (m,) what they should give [m/s].
    """

    rows: FloatArray
    speed: FloatArray


def solve_levels(levels: Sequence[Level], rest: FloatArray) -> tuple[FloatArray, bool]:
    """Least joint velocity (n,) for the levels in order, and whether any was damped (Siciliano and Slotine 1991).

    Args:
        levels: The most wanted first.
        rest: (n,) joint velocity wanted where the levels leave it free.

    Damping acts on weak directions only, and grows from zero where a direction's gain falls under ``WEAK`` (Nakamura
    and Hanafusa 1986, one by one); it is chosen so that the greatest speed of a point never asks for more than the
    greatest speed of a joint. The projector behind which the next level works is not damped: a damped one leaks. Both
    come from the same singular values.

    Cost: 15 µs a level.
    """
    speed, damped = np.zeros(len(rest)), False
    felt: list[FloatArray] = []  # orthonormal rows of every level, one after the other: what is used up
    for level in levels:
        if not level.rows.size:
            continue
        left, gains, right = directions(_beside(felt, level.rows))
        share = (level.speed - level.rows.dot(speed)).dot(left)
        parts = list(zip(gains.tolist(), share.tolist(), strict=True))
        speed = speed + np.array([part * gain / (gain**2 + damping(gain)) for gain, part in parts]).dot(right)
        damped = damped or any(gain < WEAK and abs(part) > 1e-4 for gain, part in parts)
        felt.append(right[: sum(gain > max(_RANK * parts[0][0], 1e-12) for gain, _ in parts)])
    return speed + _beside(felt, rest), damped


def _beside(felt: Sequence[FloatArray], rows: FloatArray) -> FloatArray:
    """The part of ``rows`` (n,) or (m, n) that none of the ``felt`` rows (k, n) feels."""
    for used in felt:
        rows = rows - rows.dot(used.T).dot(used)
    return rows


def directions(rows: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Left singular vectors (m, k), values (k,) and right vectors (k, n) of ``rows`` (m, n), m > 0.

    A single row has itself.
    """
    strength = length(rows[0])
    if len(rows) > 1 or not strength:
        return np.linalg.svd(rows, full_matrices=False)
    return np.ones((1, 1)), np.array((strength,)), rows / strength


def damping(gain: float) -> float:
    """What is added to the square of a gain [m/rad] where least squares divide by it."""
    return DAMPING**2 * max(1 - (gain / WEAK) ** 2, 0.0)
