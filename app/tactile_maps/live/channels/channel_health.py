"""Detection of channels that do not follow the skin: their values stay constant while those of their neighbours change.

Swapped channels do change; ``channel_swaps`` finds those.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin

QUIET_SECONDS = 5.0
"""A channel becomes suspect after this time without a change [s]."""
_LONGEST_GAP = 0.2
"""Longest gap between two readings that counts, as a share of the time above: no channel can change during a gap or a
jump of the clock.
"""
_LIVELY = 5
"""Number of changes in that time that show that a neighbour is touched."""


@dataclass(frozen=True)
class SilentChannel:
    """A channel that does not change.

    Attributes:
        taxel: Number of the taxel.
        value: Its constant value, in the unit of the readings.
        stuck: Whether the value is above all values of its neighbours; otherwise the channel is dead.
    """

    taxel: int
    value: float
    stuck: bool


class ChannelHealth:
    """Monitor of the values of all taxels. Mutable.

    Args:
        skin: Skin whose neighbouring taxels are compared.
        seconds: Time without a change after which a channel is suspect.

    Attributes:
        silent: Channels that do not change.
    """

    def __init__(self, skin: Skin, *, seconds: float = QUIET_SECONDS) -> None:
        self._seconds = seconds
        pairs = skin.neighbours
        self._from: IntArray = np.concatenate([pairs[:, 0], pairs[:, 1]])
        self._to: IntArray = np.concatenate([pairs[:, 1], pairs[:, 0]])
        self._degree = np.bincount(self._from, minlength=len(skin))
        self.reset()

    def reset(self) -> None:
        """Discard all observations."""
        count = len(self._degree)
        self._values: FloatArray | None = None
        self._since = np.full(count, np.nan)  # when each last changed; NaN before its first value
        self._changes = np.zeros(count, np.int64)
        self._before = np.zeros(count, np.int64)
        self._highest = np.full(count, -np.inf)
        self._window: float | None = None
        self._newest = np.inf
        self.silent: tuple[SilentChannel, ...] = ()

    def add(self, taxels: IntArray, values: FloatArray, time: float) -> None:
        """Add values (k,) of the taxels (k,) received at ``time`` [s]. Cost: 20 µs for 1000 taxels."""
        if self._values is None:
            self._values = np.full(len(self._degree), np.nan)
            self._window = time
        assert self._window is not None
        unobserved = max(time - self._newest - _LONGEST_GAP * self._seconds, 0.0)
        self._since += unobserved
        self._window += unobserved
        self._newest = time
        new = self._values[taxels] != values  # NaN differs from any
        changed = taxels[new]
        self._values[taxels] = values
        self._since[changed] = time
        self._changes[changed] += 1
        self._highest[taxels] = np.maximum(self._highest[taxels], values)
        if time - self._window >= self._seconds / 2:
            self._judge(time)
            self._before = self._changes
            self._changes = np.zeros_like(self._changes)
            self._window = time

    def _judge(self, time: float) -> None:
        """Find taxels that have not changed for long enough while at least half of their neighbours changed often."""
        assert self._values is not None
        lively = (self._changes + self._before) >= _LIVELY
        busy = np.bincount(self._from, weights=lively[self._to], minlength=len(lively))
        quiet = time - self._since >= self._seconds  # NaN compares false
        suspects = np.flatnonzero(quiet & (self._degree > 0) & (2 * busy >= self._degree))
        around = np.full(len(lively), -np.inf)
        np.maximum.at(around, self._from, self._highest[self._to])
        self.silent = tuple(
            SilentChannel(int(taxel), float(self._values[taxel]), bool(self._values[taxel] > around[taxel]))
            for taxel in suspects
        )
