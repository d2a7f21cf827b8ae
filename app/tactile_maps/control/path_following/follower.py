"""Leads a target along a path on the skin: at a set speed, waiting for the contact, over crossings to other places.

An object on the border of two patches is felt by both: ``over_borders`` makes the two regions one contact again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.path_following.surface_path import PathCrossing, SurfacePath, project_path
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.jacobian import JacobianKind
from tactile_maps.maps.paths import NEAR_PITCHES, MapPath
from tactile_maps.robots.kinematics import Configuration

WIDE = 3.0
"""Contacts on two patches no more than so many pitches apart are one."""


def across_borders(
    region: ContactRegion, regions: Sequence[ContactRegion], sight: MapKinematics, configuration: Configuration
) -> list[ContactRegion]:
    """Return the other contacts on other patches near a contact, which count as one with it; see ``over_borders``."""
    others = [other for other in regions if other.at.patch != region.at.patch]
    if not others:
        return []
    here = configuration.pose(region.link).points(region.link_position)
    reach = WIDE * sight.pitch
    return [
        other for other in others if length(configuration.pose(other.link).points(other.link_position) - here) < reach
    ]


def over_borders(
    region: ContactRegion,
    regions: Sequence[ContactRegion],
    sight: MapKinematics,
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
    others = across_borders(region, regions, sight, configuration)
    if not others:
        return region
    pose = configuration.pose(region.link)
    here = pose.points(region.link_position)
    beside = [(other, configuration.pose(other.link).points(other.link_position)) for other in others]
    force = region.force + sum(other.force for other, _ in beside)
    shift = sum((other.force * (place - here) for other, place in beside), np.zeros(3)) / max(force, 1e-9)
    along = sight.jacobian(region.at, jacobian, configuration) @ shift
    inverse = pose.rotation.T
    return replace(
        region, force=force, map_point=region.map_point + along, link_position=region.link_position + inverse @ shift
    )


LAG = 0.01
"""A path waits for a contact that is farther behind, on the body [m]."""
_SLOWS = 0.25
"""It slows down over this last share of that."""
_JUST = 1e-9
"""Before a crossing [m]."""


class PathFollower:
    """How far along the path the target is. Mutable; ``reset`` forgets the path.

    The speed is that on the map: in a patch drawn twice as large the contact goes half as fast on the body.

    Attributes:
        way: Walked along the path [m].
        piece: Number of the part, between two crossings, where the target is.
        laid_at: (2,) the place on the map about which a path lies that nobody drew [m]; None for no such path.
        target: Where the contact is wanted; None until there is a path.
        behind: How far the contact is from there, on the body [m].
        problem: What is wrong with the path; None where nothing is.
        leads_over: Whether the contact is on its way over a crossing to a place that is near.
        blocked: Why the contact cannot be taken over the next crossing; None while it can.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No path."""
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

    def lay(self, settings: ControlSettings, region: ContactRegion, sight: MapKinematics) -> bool:
        """Lay the path if it is new, or the map is; true then.

        What was drawn stays where it was drawn on the map when patches under it are moved. A path that was being
        followed goes on where it is nearest; one that nobody drew is laid about the contact again.
        """
        key = (settings.path, settings.path_kind, settings.path_size, sight)
        if key == self._key:
            return False
        again = self._path is not None
        self._key = key
        self.blocked = None
        self._back = False
        self.laid_at = None if settings.path else (float(region.map_point[0]), float(region.map_point[1]))
        try:
            laid = project_path(settings, region.map_point, sight.transitions)
            self.problem = None if laid.whole else Limit(LimitKind.PATH_LEAVES_SKIN)
        except MapError as error:
            laid = SurfacePath(MapPath(sight.map.to_map(region.at)), sight.transitions)
            self.problem = Limit(LimitKind.PATH_REFUSED, detail=error.problem)
        self._path = laid
        self.go_to(laid.nearest(region.at) or 0.0 if again and settings.path else 0.0)
        return True

    def join(self, region: ContactRegion, sight: MapKinematics, configuration: Configuration) -> None:
        """Go on with a new contact; in another patch, far away, where the path is nearest if it is there at all."""
        self.blocked = None
        if self._path is None or self.target is None or self.target.patch == region.at.patch:
            return
        if sight.away(self.target, region, configuration) < WIDE * sight.pitch:
            return  # the same over a border
        nearest = self._path.nearest(region.at)
        self.go_to(self.way if nearest is None else nearest)

    def walk(
        self,
        settings: ControlSettings,
        region: ContactRegion,
        sight: MapKinematics,
        configuration: Configuration,
        dt: float,
    ) -> tuple[FloatArray, PathCrossing | None]:
        """Take the target on: round and round where the path is closed, else to and fro.

        Args:
            settings: How fast.
            region: The contact.
            sight: Of the map.
            configuration: At the present posture.
            dt: Since the last tick [s].

        Returns:
            Its velocity (2,) on the map [m/s], and where the contact has to be taken over elsewhere before it goes on:
            from where to where, and the way from which it then goes on.
        """
        path = self._path
        assert path is not None
        still = np.zeros(2)
        if self.blocked is not None:
            return still, None
        self.target, direction = path.at(self.way)
        self.behind = sight.away(self.target, region, configuration)
        self.leads_over &= self.behind > (1 - _SLOWS) * LAG
        if self.behind > LAG:
            far = self.target.patch != region.at.patch and self.behind > NEAR_PITCHES * sight.pitch
            return still, PathCrossing(self.way, region.at, self.target) if far else None
        if path.length < 1e-6:
            return still, None
        speed = settings.path_speed * min((LAG - self.behind) / (_SLOWS * LAG), 1.0)
        way, crossing = self._next(path, speed * dt)
        if (
            crossing is not None
            and sight.apart(crossing.leaves, crossing.enters, configuration) > NEAR_PITCHES * sight.pitch
        ):
            return still, crossing
        self.leads_over |= crossing is not None
        self.way = way
        self.piece = path.piece(way)
        return direction * (-speed if self._back else speed), None

    @property
    def waits(self) -> bool:
        """Whether the path waits for the contact, or all but."""
        return self.blocked is None and self.behind > (1 - _SLOWS / 2) * LAG

    def stay(self, why: Limit, at: SurfacePoint) -> None:
        """The contact cannot be taken over, so it is held ``at`` a place until another comes, or another path."""
        self.blocked = why
        self.target = at

    def there(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        """The strongest contact on the patch to which the path leads."""
        return next((r for r in regions if self.target is not None and r.at.patch == self.target.patch), None)

    def go_to(self, way: float) -> None:
        """Go on from ``way`` metres along the path."""
        self.leads_over = False
        assert self._path is not None
        self.way = way
        self.piece = self._path.piece(way)
        self.target, _ = self._path.at(way)

    def _next(self, path: SurfacePath, step: float) -> tuple[float, PathCrossing | None]:
        """The way after a step, and the crossing on it, in the direction in which it is walked."""
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
