"""What the estimators share that undo the cover's blur: the equations of a region, and what is said of their answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from app.arrays import FloatArray
from app.contacts.estimators.blur import Blur
from app.contacts.estimators.estimate import ForceEstimate, Reading
from app.contacts.estimators.rank import rank_of
from app.contacts.estimators.spread import Spread
from app.skin.skin import Skin


class Solution(NamedTuple):
    """Pressures on the areas above taxels, and the linear way from small changes of readings to theirs.

    Attributes:
        pressures: (n,) [Pa].
        slope: (n, m) by how much each pressure changes per reading.
    """

    pressures: FloatArray
    slope: FloatArray


Solver: TypeAlias = Callable[[Blur, FloatArray, float], Solution]
"""From the blur of n areas over m taxels, the taxels' readings (m,) [Pa] and their noise [Pa] to pressures."""


class Unblurred:
    """Pressures on a region and its ring that explain its readings, found by a solver. Built once for a skin.

    Only there: what lies farther off is noise, see the solvers. The force is the sum of pressure times area. It is told
    even where its distribution is refused. Net shear is not observable.

    Args:
        skin: The skin.
        solver: How.
        depth: Of the taxels below the surface [m], > 0.

    Raises:
        MapError: The depth is no such number.
        SimulationError: The cover is too deep for so fine a skin.

    Cost: as ``Spread`` to build.
    """

    def __init__(self, skin: Skin, solver: Solver, *, depth: float) -> None:
        self._areas, self._solver, self._spread = skin.areas, solver, Spread(skin, depth)

    def estimate(self, reading: Reading) -> ForceEstimate:
        """Force and, unless refused, its distribution. Cost: 0.15 ms for 30 taxels that were touched before."""
        taxels = reading.region.taxels
        blur, own, areas = self._spread.blur(taxels), reading.pressures.take(taxels), self._areas.take(taxels)
        pressures, slope = self._solver(blur, own, reading.noise)
        rank = rank_of(blur.values, own, reading.noise, unknowns=len(own))
        missed = blur.matrix @ pressures - own
        per_reading = areas @ slope
        variance = np.square(per_reading) @ (reading.noise**2 + np.square(reading.gain * own))
        forces, refused = pressures * areas, rank.refusal
        answer = ForceEstimate(
            force=float(forces.sum()),
            at=reading.region.at,
            condition=rank.condition,
            effective_rank=rank.effective,
            unknowns=rank.unknowns,
            residual=float(np.sqrt(missed @ missed / len(own))),
            noise=reading.noise,
            force_error=float(np.sqrt(variance)),
            refused=refused,
        )
        if refused:
            return answer
        peak, pressed = float(pressures.max(initial=0.0)), pressures > 0
        mean = float(forces[pressed].sum() / areas[pressed].sum()) if pressed.any() else 0.0
        return replace(answer, taxels=taxels, forces=forces, peak=peak, mean=mean)
