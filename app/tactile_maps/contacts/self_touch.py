"""Self-touch: pairs of contact regions that are the two sides of one contact of the robot with itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.pose import Pose

GAP = 0.004
"""Largest distance of the centres in addition to their uncertainty [m], for the yielding of the covers."""
FACING = -0.5
"""Largest scalar product of the two normals."""
EQUAL = 0.2
"""Largest difference of the forces of a new pair, as a share of the larger force."""
LOOSE = 0.6
"""The same for a known pair."""
_SURE = 2.0
"""Allowed differences, in standard uncertainties."""


class _Side(NamedTuple):
    region: ContactRegion
    point: FloatArray
    normal: FloatArray


class SelfTouchMatcher:
    """Pairing of regions, frame by frame. Mutable: it stores the known pairs; ``reset`` forgets them.

    Two regions on different links are one contact if their centres are closer together in the world than ``GAP`` plus
    twice the uncertainty of their places, their normals face each other, and their forces are equal, as action and
    reaction. A known pair remains one while it is close and facing, and its forces are within ``LOOSE``.

    Limits: an object thinner than ``GAP`` between two links looks the same. If another body presses one of the regions
    as well, its force is larger than that of its partner: such a pair is not detected, but a known pair is kept.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget all pairs."""
        self._pairs: frozenset[tuple[int, int]] = frozenset()

    def link(self, regions: Sequence[ContactRegion], pose: Callable[[str], Pose]) -> tuple[ContactRegion, ...]:
        """Return the regions in the same order, those of a pair with each other's id as ``partner``.

        Args:
            regions: Regions of one frame.
            pose: Returns ``T_world_link`` of a link; called only if two links are touched.

        Cost: 0.5 µs unless two links are touched, otherwise 15 µs a region and 2 µs a pair of regions.
        """
        links = {region.link for region in regions}
        if len(links) < 2:
            self._pairs = frozenset()
            return tuple(regions)
        poses = {link: pose(link) for link in links}
        sides = [
            _Side(
                region,
                poses[region.link].points(region.link_position),
                poses[region.link].directions(region.link_normal),
            )
            for region in sorted(regions, key=lambda region: region.id)
        ]
        partner = self._partners(sides)
        self._pairs = frozenset((one, other) for one, other in partner.items() if one < other)
        return tuple(replace(r, partner=partner[r.id]) if r.id in partner else r for r in regions)

    def _partners(self, sides: list[_Side]) -> dict[int, int]:
        """Return partners by id. The closest pairs are matched first, and no region has two partners."""
        found = []
        for number, one in enumerate(sides):
            for other in sides[number + 1 :]:
                apart = self._apart(one, other)
                if apart is not None:
                    found.append((apart, one.region.id, other.region.id))
        partner: dict[int, int] = {}
        for _, a, b in sorted(found):
            if a not in partner and b not in partner:
                partner[a] = b
                partner[b] = a
        return partner

    def _apart(self, one: _Side, other: _Side) -> float | None:
        """Return the distance of the centres [m] if the two may be one contact, otherwise None."""
        a = one.region
        b = other.region
        if a.link == b.link or float(one.normal.dot(other.normal)) > FACING:
            return None
        apart = float(np.linalg.norm(one.point - other.point))
        if apart > GAP + _SURE * math.hypot(a.place_error, b.place_error):
            return None
        share = LOOSE if (a.id, b.id) in self._pairs else EQUAL
        allowed = share * max(a.force, b.force) + _SURE * math.hypot(a.force_error, b.force_error)
        return apart if abs(a.force - b.force) <= allowed else None
