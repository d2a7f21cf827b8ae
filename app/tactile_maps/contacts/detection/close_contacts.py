"""Separation of contacts whose touched taxels are connected, by the dip of the readings between their peaks.

Two fingertips side by side touch neighbouring taxels and are one connected group. Their readings have two peaks. A
group is divided where the dip between two peaks is at least as deep as Rayleigh's criterion for two images of a point
(0.735 of the lower peak for a circular aperture; M. Born, E. Wolf, Principles of Optics, 1999, section 8.6.2), and
deeper than the noise of the taxels.

The gains of the taxels of an uncalibrated skin differ by tens of per cent, which also makes peaks and dips. Peaks are
therefore searched in the mean of each taxel's reading and the mean reading of its neighbours. This costs resolution:
two equal round contacts with a radius of 1.5, 2 and 2.5 pitches are separated from a distance of 2.5, 3.5 and 4 pitches
on.

The peaks are those of the upper level sets of these means, with the prominence that they have when they meet a higher
one (H. Edelsbrunner, J. Harer, Computational Topology, 2010, section VII.1); each taxel belongs to the peak that
is reached from it by the steepest ascent.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np

from tactile_maps.contacts.detection.regions import TaxelGroup
from tactile_maps.core.arrays import FloatArray

RAYLEIGH = 0.735
"""Largest dip between two contacts, as a share of the lower peak."""


class CloseContactSeparator:
    """Divider of groups of touched taxels that contain several contacts.

    Args:
        near: Neighbours of each taxel.

    Cost: 3 µs for each touched taxel.
    """

    def __init__(self, near: Sequence[frozenset[int]]) -> None:
        self._near = near

    def separated(self, group: TaxelGroup, readings: FloatArray, noise: FloatArray) -> list[TaxelGroup]:
        """Return the contacts in a group, that of the smallest taxel first; the group itself if it is one.

        Args:
            group: Connected touched taxels.
            readings: (taxels,) readings [Pa].
            noise: (taxels,) reading that noise rarely exceeds [Pa].
        """
        if len(group.core) < 3:
            return [group]
        level, limit = self._smoothed(group, readings, noise)
        basins = self._basins(level, limit)
        if len(set(basins.values())) == 1:
            return [group]
        cores: dict[int, set[int]] = {}
        for taxel in sorted(group.core):
            cores.setdefault(basins[taxel], set()).add(taxel)
        return [TaxelGroup(frozenset(core), self._around(core) - group.core) for core in cores.values()]

    def _around(self, taxels: set[int]) -> frozenset[int]:
        return frozenset(chain.from_iterable(self._near[taxel] for taxel in taxels))

    def _smoothed(
        self, group: TaxelGroup, readings: FloatArray, noise: FloatArray
    ) -> tuple[dict[int, float], dict[int, float]]:
        """Return the smoothed readings of the touched taxels, and what noise exceeds rarely in these [Pa]."""
        level = {}
        limit = {}
        for taxel in group.core:
            around = np.fromiter(self._near[taxel], dtype=np.int64)
            level[taxel] = 0.5 * float(readings[taxel] + readings.take(around).mean())
            limit[taxel] = 0.5 * float(np.hypot(noise[taxel], np.linalg.norm(noise.take(around)) / len(around)))
        return level, limit

    def _basins(self, level: dict[int, float], limit: dict[int, float]) -> dict[int, int]:
        """Return the peak to which each taxel belongs.

        Taxels are added from the highest to the lowest. A taxel that touches several connected parts is the dip between
        their peaks; the part with the lower peak joins the other unless the dip is deep enough.
        """
        part: dict[int, int] = {}  # union-find: by taxel, another one of the same connected part
        top: dict[int, int] = {}  # by root of a part, its highest taxel
        basin: dict[int, int] = {}  # by taxel, its next one uphill; by a peak without a dip, one of the higher part

        def root(taxel: int, parents: dict[int, int]) -> int:
            while parents[taxel] != taxel:
                taxel = parents[taxel]
            return taxel

        for taxel in sorted(level, key=lambda one: (-level[one], one)):
            around = sorted((one for one in self._near[taxel] if one in part), key=lambda one: (-level[one], one))
            part[taxel] = taxel
            basin[taxel] = around[0] if around else taxel
            parts = sorted({root(one, part) for one in around}, key=lambda one: (-level[top[one]], one))
            for lower in parts[1:]:
                peak = top[lower]
                dip = level[peak] - level[taxel]
                if level[taxel] > RAYLEIGH * level[peak] or dip < np.hypot(limit[peak], limit[taxel]):
                    basin[peak] = next(one for one in around if root(one, part) == parts[0])
                part[lower] = parts[0]
            top.setdefault(taxel, taxel)
            if parts:
                part[taxel] = parts[0]
        return {taxel: root(taxel, basin) for taxel in level}
