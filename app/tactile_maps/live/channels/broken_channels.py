"""Channels of a real skin that are broken."""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.live.channels.channel_health import SilentChannel


class BrokenChannels:
    """State of the channel of each taxel: working or broken. Mutable.

    Args:
        taxels: Number of taxels.

    Attributes:
        broken: (taxels,) whether each is broken: dead or stuck.
        stuck: (taxels,) whether each is stuck.
    """

    def __init__(self, taxels: int) -> None:
        self._count = taxels
        self.reset()

    def reset(self) -> None:
        """Count all channels as working, and as never changed."""
        self.broken: BoolArray = np.zeros(self._count, dtype=bool)
        self.stuck: BoolArray = np.zeros(self._count, dtype=bool)
        self._changed: BoolArray = np.zeros(self._count, dtype=bool)

    def add(self, taxels: IntArray, values: FloatArray, before: FloatArray) -> None:
        """Count taxels (k,) whose ``values`` (k,) differ from those ``before`` (k,), NaN for none, as working."""
        changed = taxels[~np.isnan(before) & (before != values)]
        self._changed[changed] = True
        self.broken[changed] = False
        self.stuck[changed] = False

    def notice_silence(self, silent: tuple[SilentChannel, ...], spread: FloatArray | None) -> None:
        """Count silent channels as broken where a working one would have changed.

        Without noise, a working taxel next to a contact may keep its value. So a silent channel is broken if it has
        never changed, or if it varied in the tare.

        Args:
            silent: Channels that do not change.
            spread: (taxels,) standard deviations in the tare; None before one.
        """
        for one in silent:
            varied = spread is not None and spread[one.taxel] > 0
            self.broken[one.taxel] |= varied or not self._changed[one.taxel]
            self.stuck[one.taxel] = self.broken[one.taxel] and one.stuck
