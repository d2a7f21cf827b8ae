"""Gains for a skin that is read so seldom and so late: held to what it can hold, or said to be more than that."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings
from app.control.gains import JointImpedance
from app.control.reference import INNER_FREQUENCY
from app.control.skin_readings import SkinReadings
from app.robots.configuration import Configuration
from app.robots.robot import Robot

CONTACT_STIFFNESS = 2e4
"""Of what touches and the skin's cover [N/m], nominal; the joints that hold the arm are in series with it."""

SHARE = 0.3
"""Of the limit of stability, that calm gains take: without overshoot, and with room for a stiffer contact."""
_PATIENCE = 12.0
"""An integral is no faster than so many times what passes from a touch to its reading: it follows the answer."""


def most_gain(stiffness: float, readings: SkinReadings) -> float:
    """The largest force gain [m/s/N] with which a sampled loop against a spring is stable.

    k_f k T < 2 sin(pi / (2 (2 d + 1))), d the delay in samples (theory of sampled integral loops); within 20 % on a
    whole arm whose joints settle faster than the samples come.

    Args:
        stiffness: Force per way of the wanted posture [N/m].
        readings: Of the skin.
    """
    samples = readings.delay / readings.period
    return 2 * math.sin(math.pi / (2 * (2 * samples + 1))) / (stiffness * readings.period)


class LoopWatch:
    """Compares gains with what the skin's times allow at the place first touched. Mutable.

    Where settings are ``calm``, the force gain is held to ``SHARE`` of the most that a sampled loop can hold, the
    integral is no faster than its answer, and the place gets its share of one over what passes from a touch to its
    reading. Against something softer than ``CONTACT_STIFFNESS`` more would do.

    Args:
        robot: Whose joints hold the arm against the contact.

    Attributes:
        readings: Of the skin; None says nothing.

    Cost: 20 µs when another contact or other settings come, else 1 µs.
    """

    def __init__(self, robot: Robot) -> None:
        self._configuration = Configuration(robot)
        inertia = self._configuration.inertia()
        held = JointImpedance(inertia, frequency=INNER_FREQUENCY, damping_ratio=1.0)
        self._give = 1 / held.stiffness  # [rad/(N m)]
        self.readings: SkinReadings | None = None
        self.reset()

    def reset(self) -> None:
        """Nothing has touched."""
        self._asked: tuple[int, ControlSettings, SkinReadings] | None = None
        self._answer: tuple[ControlSettings, tuple[str, ...]] = ControlSettings(), ()

    def heed(
        self, settings: ControlSettings, posture: FloatArray, regions: Sequence[ContactRegion]
    ) -> tuple[ControlSettings, tuple[str, ...]]:
        """The settings as a law may take them, and what is to be said of that while something touches.

        Args:
            settings: As they are set. What was made of them stays while nothing touches, since what was lost is sought
                at their speed.
            posture: (n,).
            regions: All contacts, the strongest first.
        """
        if self.readings is None or settings.law == "impedance":
            return settings, ()
        known = self._asked
        if regions and known != (regions[0].id, settings, self.readings):
            self._asked = known = regions[0].id, settings, self.readings
            most = most_gain(self._stiffness(posture, regions[0]), self.readings)
            self._answer = _calmed(settings, most, self.readings)
        if known is None or known[1:] != (settings, self.readings):
            return settings, ()
        return self._answer[0], self._answer[1] if regions else ()

    def _stiffness(self, posture: FloatArray, region: ContactRegion) -> float:
        """Force per way [N/m] along a contact's normal: of the joints in series with what touches."""
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation @ region.normal
        row = normal @ self._configuration.jacobian(region.link, region.point)
        return 1 / (1 / CONTACT_STIFFNESS + float(np.sum(row**2 * self._give)))


def _calmed(settings: ControlSettings, most: float, readings: SkinReadings) -> tuple[ControlSettings, tuple[str, ...]]:
    """Gains that can be held, and in words what was done; as they are set, whether they can be."""
    if settings.gains == "as_set":
        high = settings.force_gain > most
        return settings, (f"force gain above {most:.2g}, the most for a skin {readings}",) if high else ()
    wait = readings.period + readings.delay
    force, place = min(settings.force_gain, SHARE * most), min(settings.position_gain, SHARE / wait)
    integral = max(settings.integral_time, _PATIENCE * wait)
    said = []
    if force < settings.force_gain:
        said.append(f"force gain held to {1e3 * force:.2g} mm/s per N by a skin {readings}")
    if place < settings.position_gain:
        said.append(f"position gain held to {place:.2g}/s by a skin {readings}")
    return replace(settings, force_gain=force, position_gain=place, integral_time=integral), tuple(said)
