"""Puts together what a law's task looks like, once for both views, from settings, frames and the map; without Qt."""

from __future__ import annotations

import numpy as np

from app.control.command import ControlSettings
from app.control.laid_path import wanted_path
from app.control.laws import RULES
from app.control.report import TaskReport
from app.geometry.surface_point import SurfacePoint
from app.maps.glue import Gluing
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from widgets.task_shown import NO_PATH, NO_TASK, TaskShown, WantedPath, lines_on_skin
from widgets.trail import Trail


class TaskSight:
    """Mutable; ``show_map`` with another skin, and ``reset``, forget what was.

    Attributes:
        shown: The very same object as long as nothing changes.
    """

    def __init__(self) -> None:
        self.shown = NO_TASK
        self._settings, self._report = ControlSettings(), TaskReport()
        self._map: TactileMap | None = None
        self._gluing: Gluing | None = None  # made when a path first asks
        self._trail, self._led = Trail(), True
        self._key: object = None
        self._path = NO_PATH

    def show_map(self, map_: TactileMap, *, led: bool = True) -> None:
        """Another map; ``led`` where the arm is led by it, else it has no path. Cost: that of laying the path on it."""
        if self._map is None or map_.skin is not self._map.skin:
            self._trail.reset()
            self._report = TaskReport()
        elif map_ is not self._map:
            self._trail.show_map(map_)
        if map_ is not self._map:
            self._map, self._gluing = map_, None
        self._led = led
        self._put_together()

    def show_settings(self, settings: ControlSettings) -> None:
        """These are in force; a frame that knows of them may still be to come, as while time stands still."""
        if _wanted(settings) != _wanted(self._settings):
            self._report = TaskReport()
        self._settings = settings
        self._put_together()

    def show_frame(self, frame: Frame) -> None:
        """Another instant. Cost: 50 µs while the contact moves."""
        self._report = frame.task or TaskReport()
        if self._map is not None and self._settings.law in RULES:
            self._trail.follow(frame.time, frame.regions, self._map)
        else:
            self._trail.reset()
        self._put_together()

    def _put_together(self) -> None:
        settings, report, map_ = self._settings, self._report, self._map
        if map_ is None or settings.law not in RULES:
            self._key, self._path, self.shown = None, NO_PATH, NO_TASK
            return
        key = (map_, self._led, _wanted(settings), report.laid_at)
        if key != self._key:
            self._key, self._path = key, self._lay(map_)
        now = TaskShown(self._path, self._target(map_), report.force_goal, self._trail.contact, self._trail.tail)
        if not now.looks_like(self.shown):
            self.shown = now

    def _lay(self, map_: TactileMap) -> WantedPath:
        """The wanted path as it lies on the skin; nothing where there is none, or none can be."""
        if self._settings.task != "follow_path" or not self._led:
            return NO_PATH
        if self._gluing is None:
            self._gluing = Gluing(map_)
        path = wanted_path(self._settings, self._report, self._gluing)
        if path is None:
            return NO_PATH
        ends = [[map_.to_map(crossing.leaves), map_.to_map(crossing.enters)] for crossing in path.crossings]
        lines = tuple(line for part in path.points_on_map for line in lines_on_skin(part, map_))
        return WantedPath(lines, np.array(ends).reshape(-1, 2, 2))

    def _target(self, map_: TactileMap) -> SurfacePoint | None:
        """Where the task says; before it has said so, where it will begin."""
        settings = self._settings
        if settings.task == "hold_point" and settings.path and self._led:
            return map_.to_body(np.array(settings.path[0]))
        if self._report.target is not None or settings.task != "follow_path" or not self._path:
            return self._report.target
        return map_.to_body(self._path.lines[0].on_map[0])


def _wanted(settings: ControlSettings) -> object:
    """What the place of path and target depends on."""
    return settings.law in RULES, settings.task, settings.path_kind, settings.path, settings.path_size
