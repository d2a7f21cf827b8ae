"""Friction in use at each taxel: the traction along the skin as a share of the friction limit there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.tactile.mechanics.coulomb_bed import STUCK

TAXEL_SLIPS = STUCK
"""Friction in use from which a taxel slips."""


def friction_in_use(regions: Sequence[ContactRegion], pressures: FloatArray, shear: FloatArray) -> FloatArray:
    """Return the friction in use (taxels,) of pressed taxels: 0 without traction, 1 at the limit; NaN elsewhere.

    Args:
        regions: Contacts with their shear, which states the friction coefficient; others are ignored.
        pressures: (taxels,) readings [Pa].
        shear: (taxels, 2) tractions along t1 and t2 [Pa].
    """
    used = np.full(len(pressures), np.nan)
    for region in regions:
        if region.shear is not None:
            own = region.taxels[pressures[region.taxels] > 0]
            used[own] = np.linalg.norm(shear[own], axis=1) / (region.shear.friction * pressures[own])
    return used
