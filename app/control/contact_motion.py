"""The controller a session asks: the selected law, with settings that may change at any time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.law import Law
from app.control.laws import build_law
from app.control.loop_watch import LoopWatch
from app.control.map_sight import MapSight
from app.control.report import TaskReport
from app.control.settings_check import RANGES, check_settings, settings_from
from app.control.skin_readings import PLATEAU, SkinReadings, at_least
from app.control.swing_watch import SWINGS, SwingWatch
from app.control.task_keeper import TaskKeeper
from app.control.task_law import TaskLaw
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.robots.robot import Robot

__all__ = ["RANGES", "ContactMotionController", "check_settings", "settings_from"]

_NOWHERE = np.full(3, np.nan)
_UNREAD = ContactRegion(
    id=0, taxels=np.zeros(0, dtype=np.int64), force=np.nan, area=0.0, peak=np.nan, map_point=_NOWHERE[:2],
    at=SurfacePoint(0, 0, (1.0, 0.0, 0.0)), link="", point=_NOWHERE, normal=_NOWHERE,
)  # fmt: skip
"""What laws are given where the skin cannot be read: none goes on with a force that is no number."""
BLEND_TIME = 0.2
"""Time constant with which what is left of another law's torque fades [s]."""


class ContactMotionController:
    """Turns posture and contact regions into joint commands. Mutable; ``reset`` forgets the past.

    Laws change without a jump: the new one starts as near as it can to the torque asked for, and the rest of the
    difference fades.

    Args:
        robot: Whose joints.
        settings: May be replaced at any time.
        map_: Of the skin; ``use`` takes another.

    Raises:
        SceneError: A setting is out of range; the last good ones stay.
    """

    def __init__(self, robot: Robot, settings: ControlSettings, map_: TactileMap) -> None:
        self._robot, self._rest, self._sight = robot, robot.home, MapSight(map_)
        self._keeper = TaskKeeper(robot)
        self._laws: dict[str, Law] = {}
        self._loop, self._swing = LoopWatch(robot), SwingWatch()
        self._beyond: tuple[str, ...] = ()
        self._settings = check_settings(settings)
        self._last: JointCommand | None = None
        self._fading: FloatArray | None = None
        self._switched = False

    @property
    def settings(self) -> ControlSettings:
        """The settings in force."""
        return self._settings

    @settings.setter
    def settings(self, settings: ControlSettings) -> None:
        check_settings(settings)
        self._switched = self._switched or settings.law != self._settings.law
        self._settings = settings

    @property
    def rest(self) -> FloatArray:
        """(n,) the posture kept while nothing touches; the robot's home until it is set. A reset keeps it."""
        return self._rest

    @rest.setter
    def rest(self, posture: FloatArray) -> None:
        self._rest = posture
        for law in self._laws.values():
            law.rest = posture

    @property
    def why_limited(self) -> tuple[str, ...]:
        """What bounds the answer now, in words, and what of the settings the skin cannot hold; empty for nothing."""
        return (*self._law.why_limited, *self._beyond)

    @property
    def readings(self) -> SkinReadings | None:
        """What is known of the skin's readings; None for nothing."""
        return self._loop.readings

    @readings.setter
    def readings(self, readings: SkinReadings | None) -> None:
        self._loop.readings = readings

    @property
    def report(self) -> TaskReport | None:
        """How the task goes; None for a law without one."""
        return self._law.report if isinstance(self._law, TaskLaw) else None

    def use(self, map_: TactileMap) -> None:
        """Take another map of the same skin from now on; a path starts afresh."""
        self._sight = MapSight(map_)
        for law in self._laws.values():
            if isinstance(law, TaskLaw):
                law.sight = self._sight

    def reset(self) -> None:
        """Forget the past; keep the settings."""
        self._keeper.reset()
        self._swing.reset()
        self._loop.reset()
        self._last, self._fading, self._switched, self._beyond = None, None, False, ()
        for law in self._laws.values():
            law.reset()

    def command(
        self,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
        *,
        readable: bool = True,
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds.

        Args:
            posture: (n,) found.
            velocity: (n,) found.
            regions: All contacts, the strongest first.
            dt: [s].
            readable: Whether all taxels read numbers. If not, what presses there is not known, and might be taken for a
                contact that was lost: laws that read contacts stand still.
        """
        before = self._last.torque_at(posture, velocity) if self._switched and self._last is not None else None
        if before is not None:
            self._law.start(posture, before)
        self._switched = False
        settings, read = self._heed(posture, regions, dt) if readable else (self._settings, (_UNREAD,))
        command = self._law.command(settings, posture, velocity, read, dt)
        if before is not None:
            self._fading = before - command.torque_at(posture, velocity)
        if self._fading is not None:
            command = replace(command, torque=command.torque + self._fading)
            self._fading = self._fading * np.exp(-dt / BLEND_TIME)
            self._fading = self._fading if np.abs(self._fading).max(initial=0.0) > 1e-6 else None
        self._last = command
        return command

    def _heed(
        self, posture: FloatArray, regions: Sequence[ContactRegion], dt: float
    ) -> tuple[ControlSettings, tuple[ContactRegion, ...]]:
        """Settings and regions as laws may take them; what is to be said of the skin's limits is kept."""
        settings, read, said = self._settings, tuple(regions), list[str]()
        if settings.law != "impedance":
            goal = settings.force_goal
            if self.readings is not None:
                read, plateau = at_least(regions, goal, self.readings.highest)
                said += [PLATEAU] if plateau else []
            settings, limits = self._loop.heed(settings, posture, regions)
            said += limits
            said += [SWINGS] if self._swing.look(goal, regions[0].force if regions else 0.0, dt) else []
        self._beyond = tuple(said)
        return settings, read

    @property
    def _law(self) -> Law:
        """The law in force, built when it is first wanted."""
        name = self._settings.law
        if name not in self._laws:
            self._laws[name] = build_law(name, self._robot, self._keeper, self._sight)
            self._laws[name].rest = self._rest
        return self._laws[name]
