"""The default: pressure times area, summed over the touched taxels and their ring."""

from __future__ import annotations

import numpy as np

from app.contacts.estimators.estimate import ForceEstimate, Reading
from app.contacts.estimators.rank import rank_of
from app.skin.skin import Skin


class AreaSum:
    """Takes readings for what presses right above. Built once for a skin.

    Every taxel is its own equation, so nothing is ill-conditioned. A cover's blur moves force from taxel to taxel, but
    hardly out of the region and its ring: totals stay within a few percent. What is lost is the shape: peaks come out
    too low and too wide. Net shear is not observable.

    Args:
        skin: The skin.
    """

    def __init__(self, skin: Skin) -> None:
        self._areas = skin.areas

    def estimate(self, reading: Reading) -> ForceEstimate:
        """The sum. Cost: 15 µs."""
        region = reading.region
        own = reading.pressures.take(region.taxels)
        forces = own * self._areas.take(region.taxels)
        rank = rank_of(np.ones(len(own)), own, reading.noise, unknowns=len(own))
        return ForceEstimate(
            float(forces.sum()), region.at, region.taxels, forces, rank.condition, rank.effective, rank.unknowns,
            noise=reading.noise,
        )  # fmt: skip
