"""Readings of known broken taxels, estimated from the working taxels around them.

A broken taxel reads nothing, or always the same value. Its reading is replaced by an estimate from the working taxels
up to two rings away on the body; neighbours belong to one patch, so nothing is estimated across patches. The estimate
assumes one contact whose pressure is even, or a paraboloid with an unknown place, radius and peak. For many places and
radii the readings of such a contact are computed once, from the quadrature points of the taxels. Each contact gets the
peak that fits the current readings best (least squares) and a weight by the likelihood of the misfit. The estimate is
the median of what these contacts press on the broken taxel. Its standard uncertainty is half of the deviation that
95 % of them stay within (JCGM 101:2008, 7.7).

Readings do not bound the force of a contact that is smaller than the hole. Contacts that show less than ``_VISIBLE`` of
their force to working taxels are left out, so a contact on broken taxels alone is not estimated.

Broken taxels with fewer than two working neighbours are blind: they keep what they read. ``BlindArea`` names them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from app.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays, readonly
from app.skin.skin import Quadrature, Skin, number_ranges
from app.tactile.contact_notes import ContactNote, ContactNoteKind
from app.tactile.receptive_field import quadrature_points

LEAST_NEIGHBOURS = 2
"""Number of working neighbours from which on a broken taxel is estimated."""
_RADII = np.geomspace(0.35, 3.0, 12)
"""Radii of contacts, in square roots of the mean area of a taxel."""
_SMALL = 2.0
"""Prior weights fall with this power of the radius: most contacts are small. With it 95 % of contacts that reach a
broken taxel are within twice the stated uncertainty (balls of 4 to 20 mm, 10 % broken taxels)."""
_VISIBLE = 0.12
"""Least share of a contact's force that working taxels read."""
_MISFIT = 0.15
"""Standard deviation of the misfit as a share of the readings: contacts are no exact paraboloids."""
_PLACES = 8
"""Places of contacts on each neighbour; three times as many on the broken taxel."""
_UNLIKELY = 1e-4
"""Weight below which a contact is left out, as a share of the largest."""
_NOTICED = 0.1
"""Share of the threshold from which a reading of a neighbour counts."""
_DEVIATIONS = 6.0
"""Standard deviations of their noise by which the readings of the neighbours exceed zero, as for a new contact."""


@dataclass(frozen=True, eq=False)
class BlindArea:
    """Connected broken taxels that have too few working neighbours to be estimated.

    Attributes:
        link: Link that they cover.
        taxels: (k,) their numbers, rising.
        area: Sum of their areas [m²].
    """

    link: str
    taxels: IntArray
    area: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxels", dtype=np.int64)

    @property
    def note(self) -> ContactNote:
        """The note that names the area."""
        word = "taxel" if len(self.taxels) == 1 else "taxels"
        return ContactNote(
            ContactNoteKind.BLIND_AREA, (f"{word} {number_ranges(self.taxels)}", self.link), area=self.area
        )


class FilledReadings(NamedTuple):
    """One reading of the skin with estimates in place of broken taxels.

    Attributes:
        pressures: (taxels,) [Pa]; the given array where nothing is estimated.
        sd: (taxels,) standard uncertainty of the estimates [Pa]; 0 for working taxels.
    """

    pressures: FloatArray
    sd: FloatArray


class _Contacts(NamedTuple):
    """Contacts that may press a broken taxel.

    Attributes:
        around: (m,) working taxels up to two rings away.
        ring: (r,) those next to it.
        readings: (k, m) forces that they read of each contact, of unit length.
        forces: (k,) force on the broken taxel for the same peak.
        weights: (k,) prior weights.
    """

    around: IntArray
    ring: IntArray
    readings: FloatArray
    forces: FloatArray
    weights: FloatArray


