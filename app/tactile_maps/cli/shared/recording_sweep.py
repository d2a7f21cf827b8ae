"""``run --sweep``: many short recordings of one scene with varied settings, and an index of them."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from functools import partial
from hashlib import blake2b
from pathlib import Path
from typing import Any

from tactile_maps.cli.shared.output import print_result, print_warning, progress_line
from tactile_maps.cli.shared.outputs import check_outputs_in
from tactile_maps.cli.shared.workers import workers_from_arguments
from tactile_maps.contacts.pipeline import reading_from
from tactile_maps.control.behaviours import behaviours_from
from tactile_maps.control.controller_registry import settings_from
from tactile_maps.core.errors import RecordingError, SceneError, TactileMapsError, UsageError
from tactile_maps.core.files import write_atomically
from tactile_maps.recording.sweep_recording import SweepRecording, record_case
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import scene_to_toml
from tactile_maps.scene.scene_sweep import SceneSweep, Settings, load_sweep, varied_scene
from tactile_maps.session.prepare import PreparedScene, check_stimuli
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.stimuli.stimulus import Stimulus
from tactile_maps.stimuli.stimulus_player import StimulusPlayer
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.running.case_log import CaseLog
from tactile_maps.studies.running.case_run import CaseRun, paced
from tactile_maps.studies.running.tables import csv_table, parquet_table

_CHECKED = 500
"""Number of variations that are checked before the simulation; errors of later ones are reported in the index."""


def record_sweep(scene: Scene, arguments: argparse.Namespace) -> int:
    """Record all missing variations; Ctrl-C keeps the complete recordings."""
    folder = _folder(arguments)
    sweep = load_sweep(arguments.sweep)
    sweep = replace(sweep, seconds=arguments.seconds or sweep.seconds)
    _check(scene, sweep, arguments.stimuli or arguments.scene_file or scene.name)
    with closing(CaseLog(folder / "index.cases.jsonl", resume=arguments.resume, overwrite=arguments.overwrite)) as log:
        if not (arguments.resume or arguments.overwrite):
            check_outputs_in(folder, [case["file"] for case in _cases(sweep)], overwrite=False)
        start = time.perf_counter()
        run = _run(scene, sweep, folder, log, arguments)
        seconds = time.perf_counter() - start
        log.end()
    files = _write_index(folder, run.rows)
    _report(run, seconds, files, folder, arguments)
    return 1 if all("problem" in row for row in run.rows) else 0


def _folder(arguments: argparse.Namespace) -> Path:
    """Folder of the recordings.

    Raises:
        UsageError: It is missing, it contains another run, or an option requires a single recording.
    """
    if arguments.serve or arguments.rerun:
        raise UsageError("a sweep cannot be shown in viewers", remedy="Leave out --serve and --rerun")
    if not arguments.output:
        raise UsageError("a sweep requires a folder for its recordings", place="--output", remedy="Add -o DIR")
    folder = Path(arguments.output)
    if (folder / "index.csv").exists() and not (arguments.resume or arguments.overwrite):
        remedy = "--resume records missing variations, --overwrite replaces all"
        raise UsageError("the folder contains recordings of a sweep", file=folder, remedy=remedy)
    return folder


def _check(scene: Scene, sweep: SceneSweep, name: str) -> None:
    """Check the first variations as a session would; stimuli only of those with the skin of the scene.

    Args:
        scene: The scene.
        sweep: Its variations.
        name: Name of the shipped scene, or the file with the stimuli.

    Raises:
        SceneError: A setting is invalid; the error names the file and key of the sweep, or of the scene.
    """
    checked: list[tuple[Stimulus, ...]] = [()]
    for settings in sweep.variants[:_CHECKED]:
        varied = varied_scene(scene, settings, file=sweep.file)
        try:
            settings_from(dict(varied.control))
            behaviours_from(varied.behaviours)
            reading_from(varied.reading)
        except TactileMapsError as error:
            raise error.at(file=sweep.file, place=f"vary.{error.place}" if error.place else "vary") from error
        if varied.stimuli not in checked and _skin_of(varied) == _skin_of(scene):
            checked.append(varied.stimuli)
            _check_stimuli(replace(prepare_cached(scene), scene=varied), settings, sweep, name)


def _skin_of(scene: Scene) -> tuple[object, ...]:
    """Return the settings of a scene that determine its skin."""
    return scene.robot, scene.taxel_files, scene.cover, scene.grids, scene.more_covers, scene.package_roots


def _check_stimuli(prepared: PreparedScene, settings: Settings, sweep: SceneSweep, name: str) -> None:
    """Raise the error of a stimulus at its key of the sweep if that varies it, else of the scene."""
    try:
        StimulusPlayer(prepared.skin, prepared.scene.stimuli, tick=prepared.scene.tick)
    except SceneError as error:
        place = error.place or ""
        if any(place == key or place.startswith(f"{key}.") for key in settings):
            raise error.at(file=sweep.file, place=f"vary.{place}") from error
        check_stimuli(prepared, name)


def _cases(sweep: SceneSweep) -> list[Mapping[str, Any]]:
    return [
        {"file": f"{number:06}.mcap", "seconds": sweep.seconds, **settings}
        for number, settings in enumerate(sweep.variants)
    ]


def _run(scene: Scene, sweep: SceneSweep, folder: Path, log: CaseLog, arguments: argparse.Namespace) -> CaseRun:
    for leftover in folder.glob(".tactile-maps-*.part"):
        leftover.unlink(missing_ok=True)  # of a killed run
    common = SweepRecording(scene, folder.absolute(), sweep.file, arguments.viewers)
    # Common settings are part of the name, so that no case of another scene counts as finished.
    name = f"{blake2b(scene_to_toml(scene).encode(), digest_size=16).hexdigest()} {arguments.viewers}"
    run = CaseRun(
        name,
        partial(record_case, common=common),
        _cases(sweep),
        workers=workers_from_arguments(arguments)[1],
        log=log,
        progress=progress_line(),
        watch=paced(lambda: _write_csv(folder, run.rows)),
        holds=lambda rows: all((folder / str(row["file"])).is_file() for row in rows),
    )
    try:
        run.go_on()
    except KeyboardInterrupt:
        if run.done:
            _write_csv(folder, run.rows)
            done = f"{run.done} of {len(run.cases)} recordings are complete"
            print_warning(f"{done}; continue with the same command and --resume")
        raise
    return run


def _write_csv(folder: Path, rows: Sequence[Row]) -> Path:
    path = folder / "index.csv"
    write_atomically(path, csv_table(rows), error=RecordingError)
    return path


def _write_index(folder: Path, rows: Sequence[Row]) -> list[Path]:
    files = [_write_csv(folder, rows)]
    data = parquet_table(rows)
    if data is not None:
        files.append(folder / "index.parquet")
        write_atomically(files[-1], data, error=RecordingError)
    return files


def _report(run: CaseRun, seconds: float, files: list[Path], folder: Path, arguments: argparse.Namespace) -> None:
    failed = sum("problem" in row for row in run.rows)
    complete = {row["file"] for row in run.rows if "problem" not in row}
    others = sum(path.name not in complete for path in folder.glob("*.mcap"))
    if others:
        print_warning(f"{folder} contains {others} recordings that are not part of this sweep")
    if failed:
        print_warning(f"{failed} variations could not be recorded: the index states the problem of each")
    before = f", {run.known} of them before" if run.known else ""
    result = {
        "files": [str(file) for file in files],
        "recordings": len(complete),
        "known": run.known,
        "failed": failed,
        "seconds": seconds,
    }
    rows = {"Recorded": f"{len(complete)} in {seconds:.1f} s{before}", "Failed": failed, "Index": result["files"]}
    print_result(result, rows, as_json=arguments.json)
