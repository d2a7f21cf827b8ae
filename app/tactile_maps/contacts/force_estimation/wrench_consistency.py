"""Test of whether one touch explains the wrench of a force-torque sensor where the skin detects several touches.

A wrench has six components. Two touches have at least six unknowns of force alone, so their wrench cannot be split. The
single contact of ``ForceTorqueSensor`` is then somewhere between them or does not exist, and a controller must not move
it to a place. ``wrench_mismatch`` detects this case.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.estimate import Wrench
from tactile_maps.core.arrays import FloatArray, length

_SIGMAS = 4.0
"""Differences up to this number of standard deviations of the sensor's noise are not a mismatch."""
_FORCE_SHARE = 0.3
"""Allowed difference between skin and sensor as a share of a force: blur of the cover, gains, edge of the skin."""
_LEAST_FORCE = 0.2
_LEAST_TORQUE = 0.002
"""Differences [N], [N m] that are not a mismatch even without noise: about the threshold of a taxel."""


@dataclass(frozen=True)
class WrenchMismatch:
    """Several touches of a link of which none alone explains the wrench.

    Attributes:
        link: The link.
        touches: Number of touches that the skin distinguishes.
        force: Part of the normal force that the best touch leaves unexplained [N].
        torque: Part of the torque about that touch that it leaves unexplained [N m].
        max_force: Largest consistent value of ``force`` [N].
        max_torque: Largest consistent value of ``torque`` [N m].
        strongest: Force of the strongest touch by the skin [N]; forces that oppose each other have no resultant.
    """

    link: str
    touches: int
    force: float
    torque: float
    max_force: float
    max_torque: float
    strongest: float


class _Touch(NamedTuple):
    """Regions that are so close together that one body may cause them.

    Attributes:
        point: (3,) centre of their forces [m], link frame.
        normal: (3,) outward unit normal.
        force: Sum of their forces [N].
        radius: Distance from ``point`` to the farthest point of the regions [m].
    """

    point: FloatArray
    normal: FloatArray
    force: float
    radius: float


def wrench_mismatch(
    link: str, wrench: Wrench, regions: Sequence[ContactRegion], positions: FloatArray
) -> WrenchMismatch | None:
    """Return the mismatch if no single touch explains the wrench; None if one does, or if there is only one.

    A single touch has its own force, and its torque is that of the whole force, friction included, at a point within
    its area. The sensor's noise and the uncertainty of the skin's sum are allowed for.

    Args:
        link: The link.
        wrench: Reading of its sensor.
        regions: Contacts of the skin on it, with the sums of pressure times area.
        positions: (taxels, 3) positions of the taxels [m], frames of the links.

    Cost: none with one region, 30 µs with two.
    """
    if len(regions) < 2:
        return None
    touches = _touches(regions, positions)
    if len(touches) < 2:
        return None
    strongest = max(touch.force for touch in touches)
    found = [_mismatch(link, wrench, touch, len(touches), strongest) for touch in touches]
    best = min(found, key=_excess)
    return best if _excess(best) > 1 else None


def _excess(left: WrenchMismatch) -> float:
    """Return the largest ratio of a difference to its allowed value."""
    return max(left.force / left.max_force, left.torque / left.max_torque)


def _mismatch(link: str, wrench: Wrench, touch: _Touch, touches: int, strongest: float) -> WrenchMismatch:
    """Return the part of the wrench that ``touch`` alone does not explain."""
    force = abs(float(-wrench.force @ touch.normal) - touch.force)
    torque = length(wrench.torque - np.cross(touch.point, wrench.force))
    torque_noise = math.sqrt(3 * wrench.torque_noise**2 + 2 * (wrench.force_noise * length(touch.point)) ** 2)
    return WrenchMismatch(
        link=link,
        touches=touches,
        force=force,
        torque=torque,
        max_force=_LEAST_FORCE + _FORCE_SHARE * touch.force + _SIGMAS * wrench.force_noise,
        max_torque=_LEAST_TORQUE + length(wrench.force) * touch.radius + _SIGMAS * torque_noise,
        strongest=strongest,
    )


def _touches(regions: Sequence[ContactRegion], positions: FloatArray) -> list[_Touch]:
    """Return the touches. Regions within reach of each other are one: a border or a dead taxel may separate them."""
    touches: list[_Touch] = []
    for region in regions:
        reach = np.linalg.norm(positions[region.taxels] - region.link_position, axis=1).max(initial=0.0)
        new = _Touch(region.link_position, region.link_normal, region.force, float(reach))
        apart = []
        for touch in touches:
            if length(touch.point - new.point) <= touch.radius + new.radius:
                new = _joined(touch, new)
            else:
                apart.append(touch)
        touches = [*apart, new]
    return touches


def _joined(one: _Touch, other: _Touch) -> _Touch:
    force = one.force + other.force
    share = one.force / force if force > 0 else 0.5
    point = share * one.point + (1 - share) * other.point
    normal = share * one.normal + (1 - share) * other.normal
    size = length(normal)
    radius = max(length(touch.point - point) + touch.radius for touch in (one, other))
    return _Touch(point, normal / size if size > 0 else one.normal, force, radius)
