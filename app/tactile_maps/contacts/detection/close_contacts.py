"""Separation of contacts whose touched taxels are connected, by the dip of the readings between their peaks.

Two fingertips side by side touch neighbouring taxels and are one connected group. Their readings have two peaks. A
group is divided where the dip between two peaks is at least as deep as Rayleigh's criterion for two images of a point
(0.735 of the lower peak for a circular aperture; M. Born, E. Wolf, Principles of Optics, 1999, section 8.6.2), and
deeper than the noise of the taxels.

The gains of the taxels of an uncalibrated skin differ by tens of per cent, which also makes peaks and dips. Peaks are
therefore searched in the mean of each taxel's reading and the mean reading of its neighbours. This costs resolution:
two equal round contacts with a radius of 1.5, 2 and 2.5 pitches are separated from a distance of 2.5, 3.5 and 4 pitches
on.

Parts of a contact whose taxels between them fall below the threshold remain one contact by the same criterion: a body
that presses with about the threshold would be one contact and two in turn. Readings below the threshold of the sensor
are unknown up to it. Contacts that were not one before are not joined.

The peaks are those of the upper level sets of these means, with the prominence that they have when they meet a higher
one (H. Edelsbrunner, J. Harer, Computational Topology, 2010, section VII.1); each taxel belongs to the peak that
is reached from it by the steepest ascent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain

import numpy as np
from scipy.sparse import csr_matrix, identity

from tactile_maps.contacts.detection.regions import TaxelGroup
from tactile_maps.core.arrays import FloatArray

RAYLEIGH = 0.735
"""Largest reading at the dip between two contacts, as a share of the lower peak."""
_FEWEST = 3
"""Number of touched taxels with room for two peaks and a dip."""


class CloseContactSeparator:
    """Divider of groups of touched taxels that contain several contacts.

    Args:
        near: Neighbours of each taxel.

    Cost: 10 µs for 1000 taxels, and 10 µs for each touched taxel.
    """

    def __init__(self, near: Sequence[frozenset[int]]) -> None:
        self._near = near
        count = [len(around) for around in near]
        rows = np.repeat(np.arange(len(near)), count)
        columns = np.fromiter(chain.from_iterable(near), dtype=np.int64, count=len(rows))
        means = csr_matrix((np.repeat(1 / np.maximum(count, 1), count), (rows, columns)), shape=(len(near), len(near)))
        self._smoothing = csr_matrix(0.5 * (identity(len(near), format="csr") + means))

    def smoothed_noise(self, noise: FloatArray) -> FloatArray:
        """Return the smoothed reading (taxels,) that noise rarely exceeds [Pa], from that of each reading (taxels,)."""
        return np.sqrt(self._smoothing.power(2) @ np.square(noise))

    def separated(self, groups: Sequence[TaxelGroup], readings: FloatArray, noise: FloatArray) -> list[TaxelGroup]:
        """Return the contacts in connected groups of touched taxels, in the order of the groups.

        Args:
            groups: The groups.
            readings: (taxels,) readings [Pa].
            noise: (taxels,) result of ``smoothed_noise``.
        """
        if all(len(group.core) < _FEWEST for group in groups):
            return list(groups)
        smoothed = self._smoothing @ readings
        return list(chain.from_iterable(self._divided(group, smoothed, noise) for group in groups))

    def united(
        self,
        groups: Sequence[TaxelGroup],
        names: Sequence[tuple[int, int | None]],
        readings: FloatArray,
        noise: FloatArray,
    ) -> list[TaxelGroup]:
        """Return the groups, where parts of one contact without a deep dip between them are one group.

        Parts have a common ring taxel between them.

        Args:
            groups: The groups.
            names: Numbers of connected group and earlier contact (None for a new one) of each group.
            readings: (taxels,) highest pressure of each taxel that its reading allows [Pa].
            noise: (taxels,) reading that noise rarely exceeds [Pa].
        """
        part = {number: number for number in range(len(groups))}
        for second, (connected, contact) in enumerate(names):
            for first, (other, earlier) in enumerate(names[:second]):
                if contact is not None and contact == earlier and connected != other:
                    between = groups[first].ring & groups[second].ring
                    if between and not self._apart(groups[first].core, groups[second].core, between, readings, noise):
                        part[_root(second, part)] = _root(first, part)
        found: dict[int, TaxelGroup] = {}
        for number, group in enumerate(groups):
            known = found.get(_root(number, part), TaxelGroup(frozenset(), frozenset()))
            core = known.core | group.core
            found[_root(number, part)] = TaxelGroup(core, (known.ring | group.ring) - core)
        return list(found.values())

    def _apart(
        self,
        first: frozenset[int],
        second: frozenset[int],
        between: frozenset[int],
        readings: FloatArray,
        noise: FloatArray,
    ) -> bool:
        """Whether the dip in the taxels ``between`` two groups of touched taxels is deep."""
        lower = min((max(core, key=readings.__getitem__) for core in (first, second)), key=readings.__getitem__)
        dip = max(between, key=readings.__getitem__)
        return _is_deep(readings[lower], readings[dip], math.hypot(noise[lower], noise[dip]))

    def _divided(self, group: TaxelGroup, smoothed: FloatArray, noise: FloatArray) -> list[TaxelGroup]:
        """Return the contacts in a group, that of the smallest taxel first; the group itself if it is one."""
        if len(group.core) < _FEWEST:
            return [group]
        taxels = sorted(group.core)
        level = dict(zip(taxels, smoothed[taxels].tolist(), strict=True))
        limit = dict(zip(taxels, noise[taxels].tolist(), strict=True))
        basins = self._basins(level, limit)
        cores: dict[int, set[int]] = {}
        for taxel in taxels:
            cores.setdefault(basins[taxel], set()).add(taxel)
        if len(cores) == 1:
            return [group]
        return [TaxelGroup(frozenset(core), self._around(core) - group.core) for core in cores.values()]

    def _around(self, taxels: set[int]) -> frozenset[int]:
        return frozenset(chain.from_iterable(self._near[taxel] for taxel in taxels))

    def _basins(self, level: dict[int, float], limit: dict[int, float]) -> dict[int, int]:
        """Return the peak to which each taxel belongs.

        Taxels are added from the highest to the lowest. A taxel that touches several connected parts is the dip between
        their peaks; the part with the lower peak joins the other unless the dip is deep enough.
        """
        part: dict[int, int] = {}  # union-find: by taxel, another one of the same connected part
        top: dict[int, int] = {}  # by root of a part, its highest taxel
        basin: dict[int, int] = {}  # by taxel, its next one uphill; by a peak without a dip, one of the higher part
        for taxel in sorted(level, key=lambda one: (-level[one], one)):
            around = [one for one in self._near[taxel] if one in part]
            part[taxel] = taxel
            if not around:
                basin[taxel] = top[taxel] = taxel
                continue
            basin[taxel] = max(around, key=lambda one: (level[one], -one))
            roots = {_root(one, part) for one in around}
            higher = max(roots, key=lambda one: (level[top[one]], -one))
            for lower in roots - {higher}:
                peak = top[lower]
                if not _is_deep(level[peak], level[taxel], math.hypot(limit[peak], limit[taxel])):
                    basin[peak] = next(one for one in around if _root(one, part) == higher)
            for lower in roots:
                part[lower] = higher
            part[taxel] = higher
        return {taxel: _root(taxel, basin) for taxel in level}


def _is_deep(peak: float, dip: float, noise: float) -> bool:
    """Whether contacts are separate, from the readings of the lower peak and the dip and the noise of both [Pa]."""
    return dip <= RAYLEIGH * peak and peak - dip >= noise


def _root(taxel: int, parents: dict[int, int]) -> int:
    """Return the end of the chain of parents, which is shortened for the next search."""
    while parents[taxel] != taxel:
        parents[taxel] = parents[parents[taxel]]
        taxel = parents[taxel]
    return taxel
