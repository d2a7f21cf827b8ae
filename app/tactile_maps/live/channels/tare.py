"""Tare: baseline and noise of the untouched skin, from the next readings, and touches meanwhile.

A touch during a tare would become part of the baseline and be hidden by it. Two kinds are distinguished.

A touch that **begins or ends** during the tare is found by dividing its readings into an interval and the others. The
interval contains a touch if it would be a contact after a tare with the other readings alone, by the same limits of the
noise. Readings of the interval are left out for the taxels of this contact and the ring around them. What all taxels
have in common (drift) is no touch.

A touch that is **held** all the time cannot be separated from the offsets of the taxels. Neighbouring taxels whose mean
differs from that of the previous tare, or from the others before the first tare, by far more than those of other taxels
do, are reported.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.detection import NOISE_LIMIT, TOUCH_THRESHOLD
from tactile_maps.contacts.detection.regions import TaxelGraph, TaxelGroup
from tactile_maps.contacts.detection.taxel_noise import TailShape, estimate_noise, student_factor, tail_of_readings
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import LiveError, check_range
from tactile_maps.skin.model.skin import Skin

MOST_KEPT = 200
"""Maximum number of readings of a tare that are kept to estimate the shape of the noise."""
LEAST_TARE = 5
"""Least number of readings of a tare that a user may choose: the noise of fewer is unknown."""
_MOST_TARE = 100_000
_MOST_BLOCKS = 12
"""Maximum number of blocks of consecutive readings that are added up separately."""
_ROUNDS = 3
"""Number of touches of one taxel that are searched."""
_TOUCHED = 3.0
"""Limit of each taxel of a touch, in standard deviations of its noise."""
_FEWEST = 2
"""Number of neighbouring taxels from which on they are a touch that begins or ends."""
_HELD_FEWEST = 3
"""The same for a touch that is held."""
_FAR = 20.0
"""Limit of each taxel of a held touch, in standard deviations of the other taxels. Offsets are not as independent as
noise is: of 185 tares of a real CySkin, 20 are reported, all with the same patch of nine taxels that read several
thousand counts throughout; at 10 standard deviations, 8 groups of three taxels would be reported too."""
_HELD_LEAST = 3 * TOUCH_THRESHOLD
"""Smallest limit of a taxel of a held touch [Pa]."""
_OF_NORMAL = 1.4826
"""Standard deviation of normal values, as a multiple of their median absolute deviation."""


class TareResult(NamedTuple):
    """Statistics of readings of the untouched skin.

    Attributes:
        mean: (n,) mean of each taxel's readings; the latest value where none arrived.
        spread: (n,) root mean square deviation from the mean.
        counts: (n,) number of readings with a value of the taxel.
    """

    mean: FloatArray
    spread: FloatArray
    counts: IntArray


class TareBlocks(NamedTuple):
    """Statistics of the b blocks of a tare, by taxel.

    Attributes:
        counts: (b, n) number of values.
        sums: (b, n) sum of the values above the first one.
        squares: (b, n) sum of their squares.
    """

    counts: IntArray
    sums: FloatArray
    squares: FloatArray

    def without(self, left_out: BoolArray) -> TareBlocks:
        """Return the blocks without those (b, n) that are left out."""
        kept = ~left_out
        return TareBlocks(self.counts * kept, self.sums * kept, self.squares * kept)


def check_tare(frames: int, *, least: int = LEAST_TARE) -> None:
    """Raise LiveError for an invalid number of readings of a tare."""
    check_range("the number of readings", frames, least, _MOST_TARE, error=LiveError)


class Tare:
    """Running statistics of readings of an untouched skin. Mutable.

    Args:
        taxels: Number of taxels of the skin.
        frames: Number of readings; a taxel needs at least one value to get a baseline.
    """

    def __init__(self, taxels: int, frames: int) -> None:
        check_tare(frames, least=1)
        self._added = 0
        self._frames = frames
        self._block_length = -(-frames // _MOST_BLOCKS)
        shape = (-(-frames // self._block_length), taxels)
        self._counts: IntArray = np.zeros(shape, dtype=np.int64)
        self._first = np.zeros(taxels)
        self._begun = np.zeros(taxels, dtype=bool)
        self._sums = np.zeros(shape)
        self._squares = np.zeros(shape)
        self._kept: list[FloatArray] = []

    def add(self, values: FloatArray, heard: IntArray) -> bool:
        """Add a reading; return whether it was the last one needed.

        Args:
            values: (n,) values of all taxels; taxels without a new value keep their latest one.
            heard: (k,) taxels with a value in the reading.
        """
        self._first = np.where(self._begun, self._first, values)
        self._begun[heard] = True
        away = (values - self._first)[heard]  # deviations from the first value are small: no cancellation
        block = self._added // self._block_length
        self._counts[block, heard] += 1
        self._sums[block, heard] += away
        self._squares[block, heard] += away * away
        if len(self._kept) < MOST_KEPT:
            row = np.full(len(values), np.nan)
            row[heard] = values[heard]
            self._kept.append(row)
        self._added += 1
        return self._added == self._frames

    def readings(self, left_out: BoolArray) -> FloatArray:
        """Return the first readings (k, n), at most ``MOST_KEPT``; NaN where a taxel has no value.

        Args:
            left_out: (b, n) blocks whose values are NaN as well.
        """
        blocks = np.arange(len(self._kept)) // self._block_length
        return np.where(left_out[blocks], np.nan, np.array(self._kept))

    @property
    def blocks(self) -> TareBlocks:
        """Statistics of the blocks."""
        return TareBlocks(self._counts, self._sums, self._squares)

    def result(self, left_out: BoolArray) -> TareResult:
        """Return means, standard deviations and counts of the added readings.

        Args:
            left_out: (b, n) blocks to leave out for each taxel.
        """
        blocks = self.blocks.without(left_out)
        counts = blocks.counts.sum(axis=0)
        divisor = np.maximum(counts, 1)
        mean = blocks.sums.sum(axis=0) / divisor
        variance = np.maximum(blocks.squares.sum(axis=0) / divisor - mean * mean, 0.0)
        return TareResult(self._first + mean, np.sqrt(variance), counts)


class TouchedTares:
    """Search for touches during a tare.

    Args:
        skin: The skin.

    Cost: 0.2 s for 640 taxels, once in a tare.
    """

    def __init__(self, skin: Skin) -> None:
        self._areas = skin.areas
        self._graph = TaxelGraph(skin)

    def touched(self, tare: Tare, gains: FloatArray) -> BoolArray:
        """Return (b, n) whether each taxel was touched in each block.

        Args:
            tare: A completed tare.
            gains: (n,) displayed pascals per unit of the readings; negative where values fall under pressure.
        """
        found = np.zeros(tare.blocks.counts.shape, dtype=bool)
        for _ in range(_ROUNDS):
            more = self._intervals(tare, found, gains)
            if not more.any():
                break
            found |= more
        unknown = tare.blocks.without(found).counts.sum(axis=0) == 0
        found[:, unknown] = False
        return found

    def _intervals(self, tare: Tare, found: BoolArray, gains: FloatArray) -> BoolArray:
        """Return (b, n) the interval of each taxel whose touch explains most of the readings not ``found`` (b, n)."""
        blocks = tare.blocks.without(found)
        candidates: list[tuple[float, int, int, TaxelGroup]] = []
        counts, above_first, squared = (part.sum(axis=0) for part in blocks)
        means = above_first / np.maximum(counts, 1)
        spreads = np.abs(gains) * np.sqrt(np.maximum(squared / np.maximum(counts, 1) - np.square(means), 0.0))
        least = max(TOUCH_THRESHOLD, _TOUCHED * float(np.median(spreads)))
        sums = [np.vstack([np.zeros_like(part[:1]), np.cumsum(part, axis=0)]) for part in blocks]
        for start, end in combinations(range(len(blocks.counts) + 1), 2):
            inside, above, _ = (part[end] - part[start] for part in sums)
            outside, rest, squares = (part[-1] - part[end] + part[start] for part in sums)
            usable = (inside >= 1) & (outside >= 2)
            if not usable.any():
                continue
            divisor = np.maximum(outside, 1)
            rise = gains * (above / np.maximum(inside, 1) - rest / divisor)
            rise = np.where(usable, rise - np.median(rise[usable]), 0.0)
            spread = np.sqrt(np.maximum(squares / divisor - np.square(rest / divisor), 0.0)) * np.abs(gains)
            explained = np.square(rise) * inside * outside / np.maximum(inside + outside, 1)
            rise = np.where(rise >= least, rise, 0.0)  # readings may be equal by chance, such as clipped ones
            if not self._touches(rise, spread, outside, TailShape()):
                continue  # a longer tail only raises the limits
            others = found.copy()
            others[start:end] = True
            tail = tail_of_readings(tare.readings(others) * gains)
            groups = self._touches(rise, spread, outside, tail)
            candidates.extend((float(explained[sorted(group.core)].sum()), start, end, group) for group in groups)
        touched = np.zeros(blocks.counts.shape, dtype=bool)
        for _, start, end, group in sorted(candidates, key=lambda one: -one[0]):
            if not touched[:, sorted(group.core)].any():
                touched[start:end, sorted(group.core | group.ring)] = True
        return touched

    def _touches(self, rise: FloatArray, spread: FloatArray, counts: IntArray, tail: TailShape) -> list[TaxelGroup]:
        """Return the groups that ``rise`` (n,) [Pa] beyond noise of ``spread`` (n,) [Pa] from ``counts`` (n,)."""
        noise = estimate_noise(spread, counts, tail)
        high = rise >= TOUCH_THRESHOLD
        if noise is not None:
            high &= rise >= _TOUCHED * noise.scale * noise.sd  # never above the limit, and fast
            rows = high.nonzero()[0]
            factor = noise.scale * student_factor(_TOUCHED, noise.freedom[rows])
            high[rows] = rise[rows] >= factor * noise.sd[rows]
        groups = []
        for group in self._graph.groups(high.nonzero()[0].tolist()):
            taxels = np.array(sorted(group.core))
            areas = self._areas[taxels]
            forces = areas * rise[taxels]
            if len(taxels) >= _FEWEST and (noise is None or noise.exceeded(NOISE_LIMIT, forces, taxels, areas)):
                groups.append(group)
        return groups

    def held(self, levels: FloatArray) -> IntArray:
        """Return the numbers of taxels that may have been touched all the time.

        Args:
            levels: (n,) pressure of each taxel in the tare above the expected one [Pa]; NaN where unknown.
        """
        known = np.isfinite(levels)
        if not known.any():
            return np.zeros(0, dtype=np.int64)
        above = np.where(known, levels - np.median(levels[known]), 0.0)
        limit = max(_HELD_LEAST, _FAR * _OF_NORMAL * float(np.median(np.abs(above[known]))))
        groups = self._graph.groups((above >= limit).nonzero()[0].tolist())
        found = [taxel for group in groups if len(group.core) >= _HELD_FEWEST for taxel in group.core]
        return np.array(sorted(found), dtype=np.int64)
