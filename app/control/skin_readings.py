"""What a controller knows of the skin's readings: how often they come, how late, and how high they go."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.contacts.region import ContactRegion

PLATEAU = "the skin reads its highest, and is pressed no more"
_NEAR = 0.98
"""Share of the highest reading from which a taxel may stand at it: noise and steps of the converter hide the rest."""


@dataclass(frozen=True)
class SkinReadings:
    """Of a skin as its maker says.

    Attributes:
        period: From one sample to the next [s]; > 0.
        delay: From a sample to its arrival [s].
        highest: What a taxel reads at most [Pa].
    """

    period: float
    delay: float = 0.0
    highest: float = math.inf

    def __str__(self) -> str:
        late = f", {1e3 * self.delay:.0f} ms late" if self.delay else ""
        return f"read at {1 / self.period:.3g} Hz{late}"


def at_least(regions: Sequence[ContactRegion], goal: float, highest: float) -> tuple[tuple[ContactRegion, ...], bool]:
    """The regions as a law may take them, and whether a taxel stands at its ``highest`` reading [Pa] in any.

    The force on such a region is at least what is read. It counts as no less than the ``goal`` [N], or the law would
    press on and on and read the same.
    """
    if not any(region.peak >= _NEAR * highest for region in regions):
        return tuple(regions), False
    taken = [
        replace(region, force=max(region.force, goal)) if region.peak >= _NEAR * highest else region
        for region in regions
    ]
    return tuple(sorted(taken, key=lambda region: (-region.force, region.id))), True
