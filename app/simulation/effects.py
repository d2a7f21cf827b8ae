"""What a scene simulates. What is off here is not in the model, not in the loop, and costs nothing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Effects:
    """The effects of one scene.

    Attributes:
        gravity: ``compensated`` adds gravity and an ideal gravity compensation; ``off`` has neither.
        contact: ``self`` lets the robot's own links touch and feel each other; ``off`` compiles no colliding geometry.
        joint_limits: Whether joints stop at their limits.
        timestep: Of the integrator (implicitfast) [s].
    """

    gravity: Literal["off", "on", "compensated"] = "compensated"
    contact: Literal["off", "self"] = "off"
    joint_limits: bool = True
    timestep: float = 0.001
