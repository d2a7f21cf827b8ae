"""A scene: which robot in which skin among which things, what for, and what a script does before a person comes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

from tactile_maps.core.arrays import set_fields
from tactile_maps.core.errors import SceneError, did_you_mean
from tactile_maps.scene.effect_decision import EffectDecision, decide_effects
from tactile_maps.scene.effects import Effects, Override, effect_entry
from tactile_maps.scene.motion import Waypoint
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.tasks import OUTPUTS, TASKS, Needs
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.skin.fitting.fit import GridSpec
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

Setting: TypeAlias = str | float | tuple[tuple[float, float], ...]
"""Of the controller: a word, a number, or points on the map [m]."""


MAX_OBJECTS = 200
"""Objects of a scene. The time to build a scene grows with the square of their number."""


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
    """Everything a session starts from.

    Attributes:
        name: Short, as on the command line.
        title: For people.
        description: What it shows, in a sentence.
        suggestion: What a person may try in it, in a sentence.
        robot: A robot's name or file; ``none`` for the skin of ``taxel_file`` alone, fixed in the world.
        task: What is done, one of ``TASKS``.
        outputs: What is wanted, some of ``OUTPUTS``; empty for what the task usually wants.
        cover: How the skin places itself.
        layer: What the cover is made of.
        home: Joint values of the robot's home posture by joint name [rad, m], instead of those of its file.
        package_roots: Folders in which a robot's file may find packages and meshes, besides its own.
        taxel_file: A file of taxels, or a folder of iCub positions, used instead of a cover, on ``cover.links`` where
            it does not name its link; empty for none.
        grids: Of taxels, each between two corners on a link; with grids, only the links named in ``cover`` are covered.
        objects: What there is besides the robot; their names differ.
        overrides: Effects that do not follow from the needs, by key of ``EFFECTS``.
        control: Settings of the controller that differ from its defaults, by name.
        behaviours: What contact events change of the controller's settings, see ``tactile_maps.control.behaviours``.
        reading: How contacts are read, where that differs from the usual, by name.
        motion: The robot's own way, again and again; none stays at home.
        stimuli: What the scripted fingers do.
        tick: Seconds between two control ticks, a whole number of time steps.
        seed: Of all randomness in the session: 0 to 2^63 - 1.

    Raises:
        SceneError: There is no such task, output or effect, or a number is out of range.

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
    taxel_file: str = ""
    grids: tuple[GridSpec, ...] = ()
    objects: tuple[ObjectSpec, ...] = ()
    overrides: Mapping[str, Override] = field(default_factory=dict)
    control: Mapping[str, Setting] = field(default_factory=dict)
    behaviours: tuple[Mapping[str, Any], ...] = ()
    reading: Mapping[str, str | float] = field(default_factory=dict)
    motion: tuple[Waypoint, ...] = ()
    stimuli: tuple[Stimulus, ...] = ()
    tick: float = 0.005
    seed: int = 0

    def __post_init__(self) -> None:
        checked = {key: effect_entry(key).checked(override) for key, override in self.overrides.items()}
        set_fields(self, overrides={key: override for key, override in checked.items() if override != "auto"})
        self._check_words()
        self._check_names()
        if not 1e-4 <= self.tick <= 1.0:
            raise self._refusal("the tick is out of range", "tick", f"{self.tick} s", "Choose 0.0001 to 1 s")
        try:
            whole_steps(self.tick, self.effects.timestep)
        except SceneError as error:
            raise error.at(file=self.name) from error
        for place, seed in (("seed", self.seed), ("cover.seed", self.cover.seed)):
            if not 0 <= seed < 2**63:
                raise self._refusal("a seed is out of range", place, seed, "Choose 0 to 2^63 - 1")

    @property
    def steps_per_tick(self) -> int:
        """Physics steps in one control tick."""
        return whole_steps(self.tick, self.effects.timestep)

    @property
    def wanted(self) -> tuple[str, ...]:
        """What is wanted of it: its outputs, or those of its task."""
        return self.outputs or TASKS[self.task].outputs

    @cached_property
    def decision(self) -> EffectDecision:
        """What is simulated, why, and what is lacking."""
        return decide_effects(self._needs, self.overrides)

    @cached_property
    def unattended(self) -> EffectDecision:
        """The same for a run that nobody watches: without a stimulus script nothing pokes the skin."""
        return decide_effects(replace(self._needs, attended=False), self.overrides)

    @property
    def _needs(self) -> Needs:
        return Needs(
            task=self.task,
            outputs=self.wanted,
            objects=self.objects,
            layer=self.layer,
            tick=self.tick,
            controller=str(self.control.get("controller", "impedance")),
            behaviours=bool(self.behaviours),
            scripted=bool(self.stimuli),
        )

    @property
    def effects(self) -> Effects:
        """What is simulated."""
        return self.decision.effects

    def _check_words(self) -> None:
        if self.task not in TASKS:
            raise self._refusal("there is no such task", "task", self.task, did_you_mean(self.task, tuple(TASKS)))
        for output in self.outputs:
            if output not in OUTPUTS:
                raise self._refusal("there is no such output", "outputs", output, did_you_mean(output, tuple(OUTPUTS)))

    def _check_names(self) -> None:
        if len(self.objects) > MAX_OBJECTS:
            remedy = f"The most is {MAX_OBJECTS}: leave out those that the robot does not reach"
            raise self._refusal(f"the scene has more than {MAX_OBJECTS} objects", "objects", len(self.objects), remedy)
        names = [spec.name for spec in self.objects]
        for number, name in enumerate(names):
            if name in names[:number]:
                remedy = "Give each object a name of its own"
                raise self._refusal("two objects have the same name", f"objects.{number}.name", name, remedy)

    def _refusal(self, problem: str, place: str, value: object, remedy: str) -> SceneError:
        return SceneError(problem, file=self.name, place=place, value=value, remedy=remedy)


def with_override(scene: Scene, key: str, override: Override) -> Scene:
    """The same scene with one effect as a person wants it; ``auto`` takes the override back.

    Raises:
        SceneError: There is no such effect, or it cannot be set to that.
    """
    return replace(scene, overrides={**scene.overrides, key: override})


def with_package_roots(scene: Scene, roots: Sequence[str]) -> Scene:
    """The same scene, whose robot may find its files under these folders too."""
    return replace(scene, package_roots=tuple(dict.fromkeys((*scene.package_roots, *roots))))
