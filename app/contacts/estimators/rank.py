"""How much of a distribution the readings tell."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray

_ROUNDING = 1e-12


@dataclass(frozen=True)
class Rank:
    """Of a linear system, seen through noise.

    Attributes:
        condition: Largest over smallest singular value.
        effective: How many singular values lie above noise / rms(readings) times the largest: a contact that is spread
            evenly over all of them stands out of the noise in these, and what lies below comes out as noise.
        unknowns: How many there are.
    """

    condition: float
    effective: int
    unknowns: int

    @property
    def refusal(self) -> str:
        """Why no distribution can be told, in words; empty where it can."""
        if 2 * self.effective >= self.unknowns:
            return ""
        told = f"Only {self.effective} of {self.unknowns} forces can be told apart"
        return f"{told}: the cover is too deep for the taxels' spacing, or the noise too great"


def rank_of(values: FloatArray, readings: FloatArray, noise: float, *, unknowns: int) -> Rank:
    """The rank of a system with singular ``values`` (s,), falling, for these ``readings`` (m,) [Pa] and ``noise``."""
    if not len(values) or values[0] <= 0:
        return Rank(float("inf"), 0, unknowns)
    strength = float(np.sqrt(np.mean(np.square(readings))))
    share = noise / strength if strength > 0 else float("inf")
    effective = int((values > max(share, _ROUNDING) * values[0]).sum())
    whole = len(values) >= unknowns and values[-1] > 0
    return Rank(float(values[0] / values[-1]) if whole else float("inf"), effective, unknowns)
