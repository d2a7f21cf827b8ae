"""Basis of a budget: cost of each setting of the stages that run in each tick, in the user's own scene.

Errors are those of the trials of the stages, relative to their references. Times are those of the running scene with
one setting after the other while a finger presses the skin, so that they include all effects that the scene requires.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.control.controller_registry import settings_from
from tactile_maps.core.errors import BudgetError, TactileMapsError
from tactile_maps.core.progress import Progress
from tactile_maps.scene.effects import Override
from tactile_maps.scene.scene import with_override
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.studies.budget.proposal import LIVE_STAGES, Option, effects_of, options_of
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import Subject, Trial, run_trials
from tactile_maps.tactile.poke import PokePressed

_SETTLING = 40
_TICKS = 60
_LEAST_FORCE = 0.1
"""Minimum usual contact force of a scene [N], where its controller has a lower goal."""
_SHARES = {"simulation": 0.3, "touch": 0.2, "image": 0.15, "control": 0.35}
"""Shares of the measuring time."""
TIMED_STAGES = {"simulation": "physics", "touch": "touch"}
"""Names of the stages in the timings of a session."""


@dataclass(frozen=True)
class BudgetMeasurement:
    """Options for one robot, skin and scene.

    Attributes:
        options: Options by stage.
        paths: Trials of the control stage; empty if the robot does not move or paths were not requested.
        tick: Control period [s].
        force: Usual contact force: the goal of the controller [N].
        pitch_mm: Spacing of the taxels [mm].
    """

    options: Mapping[str, tuple[Option, ...]]
    paths: tuple[Trial, ...]
    tick: float
    force: float
    pitch_mm: float


def measure_for_budget(subject: Subject, *, paths: bool, progress: Progress) -> BudgetMeasurement:
    """Try every setting of the stages that run in each tick and, on request, every controller along a path.

    Args:
        subject: The map, with the robot that its skin covers.
        paths: Whether controllers are tried too.
        progress: Receives the current setting and the fraction done, 0 to 1; may raise to cancel.

    Raises:
        BudgetError: There is no robot.

    Cost: 7 s for our arm, UR5e and iCub; with ``paths`` 20 s more.
    """
    prepared = subject.prepared
    if prepared is None or not len(prepared.skin):
        raise BudgetError("there is no skin on a robot to measure", remedy="Open a robot with a skin")
    done = 0.0
    tick = prepared.scene.tick
    options = {}
    force = max(settings_from(prepared.scene.control).force_goal, _LEAST_FORCE)
    for name in LIVE_STAGES:
        part = _part_of(progress, done, _SHARES[name])
        trials = tuple(run_trials(STAGES[name], subject, progress=part))
        options[name] = _timed_in_scene(prepared, name, options_of(name, trials, tick=tick, force=force))
        done += _SHARES[name]
    part = _part_of(progress, done, _SHARES["control"])
    rounds = tuple(run_trials(STAGES["control"], subject, progress=part)) if paths else ()
    pitch = 1e3 * float(np.sqrt(prepared.skin.areas.mean()))
    return BudgetMeasurement(options, rounds, tick, force, pitch)


def _part_of(progress: Progress, done: float, share: float) -> Progress:
    return lambda text, fraction: progress(text, done + share * fraction)


def _timed_in_scene(prepared: PreparedScene, stage: str, options: tuple[Option, ...]) -> tuple[Option, ...]:
    """Options with the times of the running scene; options that diverge in it are left out."""
    if stage not in TIMED_STAGES:
        return options
    timed = []
    for option in options:
        try:
            spent = tick_ms(prepared, effects_of(option.trial))
        except TactileMapsError:
            continue  # it diverges in this scene
        timed.append(replace(option, cost=replace(option.cost, milliseconds=spent[TIMED_STAGES[stage]])))
    return tuple(timed)


def tick_ms(prepared: PreparedScene, effects: Mapping[str, Override], *, ticks: int = _TICKS) -> dict[str, float]:
    """Return the median time of each stage of a tick while a finger presses the middle of the skin [ms].

    Args:
        prepared: The scene.
        effects: Changed effects, by key.
        ticks: Number of measured ticks, after settling.

    Raises:
        SimulationError: The simulation diverges.
    """
    scene = with_override(prepared.scene, "fingers", "on")
    for key, override in effects.items():
        scene = with_override(scene, key, override)
    session = Session(replace(prepared, scene=scene), scripted=False)
    session.submit(PokePressed(0, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    spent: dict[str, list[float]] = {}
    for number in range(_SETTLING + ticks):
        frame = session.tick()
        if number >= _SETTLING:
            for name, ms in frame.timings.ms.items():
                spent.setdefault(name, []).append(ms)
    return {name: float(np.median(values)) for name, values in spent.items()}
