"""Functions that read, label, cut and record recordings in the background."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from tactile_maps.core.errors import RecordingError, SimulationError, UsageError
from tactile_maps.core.files import check_output, make_output_folder, move_into_place
from tactile_maps.recording.encoding.annotations import save_annotations
from tactile_maps.recording.overview.curves import FrameQuantity, read_curves
from tactile_maps.recording.overview.raster import read_raster
from tactile_maps.recording.overview.summary import RecordingSummary, summarise
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import record
from tactile_maps.recording.trim import TrimResult, check_apart, trim, trim_episodes
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.catalogue import load_study
from tactile_widgets.jobs.executor import Report

READING_DIED = "Reading the recording ended unexpectedly. It may need more memory."


def send_curves(path: Path, chosen: tuple[FrameQuantity, ...], report: Report) -> None:
    """Send the curves of a whole recording, and the ``chosen`` quantities, in pieces: the share read, and the piece."""
    for piece in read_curves(path, chosen):
        report.part(piece)


def send_raster(path: Path, ticks: tuple[int, int], spans: int, report: Report) -> None:
    """Send the raster of all taxels in pieces: the share read, and the piece."""
    for piece in read_raster(path, ticks, spans):
        report.part(piece)


def send_summaries(paths: tuple[Path, ...], report: Report) -> None:
    """Send the summary of each recording."""
    for path in paths:
        report.part(summarise(path))


def annotate(path: Path, changes: dict[str, Any], _report: Report) -> RecordingSummary:
    """Change fields of a recording's ``Annotations``, and return its summary; without changes nothing is written."""
    if changes:
        player = RecordingPlayer(path)
        save_annotations(path, replace(player.annotations(), **changes), of=player.began)
    return summarise(path)


def open_player(path: Path, report: Report) -> RecordingPlayer:
    """Open a recording."""
    return RecordingPlayer(path, progress=report)


def save_part(source: Path, target: Path, ticks: tuple[int, int], scratch: Path, report: Report) -> list[TrimResult]:
    """Save the part of a recording between two ticks as a new file.

    Args:
        source: The recording.
        target: The new file; it is replaced.
        ticks: First and last tick.
        scratch: Folder for unfinished files, on the target's disk. It must not exist; if the process is ended, the
            caller removes it.
        report: Receives the progress.
    """
    check_apart(source, target)

    def write(folder: Path) -> list[TrimResult]:
        return [trim(source, folder / target.name, first=ticks[0], last=ticks[1], progress=report)]

    return _moved(scratch, target.parent, write, overwrite=True)


def save_labelled_episodes(source: Path, folder: Path, scratch: Path, report: Report) -> list[TrimResult]:
    """Save each labelled episode as a file in a folder; ``scratch`` as in ``save_part``."""
    player = RecordingPlayer(source)
    make_output_folder(folder, error=RecordingError)
    return _moved(scratch, folder, partial(trim_episodes, player, progress=report), overwrite=False)


def record_case(study: str, row: Row, target: Path, scratch: Path, report: Report) -> Path:
    """Simulate the run behind a row of a study again, and record it to a new file; ``scratch`` as in ``save_part``.

    A run that stops early is recorded up to there.
    """
    report(f"Preparing the case of {study}", 0.0)
    replay = load_study(study).replay
    if replay is None:
        raise UsageError("a row of this study is not of one run", value=study)
    make_output_folder(scratch, error=RecordingError)
    try:
        case = replay(row)
        part = scratch / target.name
        with record(case.session, part), suppress(SimulationError):
            case.play(report)
        move_into_place(part, target, error=RecordingError)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return target


def _moved(
    scratch: Path, folder: Path, write: Callable[[Path], list[TrimResult]], *, overwrite: bool
) -> list[TrimResult]:
    """Write files into ``scratch``, then move them into ``folder``.

    ``overwrite`` is set if the dialog has asked about the file; a dialog that asks for a folder has not.
    """
    make_output_folder(scratch, error=RecordingError)
    try:
        written = write(scratch)
        moved = [replace(one, file=str(folder / Path(one.file).name)) for one in written]
        for one in moved:  # check all before the first is moved
            try:
                check_output(Path(one.file), error=RecordingError, overwrite=overwrite)
            except RecordingError as error:
                raise error.at(remedy="Choose another folder, or remove this file first") from error
        for one, target in zip(written, moved, strict=True):
            move_into_place(Path(one.file), Path(target.file), error=RecordingError)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return moved
