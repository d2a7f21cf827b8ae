"""Whether one touch explains what a force-torque sensor in a link reports, where the skin tells several touches apart.

One wrench is six numbers. Two touches have at least six unknowns of force alone, so their wrench cannot be split, and
the one contact that ``ForceTorqueSensor`` makes of it lies somewhere between them, or nowhere: a controller must not
lead it to a place. ``wrench_mismatch`` tells when that is so.
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
"""Standard deviations of the sensor's noise that are no mismatch."""
_FORCE_SHARE = 0.3
"""Of a touch's force: so far the skin's sum may be from a sensor's, by the cover's blur, gains and the skin's edge."""
_LEAST_FORCE = 0.2
_LEAST_TORQUE = 0.002
"""[N], [N m] that are no mismatch even for a sensor without noise: a taxel's threshold is as much."""


@dataclass(frozen=True)
class WrenchMismatch:
    """Several touches of a link whose wrench none of them explains alone.

    Attributes:
        link: The link.
        touches: How many the skin tells apart.
        force: Of the wrench's normal force, what the touch that explains it best leaves [N].
        torque: The same of its torque about that touch [N m].
        max_force: What may be left of the force [N].
        max_torque: The same of the torque [N m].
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
    """Regions so close together that one body may make all of them.

    Attributes:
        point: (3,) centre of their forces [m], link frame.
        normal: (3,) outward, unit.
        force: Their sum [N].
        radius: From the point to the farthest of what they cover [m].
    """

    point: FloatArray
    normal: FloatArray
    force: float
    radius: float


def wrench_mismatch(
    link: str, wrench: Wrench, regions: Sequence[ContactRegion], positions: FloatArray
) -> WrenchMismatch | None:
    """Why no one touch explains the wrench; None where one does, or where the skin tells only one.

    A touch alone presses with its own force, and its torque is that of the whole force, friction included, at a point
    within what it covers. The sensor's noise and what the skin's sum is not worth are no mismatch.

    Args:
        link: The link.
        wrench: What its sensor reports.
        regions: The skin's contacts on it, with the sums of pressure times area.
        positions: (taxels, 3) of the skin [m], frames of the links.

    Cost: nothing with one region; 30 µs with two.
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
    """How many times what may be left is left."""
    return max(left.force / left.max_force, left.torque / left.max_torque)


def _mismatch(link: str, wrench: Wrench, touch: _Touch, touches: int, strongest: float) -> WrenchMismatch:
    """What ``touch`` alone leaves of the wrench."""
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
    """Regions as touches: those whose reaches meet are one, for a border or a dead taxel may part what one body
    presses."""
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
