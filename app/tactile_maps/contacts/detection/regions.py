"""A contact region: one touched area of the skin, read from the tactile map; and the graph of taxels in which such
areas are connected.

``ContactRegion`` is the value. ``TaxelGraph`` groups touched taxels that are neighbours on the body, so that a seam
never splits a group. ``SeamCrossings`` tests whether a seam tears a group apart on the map.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.contact_shear import ContactShear
from tactile_maps.contacts.detection.error_budget import coverage_interval
from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, readonly
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap
from tactile_maps.skin.model.skin import Skin

_NO_AXES = readonly(np.zeros((2, 3)))
_NO_MAP_AXES = readonly(np.zeros((2, 2)))


@dataclass(frozen=True, eq=False)
class ContactRegion(ArrayFields):
    """A connected touched area.

    ``touched``, ``area``, ``peak`` and ``mean`` refer to the touched taxels alone. Force and centre also include the
    ring of untouched taxels around them, where 8 to 20 % of the force stays below the threshold.

    Attributes:
        id: Kept while the region lives, from frame to frame; 1 or more.
        taxels: (k,) taxel numbers, the touched ones and their one-ring, rising.
        force: Sum of pressure times area over ``taxels`` [N]; normal force only, see ``shear``.
        area: Total area of the touched taxels [m²].
        peak: Highest pressure of the touched taxels [Pa].
        map_point: (2,) centre of pressure on the tactile map [m].
        at: The centre of pressure back-projected to the body.
        link: Name of the touched link.
        link_position: (3,) the same point [m], frame of the link.
        link_normal: (3,) outward unit normal there, frame of the link.
        torn: Whether a seam tears the region apart on the map, so that its centre was taken on the body instead.
        mean: Mean pressure over the touched taxels [Pa].
        touched: Number of touched taxels; None in recordings that do not store it.
        link_axes: (2, 3) half-axes of the ellipse with the region's second moments, the longer first [m], frame of the
            link.
        map_axes: (2, 2) the same two on the map [m]; as the map distorts there they need not be at right angles, but
            ``map_point + cos t map_axes[0] + sin t map_axes[1]`` still draws the ellipse.
        place_error: Standard uncertainty of the centre, radial [m]; see ``error_budget``.
        force_error: Standard uncertainty of the force [N]: 68 % of true forces are within it.
        force_parts: Parts of ``force_error`` [N] by name, see ``error_budget``; empty in recordings that do not store
            them.
        force_limits: The same parts for ``force_interval`` [N]; empty in recordings that do not store them.
        partner: Id of the region on another link that touches this one; None if there is none known.
        merged: Ids of the regions that have become part of this one at this frame.
        split_from: Id of the region that this one has come off at this frame; None if there is none.
        shear: Force and torque along the skin; None for a skin whose taxels measure one axis.

    Example:
        >>> (contact,) = tm.read_contacts(tactile_map, tm.press_skin(skin, skin.taxel_point(30)))
        >>> contact.link, contact.map_point.shape, contact.area > 0
        ('hand', (2,), True)
    """

    id: int
    taxels: IntArray
    force: float
    area: float
    peak: float
    map_point: FloatArray
    at: SurfacePoint
    link: str
    link_position: FloatArray
    link_normal: FloatArray
    torn: bool = False
    mean: float = 0.0
    touched: int | None = None
    link_axes: FloatArray = field(default_factory=lambda: _NO_AXES)
    map_axes: FloatArray = field(default_factory=lambda: _NO_MAP_AXES)
    place_error: float = 0.0
    force_error: float = 0.0
    force_parts: Mapping[str, float] = field(default_factory=dict)
    force_limits: Mapping[str, float] = field(default_factory=dict)
    partner: int | None = None
    merged: tuple[int, ...] = ()
    split_from: int | None = None
    shear: ContactShear | None = None

    @property
    def force_vector(self) -> FloatArray:
        """(3,) force of the touching body on the link [N], frame of the link; normal only if there is no ``shear``."""
        along = np.zeros(3) if self.shear is None else np.array(self.shear.force)
        return along - self.force * self.link_normal

    @property
    def force_interval(self) -> tuple[float, float]:
        """Lowest and highest force [N] of the interval that contains the true force of 95 % of contacts."""
        limits = self.force_limits or {"": 2 * self.force_error}
        return coverage_interval(self.force, limits)


class TaxelGroup(NamedTuple):
    """Touched taxels that are connected on the body, and the untouched ring around them."""

    core: frozenset[int]
    ring: frozenset[int]


class TaxelGraph:
    """Grouping of touched taxels. Built once for a skin.

    It uses sets of neighbours, so that only the touched taxels and their ring are visited.

    Args:
        skin: The skin.

    Cost: about 1 ms for 1000 taxels to build; a group of 20 taxels then takes 10 µs.
    """

    def __init__(self, skin: Skin) -> None:
        self.near = _neighbour_sets(len(skin), skin.neighbours)

    def groups(self, touched: list[int]) -> list[TaxelGroup]:
        """Return the groups of ``touched`` taxels, that of the smallest taxel first.

        A ring taxel between two groups is in both rings; see ``ring_shares``.
        """
        left = set(touched)
        return [self._flood(start, left) for start in touched if start in left]

    def _flood(self, start: int, left: set[int]) -> TaxelGroup:
        """Return the group of ``start`` and remove it from the touched taxels ``left``."""
        core = {start}
        front = {start}
        reached: set[int] = set()
        left.discard(start)
        while front:
            around: set[int] = set().union(*[self.near[taxel] for taxel in front])
            reached |= around
            front = around & left
            left -= front
            core |= front
        return TaxelGroup(frozenset(core), frozenset(reached - core))

    def extended(self, groups: Sequence[TaxelGroup], pressed: set[int]) -> list[TaxelGroup]:
        """Return the groups with the ``pressed`` taxels that are connected to their rings.

        Each taxel is added to the ring of the nearest group, or of several that are equally near.
        """
        left = pressed.difference(*(group.core | group.ring for group in groups))
        rings = [set(group.ring) for group in groups]
        fronts = [group.ring & pressed for group in groups]
        while left and any(fronts):
            around = [frozenset[int]().union(*[self.near[taxel] for taxel in front]) for front in fronts]
            fronts = [one & left for one in around]
            for ring, front in zip(rings, fronts, strict=True):
                ring |= front
            left = left.difference(*fronts)
        return [TaxelGroup(group.core, frozenset(ring)) for group, ring in zip(groups, rings, strict=True)]


def ring_shares(contacts: Sequence[IntArray]) -> list[FloatArray | None]:
    """Return the share (k,) that each contact has in the readings of its taxels (k,); None where it shares none.

    A ring taxel between contacts is shared evenly among them, so that each reading counts once.

    Cost: none for one contact, otherwise 15 µs.
    """
    if len(contacts) < 2:
        return [None] * len(contacts)
    taxels, number, owners = np.unique(np.concatenate(contacts), return_inverse=True, return_counts=True)
    if len(taxels) == len(number):
        return [None] * len(contacts)
    shares = np.split(1.0 / owners[number], np.cumsum([len(own) for own in contacts[:-1]]))
    return [share if share.min() < 1.0 else None for share in shares]


def shared_readings(readings: FloatArray, taxels: IntArray, share: FloatArray | None) -> FloatArray:
    """Return the ``readings`` (taxels, ...) with the ``share`` (k,) that a contact has in those of its ``taxels`` (k,).

    Without shares the same array is returned.
    """
    if share is None:
        return readings
    readings = readings.copy()
    readings[taxels] = (readings[taxels].T * share).T
    return readings


class SeamCrossings:
    """Test of whether a seam tears a group of taxels apart on a map. Built for a map: 0.2 ms for 1000 taxels.

    Args:
        map_: The map.
        body: (taxels, 3) positions on the body [m], each in its link's frame.
    """

    def __init__(self, map_: TactileMap, body: FloatArray) -> None:
        pairs = map_.skin.neighbours
        on_body = np.linalg.norm(body[pairs[:, 0]] - body[pairs[:, 1]], axis=1)
        on_map = np.linalg.norm(map_.taxel_points[pairs[:, 0]] - map_.taxel_points[pairs[:, 1]], axis=1)
        scales = np.array([placement.scale for placement in map_.layout.placements])
        self.pairs = pairs[on_map > SEAM_RATIO * scales[map_.skin.patch_of[pairs[:, 0]]] * on_body]
        self._first = frozenset(self.pairs[:, 0].tolist())

    def tear(self, taxels: frozenset[int]) -> bool:
        """Whether a seam separates two neighbours among ``taxels``."""
        at_seam = taxels & self._first
        return bool(at_seam) and any(a in at_seam and b in taxels for a, b in self.pairs.tolist())


def _neighbour_sets(count: int, pairs: np.ndarray) -> list[frozenset[int]]:
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    ends = np.searchsorted(both[:, 0], np.arange(count + 1)).tolist()
    others = both[:, 1].tolist()
    return [frozenset(others[start:end]) for start, end in pairwise(ends)]
