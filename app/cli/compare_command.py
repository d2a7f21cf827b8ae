"""``compare``: run several laws on the same stimulus, and tell how each did."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

from app.cli.output import answer, facts, progress_line, say
from app.control.command import ControlSettings, LawName, TaskName
from app.control.contact_motion import settings_from
from app.control.settings_check import CHOICES, check_settings
from app.errors import RecordingError, UsageError
from app.recording.player import Player
from app.session.inputs import ControlChanged, SessionInput
from app.session.law_figures import LawFigures, law_figures, trace_csv
from app.session.law_trace import LawTrace
from app.session.open_scene import open_scene
from app.session.prepare import Prepared, prepare
from app.session.side_by_side import Contender, side_by_side
from app.toml.nearest import nearest
from app.whole_file import write_whole

SCRIPT_SECONDS = 10.0
"""Of a scene; a recording is compared on for as long as it is."""
_COLUMNS = {
    "map_rms_mm": "map mm",
    "body_rms_mm": "body mm",
    "force_rms_N": "force N",
    "force_max_N": "most N",
    "lost": "lost",
    "limited": "limited",
    "joint_speed_max": "rad/s",
    "control_ms": "ms",
}
"""What the table of a terminal shows, rms where several are known; the files have all."""
_FILE = "laws.csv"


def execute(arguments: argparse.Namespace) -> int:
    """Compare; 1 when a law stopped before its time."""
    laws = _laws(arguments.laws)
    prepared, inputs, base, seconds = _occasion(arguments.input)
    if arguments.task is not None:
        base = check_settings(replace(base, task=cast("TaskName", _known("task", arguments.task))))
    seconds = arguments.seconds or seconds
    contenders = [Contender(law, replace(base, law=cast("LawName", law))) for law in laws]
    own_task, progress = arguments.task is not None, progress_line()
    traces = side_by_side(prepared, contenders, inputs=inputs, seconds=seconds, own_task=own_task, progress=progress)
    file = _write(arguments.output, traces)
    figures = {trace.name: law_figures(trace) for trace in traces}
    ended = {trace.name: trace.ended for trace in traces if trace.ended}
    if arguments.json:
        answer({"seconds": seconds, "laws": {name: asdict(found) for name, found in figures.items()},
                "stopped": ended, "file": str(file) if file else None})  # fmt: skip
    else:
        _tell(figures, ended, recorded=inputs is not None)
        facts({"Written to": file} if file else {})
    return 1 if ended else 0


def _laws(text: str) -> list[str]:
    laws = [_known("law", name.strip()) for name in text.split(",") if name.strip()]
    if not laws or len(set(laws)) < len(laws):
        raise UsageError("laws to compare are named once each", place="--laws", value=text, remedy="Like hybrid,qp")
    return laws


def _known(choice: str, name: str) -> str:
    if name not in CHOICES[choice]:
        remedy = nearest(name, CHOICES[choice])
        raise UsageError(f"there is no such {choice}", place=f"--{choice}", value=name, remedy=remedy)
    return name


def _occasion(
    name: str,
) -> tuple[Prepared, Sequence[tuple[int, SessionInput]] | None, ControlSettings, float]:
    """The scene, what was done in it (None: its script), whose gains are taken, and for how long."""
    if Path(name).suffix.lower() == ".mcap":
        player = Player(name)
        begun = [act.settings for _, act in player.inputs if isinstance(act, ControlChanged)]
        return player.prepared, player.inputs, begun[0] if begun else ControlSettings(), float(player.times[-1])
    scene = open_scene(name)
    return prepare(scene, progress=progress_line()), None, settings_from(dict(scene.control)), SCRIPT_SECONDS


def _write(folder: str | None, traces: Sequence[LawTrace]) -> Path | None:
    if folder is None:
        return None
    path = Path(folder) / _FILE
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        remedy = "Choose a folder you may write to"
        raise RecordingError("the folder cannot be made", file=folder, value=error.strerror, remedy=remedy) from error
    write_whole(path, trace_csv(traces), error=RecordingError)
    return path


def _tell(figures: dict[str, LawFigures], ended: dict[str, str], *, recorded: bool) -> None:
    wide = max(len("law"), *(len(name) for name in figures))
    say(f"{'law':<{wide}}  " + "  ".join(f"{title:>8}" for title in _COLUMNS.values()) + "  limited most by")
    for name, found in figures.items():
        cells = "  ".join(f"{_words(column, getattr(found, column)):>8}" for column in _COLUMNS)
        say(f"{name:<{wide}}  {cells}  {found.limit or '-'}")
    for name, why in ended.items():
        say(f"{name} stopped after {figures[name].seconds:.2f} s: {why}")
    if recorded:
        say("Of the recording's settings, the task, its path and the force goal were kept; law and gains were not.")


def _words(column: str, value: Any) -> str:
    if value != value:  # NaN: there was nothing to measure
        return "-"
    return f"{100 * value:.1f} %" if column in ("lost", "limited") else f"{value:.3g}"
