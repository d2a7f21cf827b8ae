"""``compare``: run several controllers on the same stimulus and compare them."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

from tactile_maps.cli.shared.output import print_fields, print_json, print_line, progress_line
from tactile_maps.cli.shared.outputs import check_outputs_in
from tactile_maps.cli.shared.robot_options import package_roots
from tactile_maps.cli.shared.scenes import with_home
from tactile_maps.cli.shared.unused_options import refuse_with_input
from tactile_maps.control.controller_registry import CONTROLLERS, check_settings, settings_from
from tactile_maps.control.motion.command import CHOICES, ControlSettings, TaskName
from tactile_maps.core.errors import ExportError, UsageError, did_you_mean
from tactile_maps.core.files import make_output_folder, write_atomically
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.inputs import ControlChanged, SessionInput
from tactile_maps.session.prepare import PreparedScene, check_stimuli, open_scene
from tactile_maps.session.prepared_cache import load_robot_cached, prepare_cached
from tactile_maps.studies.base.figures import BarChart
from tactile_maps.studies.controller_comparison import (
    Contender,
    ControllerMetrics,
    ControllerTrace,
    compare_controllers,
    controller_metrics,
    trace_csv,
)

SCRIPT_SECONDS = 10.0
"""Default duration of a comparison on a scene; a recording is used over its full length."""
_COLUMNS = {
    "map_rms_mm": "map mm",
    "body_rms_mm": "body mm",
    "force_rms_N": "force N",
    "force_max_N": "max N",
    "lost": "lost",
    "limited": "limited",
    "joint_speed_max": "rad/s",
    "control_ms": "ms",
}
"""Columns of the table in the terminal; the files have all figures."""
_FILE = "controllers.csv"
_CHARTS = (
    ("body_rms_mm", "Place on the body", "error, root mean square [mm]"),
    ("force_rms_N", "Force", "departure from its goal, root mean square [N]"),
    ("control_ms", "Cost", "control of one tick, median [ms]"),
)
"""Figures that are drawn on the page."""


def execute(arguments: argparse.Namespace) -> int:
    """Compare the controllers; return 1 if one stopped early."""
    controllers = _controller_names(arguments.controllers)
    if arguments.output is not None:
        names = (_FILE, Path(_FILE).with_suffix(".html").name)
        check_outputs_in(Path(arguments.output), names, overwrite=arguments.overwrite)
    prepared, inputs, base, seconds = _stimulus(arguments)
    if arguments.task is not None:
        base = check_settings(replace(base, task=cast("TaskName", _checked_choice("task", arguments.task))))
    seconds = arguments.seconds or seconds
    contenders = [Contender(controller, replace(base, controller=controller)) for controller in controllers]
    own_task = arguments.task is not None
    progress = progress_line()
    traces = compare_controllers(
        prepared, contenders, inputs=inputs, seconds=seconds, own_task=own_task, progress=progress
    )
    file = _write(arguments.output, traces)
    figures = {trace.name: controller_metrics(trace) for trace in traces}
    ended = {trace.name: trace.ended for trace in traces if trace.ended}
    end_texts = [f"{trace.name} {trace.end_text()}" for trace in traces if trace.ended]
    page = _write_page(arguments, file, figures, ended, seconds)
    if arguments.json:
        print_json(
            {
                "seconds": seconds,
                "controllers": {name: _json_row(found) for name, found in figures.items()},
                "stopped": ended,
                "file": str(file) if file else None,
                "page": str(page) if page else None,
            }
        )
    else:
        _print_table(figures, end_texts, recorded=inputs is not None)
        print_fields({"Written to": file, "Page": page})
    return 1 if ended else 0


def _controller_names(text: str) -> list[str]:
    controllers = [_checked_choice("controller", name.strip()) for name in text.split(",") if name.strip()]
    if not controllers or len(set(controllers)) < len(controllers):
        raise UsageError(
            "the controllers to compare must be named, each once",
            place="--controllers",
            value=text,
            remedy="Like hybrid,qp",
        )
    return controllers


def _checked_choice(choice: str, name: str) -> str:
    if name not in CHOICES[choice] and not (choice == "controller" and name in CONTROLLERS):
        remedy = CONTROLLERS.remedy(name) if choice == "controller" else did_you_mean(name, CHOICES[choice])
        raise UsageError(f"unknown {choice}", place=f"--{choice}", value=name, remedy=remedy)
    return name


def _stimulus(
    arguments: argparse.Namespace,
) -> tuple[PreparedScene, Sequence[tuple[int, SessionInput]] | None, ControlSettings, float]:
    """Scene, its inputs (None for its script), source of the gains, and duration [s]."""
    name = arguments.input
    if Path(name).suffix.lower() == ".mcap":
        refuse_with_input(arguments, ["--home"], "input", name, purpose="It is for scenes and robots")
        player = RecordingPlayer(name)
        begun = [act.settings for _, act in player.inputs if isinstance(act, ControlChanged)]
        return player.prepared, player.inputs, begun[0] if begun else ControlSettings(), float(player.times[-1])
    scene = open_scene(name, package_roots=package_roots(arguments), load=load_robot_cached)
    scene = with_home(scene, arguments)
    prepared = prepare_cached(scene, progress=progress_line())
    check_stimuli(prepared, name)
    return prepared, None, settings_from(dict(scene.control)), SCRIPT_SECONDS


def _write(folder: str | None, traces: Sequence[ControllerTrace]) -> Path | None:
    if folder is None:
        return None
    path = make_output_folder(Path(folder), error=ExportError) / _FILE
    write_atomically(path, trace_csv(traces), error=ExportError)
    return path


def _write_page(
    arguments: argparse.Namespace,
    file: Path | None,
    figures: Mapping[str, ControllerMetrics],
    ended: Mapping[str, str],
    seconds: float,
) -> Path | None:
    """Write a page next to the file, with bars of the main figures."""
    if file is None:
        return None
    from tactile_maps.cli.shared.pages import write_fact_page

    charts = [
        BarChart(title, axis, {name: getattr(found, column) for name, found in figures.items()})
        for column, title, axis in _CHARTS
        if any(getattr(found, column) is not None for found in figures.values())
    ]
    rows = [{"controller": name, **_json_row(found), "stopped": ended.get(name)} for name, found in figures.items()]
    facts = {"Stimulus": arguments.input, "Task": arguments.task, "Simulated": f"{seconds:g} s each"}
    page = file.with_suffix(".html")
    return write_fact_page(page, "Controllers compared", facts, tables={"All figures": rows}, charts=charts)


def _print_table(figures: dict[str, ControllerMetrics], end_texts: Sequence[str], *, recorded: bool) -> None:
    wide = max(len("controller"), *(len(name) for name in figures))
    titles = _COLUMNS | {"joint_speed_max": next(iter(figures.values())).speed_unit.replace("% of", "%")}
    print_line(f"{'controller':<{wide}}  " + "  ".join(f"{title:>8}" for title in titles.values()) + "  main limit")
    for name, found in figures.items():
        cells = "  ".join(f"{_cell(column, getattr(found, column)):>8}" for column in _COLUMNS)
        print_line(f"{name:<{wide}}  {cells}  {found.limit.title if found.limit else '-'}")
    for text in end_texts:
        print_line(text)
    if recorded:
        print_line("Task, path and force goal of the recording were kept; its controller and gains were replaced.")


def _json_row(found: ControllerMetrics) -> dict[str, Any]:
    return {**asdict(found), "limit": found.limit.value if found.limit else None}


def _cell(column: str, value: Any) -> str:
    if value is None:
        return "-"
    return f"{100 * value:.1f} %" if column in ("lost", "limited") else f"{value:.3g}"
