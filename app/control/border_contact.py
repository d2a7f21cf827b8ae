"""An object on the border of two patches is felt by both: here the two regions are one contact again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.contacts.region import ContactRegion
from app.control.map_sight import MapSight
from app.maps.map_jacobian import JacobianKind
from app.robots.configuration import Configuration

WIDE = 3.0
"""Contacts on two patches no more than so many pitches apart are one."""


def over_borders(
    region: ContactRegion,
    regions: Sequence[ContactRegion],
    sight: MapSight,
    configuration: Configuration,
    jacobian: JacobianKind,
) -> ContactRegion:
    """The contact with what touches beside it on other patches: all their force, at the centre of all.

    Kept at a goal on one patch alone, an object would be pressed ever more with the other as it is led across; and the
    centre on one patch alone is never on the border, so that it would be led back from there.

    Args:
        region: On one patch.
        regions: All there are.
        sight: Of the map.
        configuration: At the present posture.
        jacobian: By which the centre is drawn beyond the patch's border, as the map would go on there.
    """
    pose = configuration.pose(region.link)
    here, reach = pose.points(region.point), WIDE * sight.pitch
    others = [
        (other, configuration.pose(other.link).points(other.point))
        for other in regions
        if other.at.patch != region.at.patch
    ]
    beside = [(other, place) for other, place in others if np.linalg.norm(place - here) < reach]
    if not beside:
        return region
    force = region.force + sum(other.force for other, _ in beside)
    shift = sum((other.force * (place - here) for other, place in beside), np.zeros(3)) / max(force, 1e-9)
    along = sight.jacobian(region.at, jacobian, configuration) @ shift
    inverse = pose.rotation.T
    return replace(region, force=force, map_point=region.map_point + along, point=region.point + inverse @ shift)
