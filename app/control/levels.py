"""Joint velocities from wanted velocities of rows, level by level: what is less wanted keeps out of what is more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
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
    greatest speed of a joint. The projector behind which the next level works is not damped: a damped one leaks.

    Cost: 30 µs a level.
    """
    speed, free, damped = np.zeros(len(rest)), np.eye(len(rest)), False
    for level in levels:
        part, weak = _damped(level.rows @ free, level.speed - level.rows @ speed)
        speed, damped = speed + free @ part, damped or weak
        free = free @ _kernel(level.rows @ free)
    return speed + free @ rest, damped


def _damped(rows: FloatArray, wanted: FloatArray) -> tuple[FloatArray, bool]:
    if not rows.size:
        return np.zeros(rows.shape[1]), False
    left, gains, right = np.linalg.svd(rows, full_matrices=False)
    share = left.T @ wanted
    damping = np.where(gains < WEAK, DAMPING**2 * (1 - (gains / WEAK) ** 2), 0.0)
    answer = right.T @ (gains / np.maximum(gains**2 + damping, 1e-300) * share)
    lost = (gains < WEAK) & (np.abs(share) > 1e-4)
    return answer, bool(lost.any())


def _kernel(rows: FloatArray) -> FloatArray:
    """(n, n) projector on what rows (m, n) do not feel."""
    n = rows.shape[1]
    if not rows.size:
        return np.eye(n)
    _, gains, right = np.linalg.svd(rows, full_matrices=False)
    felt = right[gains > max(_RANK * float(gains[0]), 1e-12)]
    return np.eye(n) - felt.T @ felt
