"""The arm as a spring to its rest posture: it yields to a touch and comes back (Hogan 1985, in joint space)."""

from __future__ import annotations

from collections.abc import Sequence

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.gains import joint_impedance
from app.robots.configuration import Configuration
from app.robots.robot import Robot


class ImpedancePosture:
    """Holds the rest posture with a stiffness and damping; contacts are not read, they are felt by yielding."""

    why_limited: tuple[str, ...] = ()

    def __init__(self, robot: Robot) -> None:
        self.rest, self._inertia = robot.home, Configuration(robot).inertia()

    def reset(self) -> None:
        """Nothing is remembered."""

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Its answer follows from the rest posture alone, whatever was asked before."""

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """The same spring always."""
        return joint_impedance(
            self._inertia, self.rest, frequency=settings.stiffness, damping_ratio=settings.damping_ratio
        )
