"""Needs of a scene: its task, its outputs and its objects.

Effects are decided from these needs alone, see ``effect_decision``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer


@dataclass(frozen=True)
class Task:
    """Task of a scene.

    Attributes:
        title: Description for the user, after "The task is to".
        outputs: Outputs of a scene that names none.
        objects: Whether the task needs an object besides the robot.
    """

    title: str
    outputs: tuple[str, ...] = ("posture", "pressure", "force")
    objects: bool = False


TASKS: Mapping[str, Task] = MappingProxyType(
    {
        "view": Task("show the robot in its postures", outputs=("posture",)),
        "touch": Task("touch the skin"),
        "slide": Task("slide along an object with a force", objects=True),
        "push": Task("push an object", objects=True),
        "self-touch": Task("bring the robot into self-contact"),
        "crowd": Task("move among many objects", objects=True),
    }
)
OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        "posture": "joint positions",
        "pressure": "simulated pressure on each taxel",
        "readings": "sensor readings of that pressure",
        "shear": "traction along the skin on each taxel, by friction",
        "force": "normal force of each contact",
        "centre_of_pressure": "exact centre of pressure of each contact",
        "pressure_shape": "pressure distribution under each contact at the depth of the taxels",
        "joint_torque": "joint torques",
    }
)
SLIP_EVENTS = ("incipient-slip", "slip")
"""Contact events that need shear."""
SHEAR_SETTINGS = ("friction_use", "shear_goal", "max_shear")
"""Settings of the controller that need shear."""
TOUCH_OUTPUTS = ("pressure", "readings", "shear", "force", "centre_of_pressure", "pressure_shape")


@dataclass(frozen=True)
class Needs:
    """Needs from which the effects are decided.

    Attributes:
        task: One of ``TASKS``.
        outputs: Some of ``OUTPUTS``.
        objects: Objects besides the robot.
        layer: The cover.
        tick: Seconds between two control ticks.
        controller: The controller at the start.
        behaviours: Whether contact events change the settings of the controller.
        slip_events: Whether some of these events are slips.
        shear_control: Whether settings of the controller depend on shear.
        scripted: Whether the scene has a stimulus script.
        attended: Whether a user may poke the skin.
    """

    task: str = "touch"
    outputs: tuple[str, ...] = TASKS["touch"].outputs
    objects: tuple[ObjectSpec, ...] = ()
    layer: ElasticLayer = field(default_factory=ElasticLayer)
    tick: float = 0.005
    controller: str = "impedance"
    behaviours: bool = False
    slip_events: bool = False
    shear_control: bool = False
    scripted: bool = False
    attended: bool = True

    @property
    def follows_touch(self) -> bool:
        """Whether force and location of contacts move the robot."""
        return self.behaviours or self.controller != "impedance"

    @property
    def shear(self) -> bool:
        """Whether the scene needs the shear of the skin."""
        return "shear" in self.outputs or self.slip_events or self.shear_control

    @property
    def touch(self) -> tuple[str, ...]:
        """Outputs that require touch; at least the force if the robot follows touch."""
        found = tuple(output for output in self.outputs if output in TOUCH_OUTPUTS)
        return found or (("force",) if self.follows_touch else ())

    @property
    def probes(self) -> bool:
        """Whether probes move in the scene."""
        return any(spec.kind == "probe" for spec in self.objects)

    @property
    def outside(self) -> bool:
        """Whether the scene has objects other than probes."""
        return any(spec.kind != "probe" for spec in self.objects)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the objects that move freely."""
        return tuple(s.name for s in self.objects if s.mass > 0 and s.kind not in ("probe", "plate", "plane"))
