"""Scene: robot, skin, objects, task and stimulus script."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

from tactile_maps.core.arrays import set_fields
from tactile_maps.core.errors import SceneError, check_names, did_you_mean
from tactile_maps.scene.effect_decision import EffectDecision, decide_effects
from tactile_maps.scene.effects import EFFECTS, Effects, Override, effect_entry
from tactile_maps.scene.motion import Waypoint
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.tasks import OUTPUTS, SHEAR_SETTINGS, SLIP_EVENTS, TASKS, Needs
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.grid import GridSpec
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

Setting: TypeAlias = str | float | tuple[tuple[float, float], ...]
"""Setting of the controller: a word, a number, or points on the map [m]."""
MAX_OBJECTS = 200
"""Largest number of objects. The time to build a scene grows with its square."""
_SHORTEST_STEP = 1e-5
"""Shortest time step of the physics [s]."""


def whole_steps(tick: float, timestep: float) -> int:
    """Return the number of physics steps in one control tick.

    Raises:
        SceneError: The tick [s] is not a whole number of time steps [s].
    """
    steps = round(tick / timestep) if _SHORTEST_STEP <= timestep <= tick else 0  # NaN compares false
    if steps and abs(tick / timestep - steps) <= 1e-6:
        return steps
    known = math.isfinite(timestep) and timestep > 0
    parts = min(max(math.ceil(tick / timestep), 1), math.floor(tick / _SHORTEST_STEP)) if known else 1
    raise SceneError(
        "the tick must be a whole number of time steps",
        place="effects.timestep",
        value=f"time step {timestep:g} s in a tick of {tick:g} s",
        remedy=f"Choose a time step of {tick / parts:g} s (tick / {parts}), or another tick",
    )


@dataclass(frozen=True)
class Scene:
    """Everything that a session starts from.

    Attributes:
        name: Short name, as on the command line.
        title: Title for the user.
        description: What the scene shows, in a sentence.
        suggestion: What the user may try in it, in a sentence.
        robot: Name or file of the robot; ``none`` for the skin of ``taxel_files`` alone, fixed in the world.
        task: Task, one of ``TASKS``.
        outputs: Outputs, some of ``OUTPUTS``; empty for those of the task.
        cover: Placement of the skin.
        layer: Material of the cover.
        home: Joint values of the robot's home posture by joint name [rad, m], instead of those of its file.
        package_roots: Additional folders in which a robot's file may find packages and meshes.
        taxel_files: Files of taxels, or folders of iCub positions, used instead of a cover; ``cover.links`` are the
            links of those that do not name theirs. The key ``taxel_file`` of a scene file is one or a list of them.
        grids: Grids of taxels, each between two corners on a link; with grids, only links in ``cover`` are covered.
        more_covers: Further covers, each with named links; it changes no taxels of other covers.
        objects: Objects besides the robot, with distinct names.
        overrides: Effects that do not follow from the needs, by key of ``EFFECTS``.
        control: Settings of the controller that differ from its defaults, by name.
        behaviours: Changes of the controller's settings by contact events, see ``tactile_maps.control.behaviours``.
        reading: Settings of the contact detection that differ from its defaults, by name.
        motion: Repeated motion of the robot; without waypoints it stays at home.
        stimuli: Stimuli of the scripted fingers.
        repeat_stimuli: Whether these start again when all have ended.
        tick: Time between two control ticks [s], a whole number of time steps.
        seed: Seed of all randomness in the session: 0 to 2^63 - 1.

    Raises:
        SceneError: A task, output or effect is unknown, or a number is out of range.

    Example:
        >>> scene = tm.Scene("reading", robot="arm", task="touch", outputs=("force", "readings"))
        >>> scene.effects.sensor.noise is not None
        True
    """

    name: str
    robot: str
    title: str = ""
    description: str = ""
    suggestion: str = ""
    task: str = "touch"
    outputs: tuple[str, ...] = ()
    cover: CoverSpec = field(default_factory=CoverSpec)
    layer: ElasticLayer = field(default_factory=ElasticLayer)
    home: Mapping[str, float] = field(default_factory=dict)
    package_roots: tuple[str, ...] = ()
    taxel_files: tuple[str, ...] = ()
    grids: tuple[GridSpec, ...] = ()
    more_covers: tuple[CoverSpec, ...] = ()
    objects: tuple[ObjectSpec, ...] = ()
    overrides: Mapping[str, Override] = field(default_factory=dict)
    control: Mapping[str, Setting] = field(default_factory=dict)
    behaviours: tuple[Mapping[str, Any], ...] = ()
    reading: Mapping[str, str | float] = field(default_factory=dict)
    motion: tuple[Waypoint, ...] = ()
    stimuli: tuple[Stimulus, ...] = ()
    repeat_stimuli: bool = True
    tick: float = 0.005
    seed: int = 0

    def __post_init__(self) -> None:
        for place in ("outputs", "package_roots", "taxel_files"):
            check_names(getattr(self, place), place, error=SceneError)
        checked = {key: effect_entry(key).checked(override) for key, override in self.overrides.items()}
        set_fields(self, overrides={key: override for key, override in checked.items() if override != "auto"})
        self._check_words()
        self._check_names()
        if not 1e-4 <= self.tick <= 1.0:
            raise self._error("the tick is out of range", "tick", f"{self.tick} s", "Choose 0.0001 to 1 s")
        try:
            whole_steps(self.tick, self.effects.timestep)
        except SceneError as error:
            raise error.at(file=self.name) from error
        for number, cover in enumerate(self.more_covers):
            if not cover.links:
                place = f"more_covers.{number}.links"
                raise self._error("a further cover names no links", place, "", "Name the links that it covers")
        covers = {f"more_covers.{number}.seed": cover.seed for number, cover in enumerate(self.more_covers)}
        for place, seed in {"seed": self.seed, "cover.seed": self.cover.seed, **covers}.items():
            if not 0 <= seed < 2**63:
                raise self._error("a seed is out of range", place, seed, "Choose 0 to 2^63 - 1")

    @property
    def effective_outputs(self) -> tuple[str, ...]:
        """Its outputs, or else those of its task."""
        return self.outputs or TASKS[self.task].outputs

    @cached_property
    def decision(self) -> EffectDecision:
        """The effects with their reasons and warnings."""
        return decide_effects(self._needs, self.overrides)

    @cached_property
    def unattended(self) -> EffectDecision:
        """The effects of a run without a user: without a stimulus script nothing pokes the skin."""
        return decide_effects(replace(self._needs, attended=False), self.overrides)

    @property
    def _needs(self) -> Needs:
        return Needs(
            task=self.task,
            outputs=self.effective_outputs,
            objects=self.objects,
            layer=self.layer,
            tick=self.tick,
            controller=str(self.control.get("controller", "impedance")),
            behaviours=bool(self.behaviours),
            slip_events=any(behaviour.get("on") in SLIP_EVENTS for behaviour in self.behaviours),
            shear_control=any(name in self.control for name in SHEAR_SETTINGS),
            scripted=bool(self.stimuli),
        )

    @property
    def effects(self) -> Effects:
        """The simulated effects."""
        return self.decision.effects

    def _check_words(self) -> None:
        if self.task not in TASKS:
            raise self._error("unknown task", "task", self.task, did_you_mean(self.task, tuple(TASKS)))
        for output in self.outputs:
            if output not in OUTPUTS:
                raise self._error("unknown output", "outputs", output, did_you_mean(output, tuple(OUTPUTS)))

    def _check_names(self) -> None:
        if len(self.objects) > MAX_OBJECTS:
            remedy = f"The maximum is {MAX_OBJECTS}: leave out those that the robot does not reach"
            raise self._error(f"the scene has more than {MAX_OBJECTS} objects", "objects", len(self.objects), remedy)
        names = [spec.name for spec in self.objects]
        for number, name in enumerate(names):
            if name in names[:number]:
                remedy = "Give each object a name of its own"
                raise self._error("two objects have the same name", f"objects.{number}.name", name, remedy)

    def _error(self, problem: str, place: str, value: object, remedy: str) -> SceneError:
        return SceneError(problem, file=self.name, place=place, value=value, remedy=remedy)


def with_override(scene: Scene, key: str, override: Override) -> Scene:
    """Return the scene with another override of one effect; ``auto`` removes the override.

    Raises:
        SceneError: The effect is unknown, or the value is not possible.
    """
    return replace(scene, overrides={**scene.overrides, key: override})


def with_effects(scene: Scene, effects: Effects) -> Scene:
    """Return the scene with an override of each effect that it would otherwise decide differently from ``effects``."""
    for key, entry in EFFECTS.items():  # the decision about an effect may depend on those before it
        value = entry.value_in(effects)
        if entry.value_in(scene.effects) != value:
            scene = with_override(scene, key, entry.override(value))
    return scene


def with_package_roots(scene: Scene, roots: Sequence[str]) -> Scene:
    """Return the scene with additional package roots."""
    return replace(scene, package_roots=tuple(dict.fromkeys((*scene.package_roots, *roots))))
