"""Channels that stand in each other's place: two taxels of one module whose values are each at home with the other's
neighbours.

What a finger does to a taxel it does, somewhat later or weaker, to those around it. Of a pair (i, j) let x be how
their values change in a moment, in units of how each usually does, and m the mean of that over the neighbours of each,
without the other of the pair. Then (x_i - x_j) (m_i - m_j) is positive on average where both are in their places,
about zero where nothing is felt, and negative where they are swapped. Changes are used, not values, so that neither
offset nor drift nor a finger that rests counts.

A pair is told when its sum is further below zero than that of any pair with the signs of its moments drawn at random,
in 199 draws (a permutation test of the largest statistic: it holds for all pairs together), when many moments speak for
it, and when each of the two is the other's best match. The draws have a fixed seed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.skin.model.skin import Skin

_LAG = 0.1
"""Seconds between two values whose difference is a change: longer than a reading takes, shorter than a touch."""
_BLOCK = 0.5
"""Seconds that are one moment of the test: about as long as a finger takes over a module."""
_DRAWS = 199
_LEAST_MOMENTS = 10.0
"""That speak for a pair, counted by their weight."""
_QUIET = 1.0
"""Of a pair's changes in a moment, in units of how they usually change: what is less counts for less."""
_LEAST_STRENGTH = 0.2
"""Of what a pair's changes could contradict its neighbours by."""
_LARGEST_MODULE = 64
"""Taxels: of larger ones, and where no module is stated, only neighbours and their neighbours are compared."""


@dataclass(frozen=True)
class SwappedChannels:
    """Two taxels that get each other's values.

    Attributes:
        first: Running number of the one, the lower.
        second: Of the other.
        module: That carries both; None where none is stated.
        strength: Share, 0 to 1, by which their changes contradict their neighbours'.
    """

    first: int
    second: int
    module: int | None
    strength: float


class SwapDetector:
    """Watches the values of all taxels. Mutable.

    Args:
        skin: Whose modules and neighbours are compared.
        seed: Of the draws.

    Attributes:
        swapped: Found so far, by the taxels' numbers.
    """

    def __init__(self, skin: Skin, *, seed: int = 0) -> None:
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
        self._seed = seed
        self.reset()

    def reset(self) -> None:
        """Forget all."""
        pairs = len(self._pairs)
        self._random = np.random.default_rng(self._seed)
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
        self._drawn: FloatArray | None = None  # large: not before it is needed
        self.swapped: tuple[SwappedChannels, ...] = ()

    def add(self, values: FloatArray, time: float) -> None:
        """The newest values (taxels,) at ``time`` [s], NaN where none came yet.

        Cost: for 1000 taxels 0.3 ms, ten times a second at most, and 4 ms twice a second.
        """
        if self._last is None:
            self._last = (time, values.copy())
            self._since = time
            return
        if time - self._last[0] < _LAG:
            return
        change = np.nan_to_num(values - self._last[1])
        if time - self._last[0] <= 2 * _BLOCK:  # else it was away
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
        block = self._block / (self._loud + _QUIET)  # a hard press speaks no louder than a light one
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
        told = moments >= _LEAST_MOMENTS
        if not told.any():
            return
        scores = self._sum[told] / spread[told]
        limit = float((np.abs(self._drawn[:, told]) / spread[told]).max())
        strength = -self._contrast[told] / self._scale[told]
        pairs = self._pairs[told]
        below = (scores < -limit) & (strength >= _LEAST_STRENGTH)
        self.swapped = self._matched(pairs[below], scores[below], strength[below])

    def _matched(self, pairs: IntArray, scores: FloatArray, strength: FloatArray) -> tuple[SwappedChannels, ...]:
        """The strongest pair, then the strongest of those that have no taxel of it, and so on."""
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
    """(p, 2) pairs of one module, or near each other where none is stated; the lower number first."""
    if modules is not None and np.unique(modules, return_counts=True)[1].max(initial=0) <= _LARGEST_MODULE:
        order = np.argsort(modules, kind="stable")
        groups = np.split(order, np.flatnonzero(np.diff(modules[order])) + 1)
        rows = [np.sort(group)[np.transpose(np.triu_indices(len(group), 1))] for group in groups]
        return np.concatenate(rows) if rows else np.zeros((0, 2), dtype=np.int64)
    rows, columns = (around + around @ around).nonzero()
    return np.column_stack([rows, columns])[rows < columns].astype(np.int64)
