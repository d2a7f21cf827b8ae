"""Measured cost of each effect of a scene on this machine: by its own stage, or by omission from the same run
(ablation).

An effect that is a stage of the sensor, and the contact model of the skin, have their own time in every frame. Effects
inside MuJoCo have none: two simulations execute the same commands and fingers from the same start, one with the effect
and one without, in alternating ticks, so that disturbances slow both. The cost is the mean difference without the
slowest and fastest ticks; effects that are rarely active in the run therefore cost little.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from types import MappingProxyType
from typing import Any, get_args

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.errors import SimulationError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.scene.effects import EFFECTS, Effects
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session, substeps
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.poke import PokeInput
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

Clock = Callable[[], float]
_FEWEST = 50
"""Minimum number of measured ticks, for any budget."""
_TRIMMED = 0.1
"""Share of the slowest ticks, and of the fastest, that are left out."""
_LONGEST = 1600
"""Maximum number of ticks of the run: eight seconds at the usual tick, by which time most scenes are in contact."""
_RUN_SHARE = 0.25
"""Share of the budget for the run itself, which gives the times of all stages."""
_WITHIN_PHYSICS = (
    "dynamics",
    "fingers",
    "contact",
    "gravity",
    "friction",
    "joint_limits",
    "joint_friction",
    "integrator",
)
"""Effects without a stage of their own."""
_PHYSICAL_MODELS = ("foundation", "depth")
"""Skin models that add something to the physics."""
_PLAINEST = "euler"
"""Integrator with which the others are compared; a simulation cannot run without one."""


def ablation_cost(
    prepared: PreparedScene,
    *,
    effects: Effects | None = None,
    seconds: float = 2.0,
    progress: Progress = no_progress,
    clock: Clock = time.perf_counter,
) -> Mapping[str, float]:
    """Return the cost of each active effect in a tick [ms], by key, in the order of ``EFFECTS``.

    The scripted fingers are active during the measurement. Omitting an effect also omits its dependents (without
    contact, no friction of contacts), so costs need not sum to the total; noise may make a cost slightly negative.
    Inactive effects, and effects without which the scene cannot run, have no cost.

    Args:
        prepared: The prepared scene.
        effects: Active effects; by default those that the scene requires.
        seconds: Approximate duration; each effect within the physics needs at least 50 pairs of ticks.
        progress: Receives the current effect and the fraction done, 0 to 1; may raise to cancel.
        clock: Seconds from any origin.

    Raises:
        TactileMapsError: The scene cannot be simulated with these effects.
    """
    effects = effects or prepared.scene.effects
    start = clock()
    progress("Running the scene", 0.0)
    run = _record_run(prepared, effects, seconds * _RUN_SHARE, clock)
    found = dict(run.stages)
    keys = [key for key in _effects_to_leave_out(effects) if without_effect(effects, key) != effects]
    for number, key in enumerate(keys):
        progress(f"Leaving out {EFFECTS[key].title.lower()}", _RUN_SHARE + (1 - _RUN_SHARE) * number / len(keys))
        share = (start + seconds - clock()) / (len(keys) - number)
        cost = _PairedRun(prepared, run, effects, key, clock).cost(share)
        if cost is not None:
            found[key] = found.get(key, 0.0) + cost
    progress("", 1.0)
    return MappingProxyType({key: found[key] for key in EFFECTS if key in found})


def without_effect(effects: Effects, key: str) -> Effects:
    """Return the effects without one of them; the plainest integrator replaces another one.

    Args:
        effects: The effects.
        key: Key in ``EFFECTS``, except the time step.
    """
    if EFFECTS[key].of_sensor:
        return replace(effects, sensor=effects.sensor.without(key))
    off: dict[str, Any] = {key: _PLAINEST if key == "integrator" else EFFECTS[key].value("off")}
    return replace(effects, **off)


def _trimmed_mean(values: Sequence[float]) -> float:
    """Mean without the lowest and the highest values."""
    cut = int(_TRIMMED * len(values))
    return fmean(sorted(values)[cut : len(values) - cut])


@dataclass(frozen=True, eq=False)
class _RecordedRun:
    """Inputs to repeat a run, and the cost of its stages.

    Attributes:
        ticks: For each tick, the finger inputs at its start and the command during it.
        stages: Mean time of the effects that are stages [ms a tick], by key.
    """

    ticks: Sequence[tuple[Sequence[PokeInput], JointCommand]]
    stages: Mapping[str, float]


def _record_run(prepared: PreparedScene, effects: Effects, seconds: float, clock: Clock) -> _RecordedRun:
    session = Session(prepared, effects=effects)
    ticks: list[tuple[Sequence[PokeInput], JointCommand]] = []
    times: dict[str, list[float]] = {}
    end = clock() + seconds
    while len(ticks) < _FEWEST or (len(ticks) < _LONGEST and clock() < end):
        command = session.frame.command
        known = len(session.inputs)
        frame = session.tick()
        ticks.append(([act for _, act in session.inputs[known:] if isinstance(act, get_args(PokeInput))], command))
        for stage, ms in frame.timings.ms.items():
            times.setdefault("skin" if stage == "touch" else stage, []).append(ms)
    return _RecordedRun(ticks, {stage: _trimmed_mean(ms) for stage, ms in times.items() if stage in EFFECTS})


def _effects_to_leave_out(effects: Effects) -> tuple[str, ...]:
    """Effects whose cost can only be measured by omission."""
    return (
        *_WITHIN_PHYSICS,
        *(("skin",) if effects.skin in _PHYSICAL_MODELS else ()),
        *(("area_averaging",) if effects.skin != "off" else ()),
    )


class _PairedRun:
    """Two simulations of the same run, with an effect and without. Mutable."""

    def __init__(self, prepared: PreparedScene, run: _RecordedRun, effects: Effects, key: str, clock: Clock) -> None:
        self._prepared = prepared
        self._run = run
        self._clock = clock
        self._felt = EFFECTS[key].of_sensor
        if not self._felt:  # what is sensed does not change the physics, and would only add its noise
            skin = effects.skin if effects.skin in _PHYSICAL_MODELS else "off"
            effects = replace(effects, skin=skin, sensor=SensorEffects())
        self._effects = (effects, without_effect(effects, key))

    def cost(self, seconds: float) -> float | None:
        """Return the mean difference [ms a tick]; None if the run is impossible without the effect."""
        end = self._clock() + seconds
        turns = list[float]()
        try:
            pair = tuple(self._simulation(effects) for effects in self._effects)
            while len(turns) < _FEWEST or self._clock() < end:
                number = len(turns) % len(self._run.ticks)
                # Who goes second may find the caches warm: they take turns at that too.
                order = (0, 1) if len(turns) % 2 else (1, 0)
                spent = {which: self._play(pair[which], self._effects[which], number) for which in order}
                turns.append(spent[0] - spent[1])
        except SimulationError:
            if len(turns) < _FEWEST:
                return None
        return 1e3 * _trimmed_mean(turns)

    def _simulation(self, effects: Effects) -> Simulation:
        prepared = self._prepared
        scene = self._prepared.scene
        return Simulation(
            prepared.robot,
            prepared.skin,
            effects,
            objects=prepared.objects,
            layer=scene.layer,
            tick=scene.tick,
            seed=scene.seed,
        )

    def _play(self, simulation: Simulation, effects: Effects, number: int) -> float:
        """Time of tick ``number`` of the run in the physics, or in sensing [s]."""
        if number == 0:
            simulation.reset()
        acts, command = self._run.ticks[number]
        for act in acts if effects.fingers else ():
            simulation.apply(act)
        steps = substeps(self._prepared.scene.tick, effects.timestep)
        start = self._clock()
        simulation.step(steps, command)
        if self._felt:
            start = self._clock()
            simulation.sense()
        return self._clock() - start
