"""Detection of values that fall under pressure, on a skin whose values are expected to rise.

After a tare, neighbouring taxels that fall far below their baseline together either are pressed and have the opposite
sign, or were touched during the tare and are released now. Both call for the user.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.detection import NOISE_LIMIT, TOUCH_THRESHOLD
from tactile_maps.contacts.detection.regions import TaxelGraph
from tactile_maps.contacts.detection.taxel_noise import TaxelNoise
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin

_FEWEST = 2
"""Number of taxels from which on they fall together."""
_READINGS = 5
"""Number of consecutive readings with a fall from which on it is reported."""
_TOUCHED = 3.0
"""Fall of each taxel, in standard deviations of its noise."""


class FallingValues:
    """Watcher of falling values. Mutable; ``reset`` starts again.

    A fall is a group of at least two neighbouring taxels below their baseline by three standard deviations of their
    noise each, and by six together, that no taxel rises as far as. A cover that bulges next to a contact also makes
    values fall, but by less than those of the contact rise.

    Args:
        skin: The skin.

    Attributes:
        found: Whether values fell in several consecutive readings.
        taxels: (k,) numbers of the taxels that fell when this was found first; empty before.

    Cost: 2 µs per reading without a fall.
    """

    def __init__(self, skin: Skin) -> None:
        self._areas = skin.areas
        self._graph = TaxelGraph(skin)
        self.reset()

    def reset(self) -> None:
        """Forget all falls."""
        self._row = 0
        self.found = False
        self.taxels: IntArray = np.zeros(0, dtype=np.int64)

    def add(self, pressures: FloatArray, noise: TaxelNoise | None) -> None:
        """Add a reading.

        Args:
            pressures: (taxels,) displayed pressures above the baseline [Pa].
            noise: Noise of the taxels; None if no reading of the tare differed.
        """
        fallen = self._fallen(-pressures, noise)
        self._row = self._row + 1 if len(fallen) else 0
        if self._row >= _READINGS and not self.found:
            self.found = True
            self.taxels = fallen

    def _fallen(self, depths: FloatArray, noise: TaxelNoise | None) -> IntArray:
        """Return the taxels (k,) of all falls in a reading."""
        found = np.zeros(len(depths), dtype=bool)
        deepest = float(depths.max())
        if deepest < TOUCH_THRESHOLD or deepest <= -float(depths.min()):
            return found.nonzero()[0]
        fallen = depths >= TOUCH_THRESHOLD
        if noise is not None:
            fallen &= depths >= noise.limits(_TOUCHED)
        for group in self._graph.groups(fallen.nonzero()[0].tolist()):
            taxels = np.array(sorted(group.core))
            areas = self._areas[taxels]
            forces = areas * depths[taxels]
            if len(taxels) >= _FEWEST and (noise is None or noise.exceeded(NOISE_LIMIT, forces, taxels, areas)):
                found[taxels] = True
        return found.nonzero()[0]
