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
from app.control.map_sight import MapSight
from app.control.report import TaskReport
from app.control.settings_check import RANGES, check_settings, settings_from
from app.control.task_keeper import TaskKeeper
from app.control.task_law import TaskLaw
from app.maps.tactile_map import TactileMap
from app.robots.robot import Robot

__all__ = ["RANGES", "ContactMotionController", "check_settings", "settings_from"]

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
        self._keeper = TaskKeeper()
        self._laws: dict[str, Law] = {}
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
        """What bounds the answer now, in words; empty when nothing does."""
        return self._law.why_limited

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
        self._last, self._fading, self._switched = None, None, False
        for law in self._laws.values():
            law.reset()

    def command(
        self, posture: FloatArray, velocity: FloatArray, regions: Sequence[ContactRegion], dt: float
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds; the regions come strongest first."""
        before = self._last.torque_at(posture, velocity) if self._switched and self._last is not None else None
        if before is not None:
            self._law.start(posture, before)
        self._switched = False
        command = self._law.command(self._settings, posture, velocity, regions, dt)
        if before is not None:
            self._fading = before - command.torque_at(posture, velocity)
        if self._fading is not None:
            command = replace(command, torque=command.torque + self._fading)
            self._fading = self._fading * np.exp(-dt / BLEND_TIME)
            self._fading = self._fading if np.abs(self._fading).max(initial=0.0) > 1e-6 else None
        self._last = command
        return command

    @property
    def _law(self) -> Law:
        """The law in force, built when it is first wanted."""
        name = self._settings.law
        if name not in self._laws:
            self._laws[name] = build_law(name, self._robot, self._keeper, self._sight)
            self._laws[name].rest = self._rest
        return self._laws[name]
