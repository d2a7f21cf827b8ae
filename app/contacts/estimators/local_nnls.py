"""Pressures that are not negative and explain a region's readings best."""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from app.contacts.estimators.estimate import ForceEstimate, Reading
from app.contacts.estimators.rank import rank_of
from app.contacts.estimators.spread import Spread
from app.skin.skin import Skin


class LocalNnls:
    """Non-negative least squares (Lawson and Hanson, 1974) on the region and its ring alone. Built once for a skin.

    Only there: over a whole map the constraint turns noise into force, up to 80 % too much. Contact cannot pull, and
    that alone tames the blur's inverse. Net shear is not observable.

    Args:
        skin: The skin.
        depth: Of the taxels below the surface [m], > 0.

    Raises:
        MapError: The depth is no such number.
    """

    def __init__(self, skin: Skin, *, depth: float) -> None:
        self._areas, self._spread = skin.areas, Spread(skin, depth)

    def estimate(self, reading: Reading) -> ForceEstimate:
        """Force and, unless refused, its distribution. Cost: 0.2 ms for 30 taxels that were touched before."""
        region = reading.region
        matrix, own = self._spread.matrix(region.taxels), reading.pressures.take(region.taxels)
        pressures, missed = nnls(matrix, own)
        values = np.asarray(np.linalg.svd(matrix, compute_uv=False), dtype=np.float64)
        rank = rank_of(values, own, reading.noise, unknowns=len(own))
        forces, refused = pressures * self._areas.take(region.taxels), rank.refusal
        none = slice(0, 0 if refused else None)
        return ForceEstimate(
            float(forces.sum()), region.at, region.taxels[none], forces[none], rank.condition, rank.effective,
            rank.unknowns, float(missed / np.sqrt(len(own))), reading.noise, refused,
        )  # fmt: skip
