"""What a budget is chosen from: each setting of the stages that work in each tick, in the user's own scene.

Errors are those of the stages' own trials, against their references. Times are those of the scene itself, running with
one setting after the other while a finger presses the skin: what else the scene calls for has its part in them.
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
"""A scene whose controller wants less touches with about so much [N]."""
_SHARES = {"simulation": 0.3, "touch": 0.2, "image": 0.15, "control": 0.35}
"""Of the time that measuring takes."""
TIMED_STAGES = {"simulation": "physics", "touch": "touch"}
"""What a session calls the time of a stage."""


@dataclass(frozen=True)
class BudgetMeasurement:
    """All there is to choose from, for one robot, skin and scene.

    Attributes:
        options: By stage.
        paths: Trials of the control stage; none where the robot does not move or nobody asked for them.
        tick: Between two ticks [s].
        force: Of a usual contact, the one that the controller wants [N].
        pitch_mm: From taxel to taxel.
    """

    options: Mapping[str, tuple[Option, ...]]
    paths: tuple[Trial, ...]
    tick: float
    force: float
    pitch_mm: float


def measure_for_budget(subject: Subject, *, paths: bool, progress: Progress) -> BudgetMeasurement:
    """Try every setting of the stages that work in each tick, and where asked for every controller along a path.

    Args:
        subject: The map, with the robot that wears its skin.
        paths: Whether controllers are tried too.
        progress: Told what is tried and how far it is, 0 to 1; may raise to cancel.

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
    """The same with the times of the running scene; what does not run there is left out."""
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
    """The median milliseconds of each stage of a tick while a finger presses the middle of the skin.

    Args:
        prepared: The scene.
        effects: What is simulated otherwise, by key.
        ticks: So many are looked at, after some to settle.

    Raises:
        SimulationError: It does not hold until then.
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
