"""Motion of a target along a path on the skin: at a set speed, waiting for the contact, over crossings to other places.

An object on the border of two patches is read by both: ``over_borders`` merges the two regions into one contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.control.path_following.surface_path import PathCrossing, SurfacePath, project_path
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.paths import NEAR_PITCHES, MapPath

WIDE = 3.0
"""Largest distance, in pitches, of contacts on two patches that count as one."""


def across_borders(now: TaskTick, region: ContactRegion) -> list[ContactRegion]:
    """Return the other contacts on other patches near a contact, which count as one with it; see ``over_borders``."""
    others = [other for other in now.regions if other.at.patch != region.at.patch]
    if not others:
        return []
    pose = now.configuration.pose
    here = pose(region.link).points(region.link_position)
    reach = WIDE * now.map_kinematics.pitch
    return [other for other in others if length(pose(other.link).points(other.link_position) - here) < reach]


def over_borders(now: TaskTick, region: ContactRegion) -> ContactRegion:
    """Return the contact merged with contacts next to it on other patches: their total force, at their common centre.

    With a goal on one patch alone, an object that moves across would be pressed more and more by the other patch. The
    centre on one patch alone is never on the border, so the object would be moved back from there.

    Args:
        now: Inputs of the tick; the kind of Jacobian extrapolates the centre beyond the patch's border.
        region: Contact on one patch.
    """
    others = across_borders(now, region)
    if not others:
        return region
    configuration = now.configuration
    pose = configuration.pose(region.link)
    here = pose.points(region.link_position)
    places = [configuration.pose(other.link).points(other.link_position) for other in others]
    force = region.force + sum(other.force for other in others)
    moments = (other.force * (place - here) for other, place in zip(others, places, strict=True))
    shift = sum(moments, np.zeros(3)) / max(force, 1e-9)
    along = now.map_kinematics.jacobian(region.at, now.settings.jacobian, configuration) @ shift
    inverse = pose.rotation.T
    return replace(
        region, force=force, map_point=region.map_point + along, link_position=region.link_position + inverse @ shift
    )


LAG = 0.01
"""Distance on the body from which a path waits for a contact that lags [m]."""
_SLOWS = 0.25
"""Last share of that distance over which the path slows down."""
_JUST = 1e-9
"""Distance from a crossing [m]."""


class PathFollower:
    """Progress of the target along the path. Mutable; ``reset`` discards the path.

    The speed is that on the map: in a patch drawn twice as large the contact moves half as fast on the body.

    Attributes:
        way: Distance covered along the path [m].
        piece: Number of the part, between two crossings, that contains the target.
        laid_at: (2,) place on the map about which a default path is centred [m]; None for a drawn path.
        target: Desired place of the contact; None without a path.
        behind: Distance of the contact from it, on the body [m].
        problem: Problem of the path; None without one.
        leads_over: Whether the contact moves over a crossing to a nearby place.
        blocked: Reason why the contact cannot pass the next crossing; None if it can.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard the path."""
        self.way = 0.0
        self.piece = 0
        self.behind = 0.0
        self.laid_at: tuple[float, float] | None = None
        self.target: SurfacePoint | None = None
        self.problem: Limit | None = None
        self.blocked: Limit | None = None
        self._key: object = None
        self._path: SurfacePath | None = None
        self._back = self.leads_over = False

    def lay(self, now: TaskTick, region: ContactRegion) -> bool:
        """Project the path if it or the map is new; return whether it was.

        The points of a drawn path are on the map: an edit of the map that moves the path's patches comes with changed
        points (``PathOnBody``). A path that was being followed continues at its nearest point; a default path is
        centred at the contact again.
        """
        settings = now.settings
        map_kinematics = now.map_kinematics
        key = (settings.path, settings.path_kind, settings.path_size, map_kinematics)
        if key == self._key:
            return False
        again = self._path is not None
        self._key = key
        self.blocked = None
        self._back = False
        self.laid_at = None if settings.path else (float(region.map_point[0]), float(region.map_point[1]))
        try:
            laid = project_path(settings, region.map_point, map_kinematics.transitions)
            self.problem = None if laid.whole else Limit(LimitKind.PATH_LEAVES_SKIN)
        except MapError as error:
            laid = SurfacePath(MapPath(map_kinematics.map.to_map(region.at)), map_kinematics.transitions)
            self.problem = Limit(LimitKind.PATH_REFUSED, detail=error.problem)
        self._path = laid
        self.go_to(laid.nearest(region.at) or 0.0 if again and settings.path else 0.0)
        return True

    def join(self, now: TaskTick, region: ContactRegion) -> None:
        """Continue with a new contact: if it is far away on another patch, at the path's nearest point there."""
        self.blocked = None
        if self._path is None or self.target is None or self.target.patch == region.at.patch:
            return
        if now.map_kinematics.away(self.target, region, now.configuration) < WIDE * now.map_kinematics.pitch:
            return  # the same object on both sides of a border
        nearest = self._path.nearest(region.at)
        self.go_to(self.way if nearest is None else nearest)

    def walk(self, now: TaskTick, region: ContactRegion) -> tuple[FloatArray, PathCrossing | None]:
        """Move the target: round and round if the path is closed, else back and forth.

        Args:
            now: Inputs of the tick.
            region: The contact.

        Returns:
            Its velocity (2,) on the map [m/s], and a crossing if the contact must regrasp before the target continues.
        """
        path = self._path
        assert path is not None
        map_kinematics = now.map_kinematics
        far = NEAR_PITCHES * map_kinematics.pitch
        still = np.zeros(2)
        if self.blocked is not None:
            return still, None
        self.target, direction = path.at(self.way)
        self.behind = map_kinematics.away(self.target, region, now.configuration)
        self.leads_over &= self.behind > (1 - _SLOWS) * LAG
        if self.behind > LAG:
            crosses = self.target.patch != region.at.patch and self.behind > far
            return still, PathCrossing(self.way, region.at, self.target) if crosses else None
        if path.length < 1e-6:
            return still, None
        speed = now.settings.path_speed * min((LAG - self.behind) / (_SLOWS * LAG), 1.0)
        way, crossing = self._next(path, speed * now.dt)
        if crossing is not None and map_kinematics.apart(crossing.leaves, crossing.enters, now.configuration) > far:
            return still, crossing
        self.leads_over |= crossing is not None
        self.way = way
        self.piece = path.piece(way)
        return direction * (-speed if self._back else speed), None

    @property
    def waits(self) -> bool:
        """Whether the path waits for the contact, or almost."""
        return self.blocked is None and self.behind > (1 - _SLOWS / 2) * LAG

    def stay(self, why: Limit, at: SurfacePoint) -> None:
        """Hold the contact ``at`` a place, because it cannot pass, until there is another contact or path."""
        self.blocked = why
        self.target = at

    def there(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        """Return the strongest contact on the patch to which the path leads."""
        return next((r for r in regions if self.target is not None and r.at.patch == self.target.patch), None)

    def go_to(self, way: float) -> None:
        """Continue at this distance along the path [m]."""
        self.leads_over = False
        assert self._path is not None
        self.way = way
        self.piece = self._path.piece(way)
        self.target, _ = self._path.at(way)

    def _next(self, path: SurfacePath, step: float) -> tuple[float, PathCrossing | None]:
        """Return the distance after a step, and the crossing on it, in the direction of motion."""
        way = self.way + (-step if self._back else step)
        if path.closed:
            round_ = way % path.length
            if round_ != way:
                return round_, None
        elif not 0 <= way < path.length:
            self._back = way > 0
            return min(max(way, 0.0), path.length * (1 - 1e-9)), None
        before = path.piece(self.way)
        after = path.piece(way)
        if before == after:
            return way, None
        crossing = path.crossings[before - 1 if self._back else before]
        if self._back:
            crossing = PathCrossing(crossing.way - _JUST, crossing.enters, crossing.leaves)
        return crossing.way, crossing
