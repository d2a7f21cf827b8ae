"""``budget``: best settings of all stages of a scene within milliseconds, or millimetres and newtons."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tactile_maps.cli.shared.output import print_fields, print_json, print_line, progress_line
from tactile_maps.cli.shared.scenes import scene_from_arguments
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import UsageError
from tactile_maps.core.toml import toml_lines
from tactile_maps.scene.effects import Override
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.studies.budget.measurement import TIMED_STAGES, BudgetMeasurement, measure_for_budget, tick_ms
from tactile_maps.studies.budget.proposal import Budget, Proposal, fastest_path, propose
from tactile_maps.studies.budget.wording import number_words, proposal_words, setting_words
from tactile_maps.studies.stages.control import stage_setting_of, with_stage_setting
from tactile_maps.studies.study.work_precision import Setting, Subject, Trial


def execute(arguments: argparse.Namespace) -> int:
    """Measure all settings in the scene, print the best ones within the budget, and measure these again."""
    budget = _budget(arguments)
    progress = progress_line()
    prepared = prepare_cached(scene_from_arguments(arguments), progress=progress)
    subject = Subject.of(prepared.map, prepared=prepared)
    measured = measure_for_budget(subject, paths=budget.of_error, progress=progress)
    found = propose(budget, measured.options, pitch_mm=measured.pitch_mm, force=measured.force)
    path = fastest_path(budget, measured.paths)
    times = _Times(
        predicted=sum(found.chosen[stage].cost.milliseconds for stage in TIMED_STAGES),
        measured=_live_ms(prepared, found.effects),
        now=_live_ms(prepared, {}),
    )
    progress("", 1.0)
    if arguments.json:
        print_json(_facts(found, path, times))
    else:
        _print(prepared, measured, found, path)
        predicted, again, now = map(number_words, (times.predicted, times.measured, times.now))
        text = f"{predicted} ms predicted, {again} ms measured; {now} ms in the current scene"
        print_line(f"Simulation and touch: {text}.")
    return 0


@dataclass(frozen=True)
class _Times:
    """Time of simulation and touch in a tick [ms]."""

    predicted: float
    measured: float
    now: float


def _live_ms(prepared: PreparedScene, effects: Mapping[str, Override]) -> float:
    spent = tick_ms(prepared, effects)
    return sum(spent[name] for name in TIMED_STAGES.values())


def _budget(arguments: argparse.Namespace) -> Budget:
    limits = arguments.milliseconds, arguments.millimetres, arguments.newtons
    if all(limit is None for limit in limits):
        raise UsageError("no limit is given", remedy="Give --milliseconds, or --millimetres and --newtons")
    return Budget(*limits)


def _facts(found: Proposal, path: Trial | None, times: _Times) -> dict[str, Any]:
    settings = [option.trial.setting for option in found.chosen.values()] + ([path.setting] if path else [])
    return {
        "settings": {one.stage: {"method": one.method, **one.values} for one in settings},
        "cost": vars(found.cost),
        "most_accurate": vars(found.finest),
        "effects": found.effects,
        "predicted_ms": times.predicted,
        "measured_ms": times.measured,
        "now_ms": times.now,
    }


def _print(prepared: PreparedScene, measured: BudgetMeasurement, found: Proposal, path: Trial | None) -> None:
    settings = [option.trial.setting for option in found.chosen.values()] + ([path.setting] if path else [])
    now = {stage: setting_words(setting) for stage, setting in _current_settings(prepared).items()}
    rows = {}
    for one in settings:
        words = setting_words(one)
        other = f"  (now {now[one.stage]})" if now.get(one.stage, words) != words else ""
        rows[one.stage.capitalize()] = words + other
    print_fields(rows)
    for sentence in proposal_words(found, path, tried=bool(measured.paths)):
        print_line(sentence)
    print_line("")
    for line in scene_lines(found, path):
        print_line(line)
    print_line("")
    print_line("The image is a setting of the window: apply it in the panel Accuracy and time.")


def _current_settings(prepared: PreparedScene) -> Mapping[str, Setting]:
    """Current settings of the scene by stage, except the image, a setting of the view."""
    session = Session(prepared, scripted=False)
    effects = session.effects
    step = {"timestep_ms": round(1e3 * effects.timestep, 6)}
    return {
        "simulation": Setting("simulation", effects.integrator, step),
        "touch": Setting("touch", effects.skin, {}),
        "control": stage_setting_of(session.settings),
    }


def scene_lines(found: Proposal, path: Trial | None) -> list[str]:
    """Return the lines of a scene file for these settings; a controller along a path also needs the task."""
    lines = ["[effects]", toml_lines(found.effects)]
    if path is not None:
        then = with_stage_setting(ControlSettings(), path.setting)
        keys = ("controller", "task", "path_speed")
        lines += ["", "[control]", toml_lines({key: getattr(then, key) for key in keys})]
    return lines
