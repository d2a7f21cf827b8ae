"""The controller a session asks: the selected law, with settings that may change at any time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from difflib import get_close_matches

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.hold_force import HoldForce
from app.control.impedance import ImpedancePosture
from app.control.law import Law
from app.errors import SceneError
from app.robots.robot import Robot

RANGES: dict[str, tuple[float, float]] = {
    "stiffness": (0.5, 40.0),
    "damping_ratio": (0.1, 3.0),
    "force_goal": (0.0, 20.0),
    "force_gain": (0.0, 0.05),
    "integral_time": (0.05, float("inf")),
}
"""What a person may set, lowest and highest; the panel's sliders end here."""


class ContactMotionController:
    """Turns posture and contact regions into joint commands. Mutable; ``reset`` forgets the past.

    Args:
        robot: Whose joints.
        settings: May be replaced at any time; changing the law starts it afresh from the posture it finds.

    Raises:
        SceneError: A setting is out of range; the last good ones stay.
    """

    def __init__(self, robot: Robot, settings: ControlSettings) -> None:
        self._laws: dict[str, Law] = {"impedance": ImpedancePosture(robot), "hold_force": HoldForce(robot)}
        self._settings = check_settings(settings)

    @property
    def settings(self) -> ControlSettings:
        """The settings in force."""
        return self._settings

    @settings.setter
    def settings(self, settings: ControlSettings) -> None:
        check_settings(settings)
        if settings.law != self._settings.law:
            self._laws[settings.law].reset()
        self._settings = settings

    @property
    def rest(self) -> FloatArray:
        """(n,) the posture kept while nothing touches; the robot's home until it is set. A reset keeps it."""
        return self._laws[self._settings.law].rest

    @rest.setter
    def rest(self, posture: FloatArray) -> None:
        for law in self._laws.values():
            law.rest = posture

    @property
    def why_limited(self) -> tuple[str, ...]:
        """What bounds the answer now, in words; empty when nothing does."""
        return self._laws[self._settings.law].why_limited

    def reset(self) -> None:
        """Forget the past; keep the settings."""
        for law in self._laws.values():
            law.reset()

    def command(
        self, posture: FloatArray, velocity: FloatArray, regions: Sequence[ContactRegion], dt: float
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds; the regions come strongest first."""
        return self._laws[self._settings.law].command(self._settings, posture, velocity, regions, dt)


def check_settings(settings: ControlSettings) -> ControlSettings:
    """Return the settings, or refuse them.

    Raises:
        SceneError: Naming the setting, its value and its range.
    """
    if settings.law not in ("impedance", "hold_force"):
        raise SceneError(
            "there is no such control law",
            place="control.law",
            value=settings.law,
            remedy="Choose impedance or hold_force",
        )
    for name, (low, high) in RANGES.items():
        value = getattr(settings, name)
        if not (isinstance(value, int | float) and low <= value <= high):  # NaN is in no range
            raise SceneError(
                "that setting is out of range",
                place=f"control.{name}",
                value=value,
                remedy=f"Choose {low:g} to {high:g}",
            )
    return settings


def settings_from(values: Mapping[str, str | float]) -> ControlSettings:
    """Settings from a scene's table.

    Raises:
        SceneError: An unknown key, or a value out of range.
    """
    known = {f.name for f in fields(ControlSettings)}
    unknown = [key for key in values if key not in known]
    if unknown:
        close = get_close_matches(unknown[0], known, n=1)
        hint = f"Did you mean {close[0]}? " if close else ""
        raise SceneError(
            "there is no such controller setting",
            place=f"control.{unknown[0]}",
            value=unknown[0],
            remedy=f"{hint}Choose one of: {', '.join(sorted(known))}",
        )
    return check_settings(ControlSettings(**values))  # type: ignore[arg-type]
