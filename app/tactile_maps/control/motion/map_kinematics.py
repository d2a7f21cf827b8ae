"""What a controller sees of the map: Jacobians, and how far it is from one place to another, over seams and links."""

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
"""Two places this near on the body [m] are never taken for torn apart because of rounding."""


class MapKinematics:
    """A map as control needs it. Built once for a map.

    Args:
        map_: The map.

    Attributes:
        map: The same.
        pitch: Distance of neighbouring taxels, about [m].
    """

    def __init__(self, map_: TactileMap) -> None:
        self.map = map_
        self._jacobian = MapJacobian(map_)
        self.pitch = float(np.sqrt(map_.skin.areas.mean())) if len(map_.skin) else 0.0

    @cached_property
    def transitions(self) -> SeamTransitions:
        """How the map goes on over its seams; made when a path first asks."""
        return SeamTransitions(self.map)

    def jacobian(self, at: SurfacePoint, kind: JacobianKind, configuration: Configuration) -> FloatArray:
        """(2, 3) map velocity per velocity of a point along the skin, world frame, at the configuration's posture."""
        turn = configuration.pose(self.map.skin.link(at)).rotation
        return self._jacobian.at(at, kind=kind).dot(turn.T)

    def normal(self, region: ContactRegion, kind: JacobianKind) -> FloatArray:
        """(3,) outward unit normal at a contact, link frame: by the same word as the Jacobian's."""
        smooth = self._jacobian.normal(region.at) if kind != "raw" else None
        return region.link_normal if smooth is None else smooth

    def error(
        self, target: SurfacePoint, region: ContactRegion, jacobian: FloatArray, configuration: Configuration
    ) -> FloatArray:
        """(2,) from a contact to a target, in map coordinates at the contact [m].

        Straight on the map where the map is in one piece between them. Over a seam, or from patch to patch, it is the
        way in space, laid into the tangent plane at its length and on the map by the contact's Jacobian (2, 3).
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
        """How far a contact is from a place in space [m]."""
        here = configuration.pose(region.link).points(region.link_position)
        return float(np.linalg.norm(self._in_world(target, configuration) - here))

    def apart(self, one: SurfacePoint, other: SurfacePoint, configuration: Configuration) -> float:
        """How far two places are from each other in space [m]."""
        return length(self._in_world(one, configuration) - self._in_world(other, configuration))

    def _in_world(self, at: SurfacePoint, configuration: Configuration) -> FloatArray:
        skin = self.map.skin
        return configuration.pose(skin.link(at)).points(skin.position(at))
