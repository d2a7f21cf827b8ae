"""Place of a contact between the taxels of a coarse skin, from readings and the motion of the skin.

A contact that is narrower than the pitch of the taxels is read at one or a few of them: its place errs by up to half a
pitch, in steps that repeat with the taxels. While the skin slides under an object, these errors average out.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.core.arrays import FloatArray, length, within_length
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.pose import Pose

SPARSE = 0.011
"""Pitch of taxels above which the place is estimated [m]. At 12 mm the error of figures of eight falls by a tenth."""
PASSED = 2.0
"""Number of pitches that the contact passes in the time over which readings count."""
TRUSTED = 0.3
"""Weight of the assumption that G is the identity, as the time [s] in which readings one pitch apart weigh as much."""
MOST_OFF = 1.0
"""Largest distance of the place from its reading, in pitches. A reading errs by half of the diagonal of a lattice, 0.7
pitches, and an object that moves by itself is followed with this lag at most."""
_LOST = 2.0
"""Distance from a reading at which the place starts again, in pitches: a seam of the map, or another object."""


class ContactPlace:
    """Estimates the place of one contact on the map. Mutable; ``reset`` forgets it.

    The place is fitted as  a + G s  to the readings, where s is the way of the skin under an object at rest, and
    readings are forgotten exponentially (recursive least squares). G is the identity for an object of radius zero. A
    ball of radius R on skin of radius r has r / (r + R) across, and rolls where the link turns. G starts as the
    identity and follows the readings.

    Cost: 40 µs.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the contact."""
        self._contact: tuple[MapKinematics, int, int] | None = None
        self._at: SurfacePoint | None = None
        self._pose: Pose | None = None
        self._normal: FloatArray = np.zeros((3, 3))
        self._sums: FloatArray = np.zeros((3, 2))

    def look(self, now: TaskTick, region: ContactRegion) -> ContactRegion:
        """Return the region at its estimated place; unchanged on fine skins and off the map."""
        kinematics = now.map_kinematics
        pitch = kinematics.pitch
        if pitch <= SPARSE:
            return region
        contact = kinematics, region.id, region.at.patch
        pose = now.configuration.pose(region.link)
        if contact != self._contact:
            self._start(contact)
        way = np.zeros(2)
        if self._pose is not None:
            moved = self._pose.points(region.link_position) - pose.points(region.link_position)
            way = kinematics.jacobian(region.at, now.settings.jacobian, now.configuration).dot(moved)
        self._pose = pose
        place = self._fitted(region.map_point, way, now.dt, pitch, now.settings.path_speed)
        off = place - region.map_point
        if length(off) > _LOST * pitch:
            self.reset()
            return region
        place = region.map_point + within_length(off, MOST_OFF * pitch)
        at = kinematics.map.to_body(place)
        if at is None or at.patch != region.at.patch:
            return region
        self._at = at
        skin = kinematics.map.skin
        return replace(region, map_point=place, at=at, link_position=skin.position(at), link_normal=skin.normal(at))

    def _start(self, contact: tuple[MapKinematics, int, int]) -> None:
        """Start with a contact; on another map, the same one continues from its place on the body."""
        at, weight = self._at, self._normal[0, 0]
        same = self._contact is not None and contact[1:] == self._contact[1:]
        self.reset()
        self._contact = contact
        if same and at is not None:
            self._normal[0, 0] = weight
            self._sums[0] = weight * contact[0].map.to_map(at)

    def _fitted(self, point: FloatArray, way: FloatArray, dt: float, pitch: float, speed: float) -> FloatArray:
        """Return a, the place (2,) at the current position, after another reading and a way (2,) of the skin."""
        shift = np.eye(3)  # ways count from the current position
        shift[1:, 0] = -way
        kept = math.exp(-dt * speed / (PASSED * pitch))
        self._normal = kept * shift.dot(self._normal).dot(shift.T)
        self._sums = kept * shift.dot(self._sums)
        self._normal[0, 0] += dt
        self._sums[0] += dt * point
        trust = TRUSTED * pitch**2 * np.eye(3)
        trust[0, 0] = 0.0
        return np.asarray(np.linalg.solve(self._normal + trust, self._sums + trust[:, 1:])[0])
