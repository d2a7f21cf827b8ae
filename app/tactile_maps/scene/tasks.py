"""What a scene is for: its task, the outputs that are wanted of it, and the objects in it.

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
    """What is done in a scene.

    Attributes:
        title: For people.
        outputs: What is wanted where the scene names nothing.
        objects: Whether it needs something besides the robot.
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
        "force": "normal force of each contact",
        "centre_of_pressure": "exact centre of pressure of each contact",
        "pressure_shape": "pressure distribution under each contact at the depth of the taxels",
        "joint_torque": "joint torques",
    }
)
TOUCH_OUTPUTS = ("pressure", "readings", "force", "centre_of_pressure", "pressure_shape")


@dataclass(frozen=True)
class Needs:
    """What effects are decided from.

    Attributes:
        task: One of ``TASKS``.
        outputs: Some of ``OUTPUTS``.
        objects: What there is besides the robot.
        layer: The cover.
        tick: Seconds between two control ticks.
        controller: The controller the scene starts with.
        behaviours: Whether contact events change what the controller does.
        scripted: Whether the scene has a stimulus script.
        attended: Whether a person is there who may poke the skin.
    """

    task: str = "touch"
    outputs: tuple[str, ...] = TASKS["touch"].outputs
    objects: tuple[ObjectSpec, ...] = ()
    layer: ElasticLayer = field(default_factory=ElasticLayer)
    tick: float = 0.005
    controller: str = "impedance"
    behaviours: bool = False
    scripted: bool = False
    attended: bool = True

    @property
    def follows_touch(self) -> bool:
        """Whether force and place of contacts move the robot."""
        return self.behaviours or self.controller != "impedance"

    @property
    def touch(self) -> tuple[str, ...]:
        """Outputs that are known by touch alone; where the robot follows touch, at least the force."""
        wanted = tuple(output for output in self.outputs if output in TOUCH_OUTPUTS)
        return wanted or (("force",) if self.follows_touch else ())

    @property
    def probes(self) -> bool:
        """Whether probes move in the scene."""
        return any(spec.kind == "probe" for spec in self.objects)

    @property
    def outside(self) -> bool:
        """Whether things other than probes stand in the scene."""
        return any(spec.kind != "probe" for spec in self.objects)

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the things that nothing holds."""
        return tuple(s.name for s in self.objects if s.mass > 0 and s.kind not in ("probe", "plate", "plane"))
