"""Self-touch: which two contact regions are the two sides of one contact of the robot with itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.pose import Pose


@dataclass(frozen=True)
class SelfTouchThresholds:
    """When two regions on different links are one contact.

    Their centres lie close together in the world, closer than ``gap`` and twice their places' uncertainty; their skins
    face each other; and they feel the same force, as action and reaction do. A pair stays one, once found, while it
    stays close and facing, and its forces within ``loose``.

    What it cannot tell: a thin thing held between two links looks the same from both sides, closer than ``gap``. And a
    region that something else presses as well bears more force than its partner, so such a pair is not found, but kept
    if it was one before.

    Attributes:
        gap: Allowed between the centres besides their uncertainty [m]: how deep covers give way.
        facing: Largest scalar product of the two normals.
        equal: Largest difference of the forces as a share of the greater, to begin with.
        loose: The same, to stay one.
    """

    gap: float = 0.004
    facing: float = -0.5
    equal: float = 0.2
    loose: float = 0.6


_RULE = SelfTouchThresholds()
_SURE = 2.0
"""Standard uncertainties that differences may have."""


class _Side(NamedTuple):
    region: ContactRegion
    point: FloatArray
    normal: FloatArray


class SelfTouchMatcher:
    """Links regions to their partners frame by frame. Mutable: it remembers the pairs; ``reset`` forgets them.

    Args:
        rule: When two are one.
    """

    def __init__(self, *, rule: SelfTouchThresholds = _RULE) -> None:
        self._rule = rule
        self.reset()

    def reset(self) -> None:
        """No pair is known."""
        self._pairs: frozenset[tuple[int, int]] = frozenset()

    def link(self, regions: Sequence[ContactRegion], pose: Callable[[str], Pose]) -> tuple[ContactRegion, ...]:
        """The same regions in the same order, those of a pair with each other's id as ``partner``.

        Args:
            regions: Of one frame.
            pose: ``T_world_link`` of a link by its name; only asked where two links are touched.

        Cost: 0.5 µs unless two links are touched, else 15 µs a region and 2 µs a pair of them.
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
        """Partners by id; who is closest goes first, and nobody has two."""
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
        """How far apart the two centres lie [m] if the two may be one contact, else None."""
        a = one.region
        b = other.region
        rule = self._rule
        if a.link == b.link or float(one.normal.dot(other.normal)) > rule.facing:
            return None
        apart = float(np.linalg.norm(one.point - other.point))
        if apart > rule.gap + _SURE * math.hypot(a.place_error, b.place_error):
            return None
        share = rule.loose if (a.id, b.id) in self._pairs else rule.equal
        allowed = share * max(a.force, b.force) + _SURE * math.hypot(a.force_error, b.force_error)
        return apart if abs(a.force - b.force) <= allowed else None
