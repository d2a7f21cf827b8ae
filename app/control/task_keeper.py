"""What the chosen task wants of the contacts, tick by tick.

``keep_force`` keeps the strongest contact at the force goal and lets it slide. ``hold_point`` also keeps it at a place
of the skin: the first point of the path, or where it began. ``follow_path`` leads it along the path with the force.
``balance`` moves until all contacts press alike; a single one is kept at the goal. ``retreat`` goes away from whatever
touches, and stays away. ``guide`` follows a hand in all directions, and stays where the hand leaves it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings
from app.control.map_path import LaidPath, MapPath, draw_path, path_about
from app.control.map_sight import MapSight
from app.control.task_contact import Want
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration

SEARCH_TIME = 0.4
"""How long a lost contact is looked for along its normal [s]."""
LAG = 0.01
"""A path waits for a contact that is farther behind [m]."""
MOST_ERROR = 0.02
"""Of the map error that laws are given [m]: far goals are approached at this one's speed."""


class TaskKeeper:
    """Remembers which contact a task is about, where it began and how far along the path it is. Mutable.

    Attributes:
        way, target, error, force_goal, laid_at: As ``TaskReport`` has them.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No contact, at the start of the path."""
        self.way = 0.0
        self.target: SurfacePoint | None = None
        self.error: float | None = None
        self.force_goal: float | None = None
        self.laid_at: tuple[float, float] | None = None
        self._key: object = None
        self._path: LaidPath | None = None
        self._back = False
        self._last: ContactRegion | None = None
        self._searching = 0.0
        self._problem = ""

    def let_go(self) -> None:
        """Forget the contact, as if it had not been; the path goes on from where it is."""
        self._last = None

    def wants(
        self,
        settings: ControlSettings,
        regions: Sequence[ContactRegion],
        sight: MapSight,
        configuration: Configuration,
        dt: float,
        limits: list[str],
    ) -> list[Want]:
        """What is wanted now, of the contact the task is about first; nothing when nothing touches.

        Args:
            settings: Which task; another task or path starts it afresh, and another map what is drawn on it.
            regions: The strongest first.
            sight: Of the map.
            configuration: At the present posture.
            dt: Since the last tick [s].
            limits: Told what holds the task up.
        """
        self._start_if_new(settings, sight)
        self.error = None
        wants = self._wants(settings, regions, sight, configuration, dt, limits)
        self.force_goal = wants[0].force if wants else None
        return wants

    def _wants(
        self,
        settings: ControlSettings,
        regions: Sequence[ContactRegion],
        sight: MapSight,
        configuration: Configuration,
        dt: float,
        limits: list[str],
    ) -> list[Want]:
        region = self._contact(regions)
        if region is None:
            return self._search(settings, dt, limits)
        new = self._last is None or self._last.id != region.id
        self._last, self._searching = region, 0.0
        if settings.task == "balance":
            return _balanced(settings, regions)
        if settings.task == "retreat":
            return [Want(one, 0.0) for one in regions]
        if settings.task == "keep_force":
            return [Want(region, settings.force_goal)]
        return [self._at_a_place(settings, region, sight, configuration, dt, limits, new)]

    def _start_if_new(self, settings: ControlSettings, sight: MapSight) -> None:
        drawn = sight if settings.path or settings.task == "follow_path" else None  # a place is the same on every map
        key = (settings.task, settings.path, settings.path_kind, settings.path_size, drawn)
        if key != self._key:
            self.reset()
            self._key = key

    def _contact(self, regions: Sequence[ContactRegion]) -> ContactRegion | None:
        """The contact known from before, else the strongest."""
        known = self._last.id if self._last is not None else 0
        return next((region for region in regions if region.id == known), regions[0] if regions else None)

    def _search(self, settings: ControlSettings, dt: float, limits: list[str]) -> list[Want]:
        """A contact just lost is sought for a while, as one without force; not by tasks that yield."""
        if self._last is None:
            return []
        self._searching += dt
        if settings.task in ("retreat", "guide", "balance") or self._searching > SEARCH_TIME or not settings.force_goal:
            self._last = None
            self.target = None if settings.task in ("hold_point", "guide") else self.target
            return []
        limits.append("contact lost")
        return [Want(replace(self._last, id=-self._last.id, force=0.0), settings.force_goal)]

    def _at_a_place(
        self,
        settings: ControlSettings,
        region: ContactRegion,
        sight: MapSight,
        configuration: Configuration,
        dt: float,
        limits: list[str],
        new: bool,
    ) -> Want:
        jacobian = sight.jacobian(region.at, settings.jacobian, configuration)
        velocity = np.zeros(2)
        if settings.task == "follow_path":
            velocity = self._walk(settings, region, sight, configuration, jacobian, dt, limits)
        elif self.target is None or (new and settings.task == "guide"):
            drawn = sight.map.to_body(np.array(settings.path[0])) if settings.path else region.at
            self.target = region.at if drawn is None or settings.task == "guide" else drawn
            self._problem = "the point to hold is not on the skin" if drawn is None else ""
        limits += [self._problem] if self._problem else []
        assert self.target is not None
        error = sight.error(self.target, region, jacobian, configuration)
        self.error = float(np.linalg.norm(error))
        return Want(region, settings.force_goal, _bounded(error, MOST_ERROR), velocity)

    def _walk(
        self,
        settings: ControlSettings,
        region: ContactRegion,
        sight: MapSight,
        configuration: Configuration,
        jacobian: FloatArray,
        dt: float,
        limits: list[str],
    ) -> FloatArray:
        """Take the target on along the path: round and round when closed, else to and fro; its velocity (2,)."""
        if self._path is None:
            self._path, self._problem = _lay(settings, region, sight)
            self.laid_at = None if settings.path else (float(region.map_point[0]), float(region.map_point[1]))
        path = self._path
        self.target, direction = path.at(self.way)
        behind = float(np.linalg.norm(sight.error(self.target, region, jacobian, configuration)))
        if behind > LAG:
            limits.append("the path waits for the contact")
            return np.zeros(2)
        if path.length < 1e-6:
            return np.zeros(2)
        way = self.way + (-dt if self._back else dt) * settings.path_speed
        if path.closed:
            way %= path.length
        elif not 0 <= way < path.length:
            self._back = way > 0
            way = min(max(way, 0.0), path.length * (1 - 1e-9))
        self.way = way
        return direction * (-settings.path_speed if self._back else settings.path_speed)


def _lay(settings: ControlSettings, region: ContactRegion, sight: MapSight) -> tuple[LaidPath, str]:
    """The path on the skin, and what is wrong with it: where it cannot lie, the contact stays where it is."""
    try:
        if len(settings.path) > 1:
            path = draw_path(settings.path_kind, settings.path)
        else:
            centre = np.array(settings.path[0]) if settings.path else region.map_point
            path = path_about(settings.path_kind, centre, settings.path_size)
        laid = LaidPath(path, sight.gluing)
        return laid, "" if laid.whole else "the path leaves the skin"
    except MapError as error:
        here = MapPath(sight.map.to_map(region.at))
        return LaidPath(here, sight.gluing), error.problem


def _balanced(settings: ControlSettings, regions: Sequence[ContactRegion]) -> list[Want]:
    goal = settings.force_goal if len(regions) == 1 else float(np.mean([region.force for region in regions]))
    return [Want(region, goal) for region in regions]


def _bounded(error: FloatArray, most: float) -> FloatArray:
    length = float(np.linalg.norm(error))
    return error * (most / length) if length > most else error
