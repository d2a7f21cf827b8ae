"""Shear channels of a real skin: newest values, tare, and channels that are missing or of no taxel.

A three-axis taxel sends its pressure and two values along t1 and t2. Only complete values are used: where one of the
three is missing, the taxel keeps its previous shear, and it is counted and named.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.live.channels.tare import Tare
from tactile_maps.skin.model.skin import Skin

_MOST_NAMED = 1000
"""Number of taxels with wrong channels that are kept by name; all are counted."""


class ShearChannels:
    """Newest shear of the taxels of a skin, in the unit of the readings. Mutable.

    Args:
        skin: The skin.

    Attributes:
        raw: (taxels, 2) newest values along t1 and t2; NaN before the first ones.
        baseline: (taxels, 2) values of the untouched skin; 0 before a tare.
        received: Whether any value was received.
        wrong: Taxels with a wrong number of channels, at most 1000 of them: name, number and remedy.
        wrong_values: Number of values with a wrong number of channels.
    """

    def __init__(self, skin: Skin) -> None:
        self._skin = skin
        self._three = skin.three_axis
        self.baseline = np.zeros((len(skin), 2))
        self._wrong: dict[int, str] = {}
        self.wrong_values = 0
        self._tare: Tare | None = None
        self.reset()

    def reset(self) -> None:
        """Discard the values; the baseline stays."""
        self.raw = np.full(self.baseline.shape, np.nan)
        self.received = False

    @property
    def wrong(self) -> tuple[str, ...]:
        """Taxels with a wrong number of channels, in their order."""
        return tuple(self._wrong[taxel] for taxel in sorted(self._wrong))

    @property
    def change(self) -> FloatArray:
        """(taxels, 2) values above those of the untouched skin; 0 where none was received."""
        return np.where(np.isnan(self.raw), 0.0, self.raw - self.baseline)

    def complete(self, taxels: IntArray, channels: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return taxels (m,) and shear (m, 2) of complete values; others are counted and named.

        Args:
            taxels: (k,) taxels of a reading.
            channels: (k, 3) value and shear of each, NaN where missing.
        """
        three = self._three[taxels]
        there = ~np.isnan(channels)
        counts = there.sum(axis=1)
        whole = three & (counts == 3)
        wrong = ~(whole | (counts == 0) | (~three & ~there[:, 1:].any(axis=1)))
        if wrong.any():
            self._note(taxels[wrong], there[wrong], three[wrong])
        return taxels[whole], channels[whole, 1:]

    def _note(self, taxels: IntArray, there: BoolArray, three: BoolArray) -> None:
        self.wrong_values += len(taxels)
        for taxel, has, expected in zip(taxels.tolist(), there, three, strict=True):
            if taxel in self._wrong or len(self._wrong) >= _MOST_NAMED:
                continue
            name = self._skin.taxel_text(taxel)
            missing = ", ".join(one for one, found in zip(("p", "t1", "t2"), has, strict=True) if not found)
            self._wrong[taxel] = (
                f"{name}: {missing} missing, send all three" if expected else f"{name}: shear of a taxel with one axis"
            )

    def set(self, taxels: IntArray, shear: FloatArray) -> None:
        """Use the shear (m, 2) of taxels (m,)."""
        self.raw[taxels] = shear
        self.received |= len(taxels) > 0

    def begin_tare(self, frames: int) -> None:
        """Use the mean of the next readings as the baseline."""
        self._tare = Tare(self.raw.size, frames)

    def take_tare(self, heard: IntArray) -> None:
        """Add the newest values to a running tare.

        Args:
            heard: (m,) taxels whose shear the newest reading contains.
        """
        if self._tare is not None:
            both = np.concatenate([2 * heard, 2 * heard + 1])
            self._tare.add(self.raw.ravel(), both)

    def end_tare(self, touched: BoolArray) -> None:
        """Use the mean of the readings as the baseline, without those of touched taxels (blocks, taxels)."""
        if self._tare is not None:
            mean = self._tare.result(np.repeat(touched, 2, axis=1)).mean.reshape(-1, 2)
            self.baseline = np.where(np.isnan(mean), self.baseline, mean)
            self._tare = None