class TaxelFill:
    """Estimates the readings of broken taxels. Mutable: what an estimate needs is computed when a taxel is first used.

    Args:
        skin: The skin.
        broken: (taxels,) whether each is broken.

    Attributes:
        broken: As above.
        blind: Areas that cannot be estimated.

    Cost: 1 µs while nothing touches a neighbour of a broken taxel, else 0.1 ms for each such taxel, and 5 ms when it is
    touched for the first time.
    """

    def __init__(self, skin: Skin, broken: BoolArray) -> None:
        self.broken = readonly(broken, np.bool_)
        self._skin = skin
        self._areas = skin.areas
        self._near: dict[int, set[int]] = {}
        self._points: Quadrature | None = None
        self._contacts: dict[int, _Contacts] = {}
        self._none = readonly(np.zeros(len(skin)))
        pairs = np.concatenate([skin.neighbours, skin.neighbours[:, ::-1]])
        if broken.any():
            for one, other in pairs.tolist():
                self._near.setdefault(one, set()).add(other)
        at_border = pairs[broken[pairs[:, 0]] & ~broken[pairs[:, 1]]]
        working = np.bincount(at_border[:, 0], minlength=len(skin))
        self._estimated = self.broken & (working >= LEAST_NEIGHBOURS)
        at_border = at_border[self._estimated[at_border[:, 0]]]
        self._holes: IntArray = at_border[:, 0]
        self._beside: IntArray = at_border[:, 1]
        self.blind = self._blind_areas(self.broken & ~self._estimated)

    def fill(
        self, pressures: FloatArray, *, threshold: float | FloatArray, noise: float | FloatArray = 0.0
    ) -> FilledReadings:
        """Return the readings with estimates.

        Args:
            pressures: (taxels,) what the taxels read [Pa]; not changed.
            threshold: Pressure from which a taxel counts as touched [Pa]; one for all, or (taxels,).
            noise: Standard deviation of a reading [Pa]; one for all, or (taxels,).
        """
        holes = self._touched(pressures, threshold)
        if not len(holes) and not pressures[self._estimated].any():
            return FilledReadings(pressures, self._none)
        filled = pressures.copy()
        filled[self._estimated] = 0.0
        sd = np.zeros(len(pressures))
        forces = np.where(np.isfinite(pressures), pressures, 0.0) * self._areas
        loads = np.broadcast_to(noise, pressures.shape) * self._areas
        for hole in holes.tolist():
            force, spread = self._estimate(hole, forces, loads)
            filled[hole] = force / self._areas[hole]
            sd[hole] = spread / self._areas[hole]
        return FilledReadings(readonly(filled), readonly(sd))

    def _touched(self, pressures: FloatArray, threshold: float | FloatArray) -> IntArray:
        """Return the broken taxels with a neighbour that reads something."""
        least = _NOTICED * (threshold[self._beside] if isinstance(threshold, np.ndarray) else threshold)
        return np.unique(self._holes[pressures[self._beside] >= least])

    def _estimate(self, hole: int, forces: FloatArray, noise: FloatArray) -> tuple[float, float]:
        """Return force and standard uncertainty [N] on a broken taxel, for ``forces`` with ``noise`` (taxels,) [N]."""
        contacts = self._contacts.get(hole)
        if contacts is None:
            contacts = self._contacts[hole] = self._possible_contacts(hole)
        ring_noise = float(np.linalg.norm(noise[contacts.ring]))
        if not len(contacts.weights) or float(forces[contacts.ring].sum()) < _DEVIATIONS * ring_noise:
            return 0.0, 0.0
        read = forces[contacts.around]
        square = float(read.dot(read))
        peaks = np.maximum(contacts.readings.dot(read), 0.0)
        misfits = np.maximum(square - peaks * peaks, 0.0)
        least = float(misfits.min())
        variance = _MISFIT**2 * square + float(np.mean(noise[contacts.around] ** 2)) + least / len(read)
        weights = contacts.weights * np.exp(-0.5 * (misfits - least) / variance)
        likely = weights > _UNLIKELY * weights.max()
        return _median_and_deviation((peaks * contacts.forces)[likely], weights[likely])

    def _possible_contacts(self, hole: int) -> _Contacts:
        if self._points is None:
            self._points = quadrature_points(self._skin)
        points = self._points
        ring = self._near[hole]
        taxels = np.array(sorted({hole}.union(ring, *(self._near[taxel] for taxel in ring))))
        rows = np.flatnonzero(np.isin(points.taxel, taxels))
        owner = np.searchsorted(taxels, points.taxel[rows])
        middles: list[int] = []
        each: list[float] = []
        for taxel in sorted({hole} | ring):
            own = np.flatnonzero(taxels[owner] == taxel)
            most = 3 * _PLACES if taxel == hole else _PLACES
            places = own[:: max(len(own) // most, 1)]
            middles += places.tolist()
            each += [self._areas[taxel] / len(places)] * len(places)
        offsets = points.positions[rows[middles]][:, None] - points.positions[rows][None]
        squared = np.einsum("ijk,ijk->ij", offsets, offsets)
        gather = np.zeros((len(rows), len(taxels)))
        gather[np.arange(len(rows)), owner] = points.areas[rows]
        pitch = float(np.sqrt(self._areas[taxels].mean()))
        shapes = [np.maximum(1.0 - squared / (radius * pitch) ** 2, 0.0).dot(gather) for radius in _RADII]
        forces = np.concatenate([*shapes, self._areas[taxels][None]])  # the last one is even pressure
        weights = np.append(np.outer(_RADII**-_SMALL, each).ravel(), 1.0)
        works = ~self.broken[taxels]
        read = forces[:, works]
        shown = read.sum(axis=1) > _VISIBLE * forces.sum(axis=1)
        sizes = np.linalg.norm(read[shown], axis=1)
        return _Contacts(
            around=taxels[works],
            ring=np.array(sorted(taxel for taxel in ring if not self.broken[taxel])),
            readings=read[shown] / sizes[:, None],
            forces=forces[shown, int(np.searchsorted(taxels, hole))] / sizes,
            weights=weights[shown],
        )

    def _blind_areas(self, blind: BoolArray) -> tuple[BlindArea, ...]:
        """Return the connected areas of the ``blind`` (taxels,)."""
        left = set(np.flatnonzero(blind).tolist())
        found = []
        while left:
            front = [min(left)]
            area = set(front)
            while front:
                reached = left.intersection(*[set().union(*(self._near.get(taxel, set()) for taxel in front))]) - area
                area |= reached
                front = list(reached)
            left -= area
            taxels = np.array(sorted(area))
            link = self._skin.patches[int(self._skin.patch_of[taxels[0]])].link
            found.append(BlindArea(link, taxels, float(self._areas[taxels].sum())))
        return tuple(found)


def _median_and_deviation(values: FloatArray, weights: FloatArray) -> tuple[float, float]:
    """Return the weighted median, and half of the distance from it that 95 % of the weight stays within."""
    median = _quantile(values, weights, 0.5)
    return median, 0.5 * _quantile(np.abs(values - median), weights, 0.95)


def _quantile(values: FloatArray, weights: FloatArray, share: float) -> float:
    order = np.argsort(values, kind="stable")
    sums = np.cumsum(weights[order])
    return float(values[order[int(np.searchsorted(sums, share * sums[-1]))]])
