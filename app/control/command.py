"""What a controller asks of the joints, and the settings a person turns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from app.arrays import FloatArray, readonly

LawName: TypeAlias = Literal["impedance", "hold_force"]


@dataclass(frozen=True, eq=False)
class JointCommand:
    """A joint impedance command: torque = stiffness (posture - q) - damping q' + torque.

    Attributes:
        posture: (n,) wanted posture [rad, or m for a slide].
        stiffness: (n,) [N m/rad], >= 0.
        damping: (n,) [N m s/rad], >= 0.
        torque: (n,) added torque [N m].
    """

    posture: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    torque: FloatArray

    def __post_init__(self) -> None:
        for name in ("posture", "stiffness", "damping", "torque"):
            object.__setattr__(self, name, readonly(getattr(self, name)))


@dataclass(frozen=True)
class ControlSettings:
    """What the controller panel sets.

    Attributes:
        law: ``impedance`` holds the rest posture like a spring; ``hold_force`` retreats from or follows a touch so
            that the contact force stays at ``force_goal``, and returns to rest when the touch ends.
        stiffness: Of the joints in the impedance law, as natural frequency [rad/s]: each joint's torque stiffness is
            its inertia at home times the square, so that one slider suits a shoulder and a wrist.
        damping_ratio: 1 is critical.
        force_goal: Wanted contact force [N].
        force_gain: Approach or retreat speed per newton of force error [m/s/N].
        integral_time: Time in which a constant error doubles the answer [s]; inf for none.
    """

    law: LawName = "impedance"
    stiffness: float = 8.0
    damping_ratio: float = 1.0
    force_goal: float = 3.0
    force_gain: float = 0.015
    integral_time: float = 0.3


@dataclass(frozen=True)
class ControlChanged:
    """A person changed the controller's settings; an input, recorded like a poke."""

    settings: ControlSettings
