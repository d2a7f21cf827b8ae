"""Detection of swapped channels: two taxels of one module whose values each fit the neighbours of the other.

A finger on a taxel also acts on the surrounding taxels, somewhat later or weaker. For a pair (i, j) let x be the change
of their values over a moment, in units of its usual size, and m the mean of x over the neighbours of each, without the
other one of the pair. Then (x_i - x_j) (m_i - m_j) is positive on average for correct channels, about zero without
touch, and negative for swapped channels. Changes are used instead of values, so that offsets, drift and a resting
finger do not matter.

A pair is reported if its sum is further below zero than that of any pair with randomly drawn signs of its moments, in
199 draws (permutation test of the largest statistic, valid for all pairs together), if enough moments support it, and
if each of the two is the other's best match. The draws have a fixed seed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin

_LAG = 0.1
"""Time between the two values of a change [s]: longer than a reading takes, shorter than a touch."""
_BLOCK = 0.5
"""Length of one moment of the test [s]: about the time a finger needs to cross a module."""
_DRAWS = 199
_LEAST_MOMENTS = 10.0
"""Minimum effective number of moments that support a pair."""
_QUIET = 1.0
"""Changes of a pair in a moment below this many times their usual size have less weight."""
_LEAST_STRENGTH = 0.2
"""Minimum share by which the changes of a pair contradict those of its neighbours."""
_LARGEST_MODULE = 64
"""Number of taxels: in larger modules, and without modules, only first and second neighbours are compared."""


@dataclass(frozen=True)
class SwappedChannels:
    """Two taxels that receive each other's values.

    Attributes:
        first: Lower taxel number.
        second: Higher taxel number.
        module: Module of both; None where the skin states none.
        strength: Share, 0 to 1, by which their changes contradict those of their neighbours.
    """

    first: int
    second: int
    module: int | None
    strength: float


class SwapDetector:
    """Test for swapped channels on the values of all taxels. Mutable.

    Args:
        skin: Skin whose modules and neighbouring taxels are compared.

    Attributes:
        swapped: Pairs found so far, sorted by taxel number.
    """

    def __init__(self, skin: Skin) -> None:
        count = len(skin)
        pairs = skin.neighbours
        ends = np.concatenate([pairs, pairs[:, ::-1]])
        ones = np.ones(2 * len(pairs))
        self._around = sparse.csr_array((ones, (ends[:, 0], ends[:, 1])), shape=(count, count))
        self._modules = skin.identity.modules
        self._pairs = _candidates(self._around, self._modules)
        joined = set(map(tuple, np.sort(pairs, axis=1).tolist()))
        adjacent = np.array([tuple(pair) in joined for pair in self._pairs.tolist()], dtype=bool)
        degree = np.asarray(self._around.sum(axis=1)).ravel()
        others = degree[self._pairs] - adjacent[:, None]
        kept = others.min(axis=1) > 0 if len(others) else np.zeros(0, dtype=bool)
        self._pairs = self._pairs[kept]
        self._adjacent = adjacent[kept]
        self._others = others[kept]
        self._count = count
        self.reset()

    def reset(self) -> None:
        """Discard all observations."""
        pairs = len(self._pairs)
        self._random = np.random.default_rng(0)
        self._last: tuple[float, FloatArray] | None = None
        self._power = np.zeros(self._count)
        self._samples = 0
        self._block = np.zeros(pairs)
        self._loud = np.zeros(pairs)
        self._since = 0.0
        self._contrast = np.zeros(pairs)
        self._scale = np.zeros(pairs)
        self._sum = np.zeros(pairs)
        self._squares = np.zeros(pairs)
        self._fourths = np.zeros(pairs)
        self._drawn: FloatArray | None = None  # large, so allocated at the first block
        self.swapped: tuple[SwappedChannels, ...] = ()

    def add(self, values: FloatArray, time: float) -> None:
        """Add the newest values (taxels,) at ``time`` [s], NaN where none has arrived.

        Cost: for 1000 taxels 0.3 ms, at most ten times a second, and 4 ms twice a second.
        """
        if self._last is None:
            self._last = (time, values.copy())
            self._since = time
            return
        if time - self._last[0] < _LAG:
            return
        change = np.nan_to_num(values - self._last[1])
        if time - self._last[0] <= 2 * _BLOCK:  # longer gaps are pauses of the stream
            self._take(change)
        self._last = time, values.copy()
        if time - self._since >= _BLOCK:
            self._end_block(time)

    def _take(self, change: FloatArray) -> None:
        self._power += change * change
        self._samples += 1
        usual = np.sqrt(self._power / self._samples)
        x = np.divide(change, usual, out=np.zeros_like(change), where=usual > 0)
        own = x[self._pairs]
        around = (self._around @ x)[self._pairs] - self._adjacent[:, None] * own[:, ::-1]
        mean = around / self._others
        self._block += (own[:, 0] - own[:, 1]) * (mean[:, 0] - mean[:, 1])
        self._loud += 0.5 * ((own * own).sum(axis=1) + (mean * mean).sum(axis=1))

    def _end_block(self, time: float) -> None:
        self._contrast += self._block
        self._scale += self._loud
        block = self._block / (self._loud + _QUIET)  # equal weight for hard and light presses
        self._block = np.zeros_like(block)
        self._loud = np.zeros_like(block)
        self._since = time
        squares = block * block
        self._sum += block
        self._squares += squares
        self._fourths += squares * squares
        signs = self._random.choice(np.array([-1.0, 1.0], dtype=np.float32), _DRAWS)
        if self._drawn is None:
            self._drawn = np.zeros((_DRAWS, len(block)), dtype=np.float32)
        self._drawn += signs[:, None] * block.astype(np.float32)
        self._judge()

    def _judge(self) -> None:
        assert self._drawn is not None
        spread = np.sqrt(self._squares)
        moments = np.divide(self._squares**2, self._fourths, out=np.zeros_like(spread), where=self._fourths > 0)
        enough = moments >= _LEAST_MOMENTS
        if not enough.any():
            return
        scores = self._sum[enough] / spread[enough]
        limit = float((np.abs(self._drawn[:, enough]) / spread[enough]).max())
        strength = -self._contrast[enough] / self._scale[enough]
        pairs = self._pairs[enough]
        below = (scores < -limit) & (strength >= _LEAST_STRENGTH)
        self.swapped = self._matched(pairs[below], scores[below], strength[below])

    def _matched(self, pairs: IntArray, scores: FloatArray, strength: FloatArray) -> tuple[SwappedChannels, ...]:
        """Select the strongest pair, then the strongest pair without a taxel of it, and so on."""
        found = []
        used = set[int]()
        for row in np.argsort(-strength * -scores, kind="stable").tolist():
            one, other = pairs[row].tolist()
            if not used & {one, other}:
                module = None if self._modules is None else int(self._modules[one])
                found.append(SwappedChannels(one, other, module, float(strength[row])))
            used |= {one, other}
        return tuple(sorted(found, key=lambda swap: swap.first))


def _candidates(around: sparse.csr_array, modules: IntArray | None) -> IntArray:
    """Return (p, 2) pairs of taxels in one module, or near each other where no module is stated; the lower number
    first.
    """
    if modules is not None and np.unique(modules, return_counts=True)[1].max(initial=0) <= _LARGEST_MODULE:
        order = np.argsort(modules, kind="stable")
        groups = np.split(order, np.flatnonzero(np.diff(modules[order])) + 1)
        rows = [np.sort(group)[np.transpose(np.triu_indices(len(group), 1))] for group in groups]
        return np.concatenate(rows) if rows else np.zeros((0, 2), dtype=np.int64)
    rows, columns = (around + around @ around).nonzero()
    return np.column_stack([rows, columns])[rows < columns].astype(np.int64)
