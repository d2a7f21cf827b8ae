"""Says when the force gain is more than a skin can hold that is read so seldom and so late."""

from __future__ import annotations

import math
from collections.abc import Sequence

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
    """Compares the force gain with what the skin's times allow at the place first touched. Mutable.

    Against something softer than it takes for granted more would do; so it says, and lowers nothing.

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
        self._asked: object = None
        self._words: tuple[str, ...] = ()

    def look(self, settings: ControlSettings, posture: FloatArray, regions: Sequence[ContactRegion]) -> tuple[str, ...]:
        """What is to be said of the gain while something touches.

        Args:
            settings: Of them ``law`` and ``force_gain``.
            posture: (n,).
            regions: All contacts, the strongest first.
        """
        if self.readings is None or not regions or settings.law == "impedance":
            return ()
        asked = (regions[0].id, settings.force_gain, self.readings)
        if asked != self._asked:
            self._asked = asked
            most = most_gain(self._stiffness(posture, regions[0]), self.readings)
            high = settings.force_gain > most
            self._words = (f"force gain above {most:.2g}, the most for a skin {self.readings}",) if high else ()
        return self._words

    def _stiffness(self, posture: FloatArray, region: ContactRegion) -> float:
        """Force per way [N/m] along a contact's normal: of the joints in series with what touches."""
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation @ region.normal
        row = normal @ self._configuration.jacobian(region.link, region.point)
        return 1 / (1 / CONTACT_STIFFNESS + float(np.sum(row**2 * self._give)))
