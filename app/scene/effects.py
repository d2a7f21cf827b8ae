"""What a scene simulates, decided. What is off here is not in the model, not in the loop, and costs nothing."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from app.touch.sensor.effects import SensorEffects

Gravity: TypeAlias = Literal["off", "on", "compensated"]
Contact: TypeAlias = Literal["off", "probe", "environment", "self", "all"]
SkinModel: TypeAlias = Literal["off", "point", "water-fill", "punch", "half-space", "foundation", "depth"]
Integrator: TypeAlias = Literal["implicitfast", "discrete", "euler", "implicit", "rk4"]


@dataclass(frozen=True)
class Effects:
    """The effects of one scene.

    Attributes:
        gravity: ``compensated`` adds gravity and an ideal compensation of it in the robot; ``off`` has neither.
        contact: What may touch: ``probe`` the skin and probes; ``environment`` robot, probes and objects; ``self`` the
            robot's own links; ``all`` everything; ``off`` compiles no colliding geometry.
        joint_limits: Whether joints stop at their limits.
        timestep: Of the integrator [s].
        dynamics: Whether bodies have inertia; without, the robot is where it is asked to be, and nothing pushes it.
        fingers: Whether hands and scripts may poke.
        friction: Whether contacts resist sliding.
        joint_friction: Whether joints have the dry friction that the robot's file gives them.
        skin: How contact becomes pressure; ``off`` senses nothing.
        integrator: MuJoCo's.
        sensor: What the sensor makes of the pressure.
    """

    gravity: Gravity = "compensated"
    contact: Contact = "off"
    joint_limits: bool = True
    timestep: float = 0.001
    dynamics: bool = True
    fingers: bool = True
    friction: bool = False
    joint_friction: bool = False
    skin: SkinModel = "water-fill"
    integrator: Integrator = "implicitfast"
    sensor: SensorEffects = field(default_factory=SensorEffects)
