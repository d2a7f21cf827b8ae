"""Builds the overlay of a controller's task for both views from settings, ticks and the map; without Qt.

``TrailRecorder`` records the recent path of the task's contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.controller_registry import has_task
from tactile_maps.control.motion.command import ControlSettings, TaskReport
from tactile_maps.control.path_following.surface_path import active_path
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap
from tactile_maps.session.frame import Frame
from tactile_widgets.views.overlays.task_overlay import (
    NO_PATH,
    NO_TASK,
    TRAIL_SECONDS,
    ContactTrail,
    ReferencePath,
    TaskOverlay,
    lines_on_skin,
)

_STEP = 0.0005
"""Distance below which locations count as one [m]."""
_NEAR = 0.002
"""Distance on the body added before the test for a seam, because of rounding [m]."""
_GAP = 0.5
"""Interval between two frames from which it counts as a jump in a replay [s]."""


class TrailRecorder:
    """Records the path of one contact.

    Attributes:
        contact: Id of the recorded region; 0 for none.
        tail: Recorded path; the same object as long as nothing changes.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Discard the path."""
        self._ats: list[SurfacePoint] = []
        self._times: FloatArray = np.zeros(0)
        self._time = -np.inf
        self.contact = 0
        self.tail = ContactTrail()

    def show_map(self, map_: TactileMap) -> None:
        """Convert the path to another map. Cost: 20 µs per location."""
        if self._ats:
            tail = self.tail
            on_map = np.array([map_.to_map(at) for at in self._ats])
            self.tail = replace(tail, on_map=on_map, starts=tail.starts | _torn(tail.patch, on_map, tail.on_body))

    def follow(self, time: float, regions: Sequence[ContactRegion], map_: TactileMap) -> None:
        """Record another instant: follow the previous contact, or else the strongest one.

        Args:
            time: Simulation time [s]; a step back or far forward discards the path.
            regions: Contact regions, strongest first.
            map_: Map that is shown.

        Cost: 60 µs while the contact moves.
        """
        if not self._time <= time <= self._time + _GAP:
            self.reset()
        self._time = time
        region = next((one for one in regions if one.id == self.contact), regions[0] if regions else None)
        new = region is not None and region.id != self.contact
        self.contact = 0 if region is None else region.id
        if region is not None and (new or not self._rests(region)):
            self._take(region, map_, new=new)
        elif region is not None:
            self._times = np.append(self._times[:-1], time)  # still the same location
        self._age()

    def _rests(self, region: ContactRegion) -> bool:
        if not self._ats or self._ats[-1].patch != region.at.patch:
            return False
        return bool(np.linalg.norm(region.link_position - self.tail.on_body[-1]) < _STEP)

    def _take(self, region: ContactRegion, map_: TactileMap, *, new: bool) -> None:
        self._ats.append(region.at)
        self._times = np.append(self._times, self._time)
        old = self.tail
        patch = np.append(old.patch, region.at.patch)
        on_map = np.vstack([old.on_map, map_.to_map(region.at)])
        on_body = np.vstack([old.on_body, region.link_position])
        starts = np.append(old.starts, new) | _torn(patch, on_map, on_body)
        self.tail = ContactTrail(
            patch, on_map, on_body, np.vstack([old.normals, region.link_normal]), np.append(old.age, 0), starts
        )

    def _age(self) -> None:
        """Discard old locations and update the ages."""
        gone = int(np.searchsorted(self._times, self._time - TRAIL_SECONDS))
        if gone:
            self._ats = self._ats[gone:]
            self._times = self._times[gone:]
            self.tail = self.tail.without_oldest(gone)
        if len(self._ats) > 1:
            self.tail = replace(self.tail, age=(self._time - self._times) / TRAIL_SECONDS)


def _torn(patch: IntArray, on_map: FloatArray, on_body: FloatArray) -> BoolArray:
    """(k,) whether the step to each location is not a line on the map; False for the first location."""
    steps, apart = (np.linalg.norm(np.diff(places, axis=0), axis=1) for places in (on_map, on_body))
    torn = (np.diff(patch) != 0) | (steps > SEAM_RATIO * (apart + _NEAR))
    return np.concatenate([np.zeros(min(len(patch), 1), bool), torn])


class TaskOverlayBuilder:
    """Builds the task overlay; another skin discards the contact path.

    Attributes:
        shown: Current overlay; the same object as long as nothing changes.
    """

    def __init__(self) -> None:
        self.shown = NO_TASK
        self._settings = ControlSettings()
        self._report = TaskReport()
        self._map: TactileMap | None = None
        self._transitions: SeamTransitions | None = None  # made when a path first needs them
        self._trail = TrailRecorder()
        self._led = True
        self._key: object = None
        self._path = NO_PATH

    def show_map(self, map_: TactileMap, *, led: bool = True) -> None:
        """Use another map; without ``led`` the controller does not use it. Cost: that of the path."""
        if self._map is None or map_.skin is not self._map.skin:
            self._trail.reset()
            self._report = TaskReport()
        elif map_ is not self._map:
            self._trail.show_map(map_)
        if map_ is not self._map:
            self._map = map_
            self._transitions = None
        self._led = led
        self._update()

    def show_settings(self, settings: ControlSettings) -> None:
        """Use other settings, perhaps before the first frame that depends on them, as in a paused session."""
        if _path_settings(settings) != _path_settings(self._settings):
            self._report = TaskReport()
        self._settings = settings
        self._update()

    def show_frame(self, frame: Frame) -> None:
        """Use another frame. Cost: 50 µs while the contact moves."""
        self._report = frame.task or TaskReport()
        if self._map is not None and has_task(self._settings.controller):
            self._trail.follow(frame.time, frame.regions, self._map)
        else:
            self._trail.reset()
        self._update()

    def _update(self) -> None:
        settings = self._settings
        report = self._report
        map_ = self._map
        if map_ is None or not has_task(settings.controller):
            self._key = None
            self._path = NO_PATH
            self.shown = NO_TASK
            return
        key = (map_, self._led, _path_settings(settings), report.laid_at)
        if key != self._key:
            self._key = key
            self._path = self._path_on(map_)
        target = self._target(map_)
        trail = self._trail
        now = TaskOverlay(self._path, target, report.force_goal, trail.contact, trail.tail, report.controlled)
        if not now.looks_like(self.shown):
            self.shown = now

    def _path_on(self, map_: TactileMap) -> ReferencePath:
        """Reference path on the skin; empty without one."""
        if self._settings.task != "follow_path" or not self._led:
            return NO_PATH
        if self._transitions is None:
            self._transitions = SeamTransitions(map_)
        path = active_path(self._settings, self._report, self._transitions)
        if path is None:
            return NO_PATH
        ends = [place for crossing in path.crossings for place in (crossing.leaves, crossing.enters)]
        on_map = np.array([map_.to_map(place) for place in ends]).reshape(-1, 2, 2)
        crossed = np.array([place.patch for place in ends], np.int64).reshape(-1, 2)
        lines = tuple(line for part in path.points_on_map for line in lines_on_skin(part, map_))
        return ReferencePath(lines, on_map, crossed)

    def _target(self, map_: TactileMap) -> SurfacePoint | None:
        """Target of the task; before its first report, the start of the path."""
        settings = self._settings
        if settings.task == "hold_point" and settings.path and self._led:
            return map_.to_body(np.array(settings.path[0]))
        if self._report.target is not None or settings.task != "follow_path" or not self._path:
            return self._report.target
        return map_.to_body(self._path.lines[0].on_map[0])


def _path_settings(settings: ControlSettings) -> object:
    """Settings that determine path and target."""
    return has_task(settings.controller), settings.task, settings.path_kind, settings.path, settings.path_size
