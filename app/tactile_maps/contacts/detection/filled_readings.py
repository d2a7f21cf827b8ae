"""Readings of broken taxels, estimated from the working taxels next to them.

A known broken taxel reads nothing, or always the same value; a reading of NaN did not arrive. Such a reading is
replaced by the mean pressure of its working neighbours, which is exact where the pressure is even. Neighbours belong to
one patch, so nothing is estimated across patches.

The readings do not determine how much presses a hole that is as large as a contact: a small contact on the hole presses
it more than the mean, a contact next to it less. The stated standard uncertainty is therefore a share of the largest
pressure next to the hole (``_UNCERTAINTY``). A contact on broken taxels alone is not estimated.

Broken taxels with fewer than two working neighbours are blind: they keep what they read. ``BlindArea`` names them.

``TaxelFill`` estimates one set of broken taxels. ``MissingReadings`` follows the set: broken taxels that are known, and
those that did not report in the present frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly
from tactile_maps.skin.model.skin import Skin, number_ranges
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind

LEAST_NEIGHBOURS = 2
"""Number of working neighbours from which on a broken taxel is estimated."""
_UNCERTAINTY = 0.22
"""Standard uncertainty of an estimate as a share of the largest pressure of its neighbours: 68 % of contacts that reach
a broken taxel are within it (balls of 4 to 20 mm, 2 to 20 % broken taxels)."""
LIMIT = 4.5
"""Width of the interval that holds 95 % of these contacts, in standard uncertainties."""
_NOTICED = 0.1
"""Share of the threshold from which a reading of a neighbour counts."""
_DEVIATIONS = 6.0
"""Standard deviations of their noise by which the readings of the neighbours exceed zero, as for a new contact."""


@dataclass(frozen=True, eq=False)
class BlindArea(ArrayFields):
    """Connected broken taxels that have too few working neighbours to be estimated.

    Attributes:
        link: Link that they cover.
        taxels: (k,) their numbers, rising.
        area: Sum of their areas [m²].
    """

    link: str
    taxels: IntArray
    area: float

    @property
    def note(self) -> ContactNote:
        """The note that names the area."""
        word = "taxel" if len(self.taxels) == 1 else "taxels"
        return ContactNote(
            ContactNoteKind.BLIND_AREA, (f"{word} {number_ranges(self.taxels)}", self.link), area=self.area
        )


class FilledReadings(NamedTuple):
    """Readings of the skin with estimates in place of broken taxels.

    Attributes:
        pressures: (taxels,) readings [Pa]; the given array if nothing is estimated.
        sd: (taxels,) standard uncertainty of the estimates [Pa]; 0 for working taxels.
    """

    pressures: FloatArray
    sd: FloatArray


class TaxelFill:
    """Estimates the readings of broken taxels.

    Args:
        skin: The skin.
        broken: (taxels,) whether each is broken.

    Attributes:
        broken: Value of the argument.
        blind: Areas that cannot be estimated.

    Cost: linear in the number of broken taxels and their neighbours; about 10 µs for a hundred.
    """

    def __init__(self, skin: Skin, broken: BoolArray) -> None:
        self.broken = readonly(broken, np.bool_)
        self._skin = skin
        self._areas = skin.areas
        self._none = readonly(np.zeros(len(skin)))
        pairs = np.concatenate([skin.neighbours, skin.neighbours[:, ::-1]])
        pairs = pairs[self.broken[pairs[:, 0]]]
        at_border = pairs[~self.broken[pairs[:, 1]]]
        working = np.bincount(at_border[:, 0], minlength=len(skin))
        self._estimated = self.broken & (working >= LEAST_NEIGHBOURS)
        at_border = at_border[self._estimated[at_border[:, 0]]]
        self._holes, self._hole_of = np.unique(at_border[:, 0], return_inverse=True)
        self._neighbours: IntArray = at_border[:, 1]
        self._count = working[self._holes]
        self.blind = self._blind_areas(self.broken & ~self._estimated, pairs)

    def fill(
        self, pressures: FloatArray, *, threshold: float | FloatArray, noise: float | FloatArray = 0.0
    ) -> FilledReadings:
        """Return the readings with estimates.

        Args:
            pressures: (taxels,) what the taxels read [Pa]; not changed.
            threshold: Pressure from which a taxel counts as touched [Pa]; one for all, or (taxels,).
            noise: Standard deviation of a reading [Pa]; one for all, or (taxels,).
        """
        if not len(self._holes):
            return FilledReadings(pressures, self._none)
        readings = np.nan_to_num(pressures[self._neighbours], nan=0.0)
        least = np.broadcast_to(threshold, pressures.shape)[self._neighbours]
        touched = self._sum(readings >= _NOTICED * least) > 0
        if not touched.any() and not pressures[self._holes].any():
            return FilledReadings(pressures, self._none)
        areas = self._areas[self._neighbours]
        deviations = np.broadcast_to(noise, pressures.shape)[self._neighbours]
        noise_of_sum = np.sqrt(self._sum((deviations * areas) ** 2))
        pressed = touched & (self._sum(readings * areas) >= _DEVIATIONS * noise_of_sum)
        largest = np.zeros(len(self._holes))
        np.maximum.at(largest, self._hole_of, readings)
        filled = pressures.copy()
        filled[self._holes] = np.where(pressed, self._sum(readings) / self._count, 0.0)
        sd = np.zeros(len(pressures))
        sd[self._holes] = np.where(pressed, _UNCERTAINTY * largest, 0.0)
        return FilledReadings(readonly(filled), readonly(sd))

    def _sum(self, values: FloatArray | BoolArray) -> FloatArray:
        """Return the sum over the working neighbours of each hole, from ``values`` of all neighbours."""
        return np.bincount(self._hole_of, values, len(self._holes)).astype(np.float64)

    def _blind_areas(self, blind: BoolArray, pairs: IntArray) -> tuple[BlindArea, ...]:
        """Return connected areas of ``blind`` (taxels,), from ``pairs`` (m, 2) of broken taxels and neighbours."""
        taxels = np.flatnonzero(blind)
        inside = np.searchsorted(taxels, pairs[blind[pairs[:, 0]] & blind[pairs[:, 1]]])
        links = coo_array((np.ones(len(inside)), (inside[:, 0], inside[:, 1])), shape=(len(taxels), len(taxels)))
        count, label = connected_components(links, directed=False)
        areas = [taxels[label == number] for number in range(count)]
        return tuple(
            BlindArea(self._skin.patches[int(self._skin.patch_of[area[0]])].link, area, float(self._areas[area].sum()))
            for area in areas
        )


class MissingReadings:
    """Estimates the readings of known broken taxels and of those that did not report (NaN). Mutable.

    Args:
        skin: The skin.

    Cost: 1 µs while all taxels report and none is broken; 0.2 ms for 1000 taxels when other taxels are missing.
    """

    def __init__(self, skin: Skin) -> None:
        self._broken = np.zeros(len(skin), dtype=np.bool_)
        self._skin = skin
        self._fill: TaxelFill | None = None
        self._last: tuple[FloatArray, FilledReadings] | None = None

    def set_broken(self, broken: BoolArray) -> None:
        """Estimate these ``broken`` (taxels,) from now on, whatever they read."""
        self._broken = readonly(broken, np.bool_)
        self._use(self._broken)

    def forget(self) -> None:
        """Forget the last estimates, because threshold or noise changed."""
        self._last = None

    @property
    def blind(self) -> tuple[BlindArea, ...]:
        """Areas that cannot be estimated, at the last frame."""
        return () if self._fill is None else self._fill.blind

    def fill(
        self, pressures: FloatArray, *, threshold: float | FloatArray, noise: float | FloatArray
    ) -> FilledReadings | None:
        """Return the readings with estimates; None where none is needed.

        A reading that cannot change is estimated once: a slow skin repeats it from tick to tick.

        Args:
            pressures: (taxels,) what the taxels read [Pa]; NaN where none arrived.
            threshold: Pressure from which a taxel counts as touched [Pa]; one for all, or (taxels,).
            noise: Standard deviation of a reading [Pa]; one for all, or (taxels,).
        """
        known = self._last
        if known is not None and known[0] is pressures and not pressures.flags.writeable:
            return known[1]
        missing = np.isnan(pressures) if math.isnan(float(pressures.sum())) else None
        self._use(self._broken if missing is None else self._broken | missing)
        if self._fill is None:
            return None
        filled = self._fill.fill(pressures, threshold=threshold, noise=noise)
        self._last = (pressures, filled)
        return filled

    def _use(self, broken: BoolArray) -> None:
        known = self._fill
        if known is None or not np.array_equal(known.broken, broken):
            self._fill = TaxelFill(self._skin, broken) if broken.any() or known is not None else None
            self._last = None
