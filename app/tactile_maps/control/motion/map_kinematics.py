"""Kinematics of a tactile map: Jacobians, and distances from one place to another across seams and links."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.jacobian import JacobianKind, MapJacobian, least_norm_motion
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap
from tactile_maps.robots.kinematics import Configuration

_NEAR = 0.002
"""Places this near to each other on the body [m] do not count as separated by a seam, because of rounding."""


class MapKinematics:
    """Map data for control. Built once for a map.

    Args:
        map_: The map.

    Attributes:
        map: The map.
        pitch: Approximate distance between neighbouring taxels [m].
    """

    def __init__(self, map_: TactileMap) -> None:
        self.map = map_
        self._jacobian = MapJacobian(map_)
        self.pitch = float(np.sqrt(map_.skin.areas.mean())) if len(map_.skin) else 0.0

    @cached_property
    def transitions(self) -> SeamTransitions:
        """Continuation of the map across its seams; built at first use."""
        return SeamTransitions(self.map)

    def jacobian(self, at: SurfacePoint, kind: JacobianKind, configuration: Configuration) -> FloatArray:
        """(2, 3) map velocity per velocity of a point along the skin, world frame, at the configuration's posture."""
        turn = configuration.pose(self.map.skin.link(at)).rotation
        return self._jacobian.at(at, kind=kind).dot(turn.T)

    def normal(self, region: ContactRegion, kind: JacobianKind) -> FloatArray:
        """Return the outward unit normal (3,) at a contact, link frame, smoothed as the Jacobian of this kind."""
        smooth = self._jacobian.normal(region.at) if kind != "raw" else None
        return region.link_normal if smooth is None else smooth

    def curvature(self, region: ContactRegion, velocity: FloatArray, jacobian: FloatArray) -> float:
        """Return the curvature of the skin [1/m] where a contact moves with a velocity (2,) on the map [m/s].

        It is the rotation of the smoothed normal per length on the body. The contact's Jacobian is (2, 3).
        """
        speed = length(least_norm_motion(jacobian, velocity))
        return length(self._jacobian.normal_rate(region.at, velocity)) / speed if speed else 0.0

    def error(
        self, target: SurfacePoint, region: ContactRegion, jacobian: FloatArray, configuration: Configuration
    ) -> FloatArray:
        """Return the vector (2,) from a contact to a target, in map coordinates at the contact [m].

        It is straight on the map where the map is connected between them. Across a seam, or between patches, it is the
        vector in space, projected into the tangent plane with its length kept, and mapped by the contact's Jacobian (2,
        3).
        """
        there = self._in_world(target, configuration)
        apart = there - configuration.pose(region.link).points(region.link_position)
        if target.patch == region.at.patch:
            scale = self.map.layout.placements[target.patch].scale
            step = self.map.to_map(target) - region.map_point
            if length(step) <= SEAM_RATIO * scale * (length(apart) + _NEAR):
                return step
        step = jacobian.dot(apart)
        flat = length(least_norm_motion(jacobian, step))
        return step * (length(apart) / flat) if flat > 0 else step

    def away(self, target: SurfacePoint, region: ContactRegion, configuration: Configuration) -> float:
        """Return the distance of a contact from a place in space [m]."""
        here = configuration.pose(region.link).points(region.link_position)
        return float(np.linalg.norm(self._in_world(target, configuration) - here))

    def apart(self, one: SurfacePoint, other: SurfacePoint, configuration: Configuration) -> float:
        """Return the distance of two places in space [m]."""
        return length(self._in_world(one, configuration) - self._in_world(other, configuration))

    def _in_world(self, at: SurfacePoint, configuration: Configuration) -> FloatArray:
        skin = self.map.skin
        return configuration.pose(skin.link(at)).points(skin.position(at))
