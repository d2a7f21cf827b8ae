"""A process for what is read out of recordings and cut from them: curves, summaries, parts. The window never waits."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import RecordingError, SimulationError, TactileMapsError, UsageError
from tactile_maps.core.files import check_output, make_output_folder, move_into_place
from tactile_maps.core.progress import Progress
from tactile_maps.recording.encoding.annotations import Annotations, Outcome, save_annotations
from tactile_maps.recording.overview.curves import FrameQuantity, read_curves
from tactile_maps.recording.overview.summary import summarise
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import record
from tactile_maps.recording.trim import TrimResult, check_apart, trim, trim_episodes
from tactile_maps.studies.base.rows import Row
from tactile_maps.studies.catalogue import load_study
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_DIED = "Reading the recording ended unexpectedly. It may need more memory."


@dataclass(frozen=True)
class ReadCurves:
    """The curves of a whole recording, and what was ``chosen``; answered by ``curves``: the share read, and a piece."""

    path: Path
    chosen: tuple[FrameQuantity, ...] = ()


@dataclass(frozen=True)
class Summarise:
    """What each of these recordings is; answered by a ``summary`` for each."""

    paths: tuple[Path, ...]


@dataclass(frozen=True)
class Annotate:
    """Say something of a recording that is not shown; answered by its ``summary`` as it is then.

    Attributes:
        path: The recording.
        outcome: How it ended.
        label: What it is.
        changes: Whether to keep this, or only to look at the recording again.
    """

    path: Path
    outcome: Outcome | Literal["as it is"] | None = "as it is"
    label: str | None = None
    changes: bool = True

    def applied(self, to: Annotations) -> Annotations:
        """What is said then."""
        outcome = to.outcome if self.outcome == "as it is" else self.outcome
        return replace(to, outcome=outcome, label=to.label if self.label is None else self.label)


@dataclass(frozen=True)
class OpenOther:
    """Another recording beside the one that is shown; answered by ``opened``."""

    path: Path


@dataclass(frozen=True)
class Trim:
    """A part of a recording as a new file; answered by ``trimmed``: the list of what was written.

    Attributes:
        source: The recording.
        target: The new file.
        first: Tick.
        last: Tick.
        scratch: A folder that is not there yet, on the target's disk: whoever ends the process removes it.
    """

    source: Path
    target: Path
    first: int
    last: int
    scratch: Path


@dataclass(frozen=True)
class TrimEpisodes:
    """Each labelled episode as a file in a folder; answered by ``trimmed``. Its scratch is as that of ``Trim``."""

    source: Path
    folder: Path
    scratch: Path


@dataclass(frozen=True)
class ReplayCase:
    """The run behind a row of a study, simulated anew and recorded; answered by ``replayed``: the file.

    Attributes:
        study: Its name.
        row: The row.
        target: The new file.
        scratch: As that of ``Trim``.
    """

    study: str
    row: Row
    target: Path
    scratch: Path


def make_handler() -> RequestHandler:
    """In the process: what is asked of recordings in; answers out as they come."""

    def serve(request: object, tell: Reply) -> None:
        def progress(text: str, done: float) -> None:
            tell("progress", (text, done))

        if isinstance(request, ReadCurves):
            for piece in read_curves(request.path, request.chosen):
                tell("curves", piece)
        elif isinstance(request, Summarise):
            for path in request.paths:
                tell("summary", summarise(path))
        elif isinstance(request, Annotate):
            if request.changes:
                player = RecordingPlayer(request.path)
                save_annotations(request.path, request.applied(player.annotations()), of=player.began)
            tell("summary", summarise(request.path))
        elif isinstance(request, OpenOther):
            tell("opened", RecordingPlayer(request.path, progress=progress))
        elif isinstance(request, Trim):
            check_apart(request.source, request.target)

            def write_part(scratch: Path) -> list[TrimResult]:
                part = scratch / request.target.name
                return [trim(request.source, part, first=request.first, last=request.last, progress=progress)]

            tell("trimmed", _moved(request.scratch, request.target.parent, write_part, overwrite=True))
        elif isinstance(request, ReplayCase):
            tell("replayed", _replayed(request, progress))
        elif isinstance(request, TrimEpisodes):
            player = RecordingPlayer(request.source)
            make_output_folder(request.folder, error=RecordingError)
            write = partial(trim_episodes, player, progress=progress)
            tell("trimmed", _moved(request.scratch, request.folder, write, overwrite=False))

    return serve


def _replayed(request: ReplayCase, progress: Progress) -> Path:
    """Simulate and record a case in a folder of its own, then give the file its name; a run that stops is kept too."""
    progress(f"Preparing the case of {request.study}", 0.0)
    replay = load_study(request.study).replay
    if replay is None:
        raise UsageError("a row of this study is not of one run", value=request.study)
    make_output_folder(request.scratch, error=RecordingError)
    try:
        case = replay(request.row)
        part = request.scratch / request.target.name
        with record(case.session, part), suppress(SimulationError):
            case.play(progress)
        move_into_place(part, request.target, error=RecordingError)
    finally:
        shutil.rmtree(request.scratch, ignore_errors=True)
    return request.target


def _moved(
    scratch: Path, folder: Path, write: Callable[[Path], list[TrimResult]], *, overwrite: bool
) -> list[TrimResult]:
    """Let files be written into a folder of their own, then take them into ``folder`` under their names.

    ``overwrite`` is set where the dialog has asked about the file; one that asks for a folder has not.
    """
    make_output_folder(scratch, error=RecordingError)
    try:
        written = write(scratch)
        moved = [replace(one, file=str(folder / Path(one.file).name)) for one in written]
        for one in moved:  # all of them before the first is moved
            check_output(Path(one.file), error=RecordingError, overwrite=overwrite)
        for one, target in zip(written, moved, strict=True):
            move_into_place(Path(one.file), Path(target.file), error=RecordingError)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    return moved


class RecordingWorker(QObject):
    """Does one thing after the other; ``close`` gives up all of it and ends the process."""

    answered = Signal(str, object)
    """The kind of an answer, also ``failed`` and at last ``done``, and the Result with its content."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._process = WorkerProcess("recordings", make_handler, self)
        self._process.answered.connect(self._on_answered)
        self._process.ended.connect(self._on_ended)

    def ask(self, request: object, token: SourceToken) -> None:
        """Do this, after what was asked for before."""
        self._process.send(request, token)

    def close(self) -> None:
        """Give up what was asked for; nothing of it is answered any more."""
        self._process.close()

    def _on_answered(self, _number: int, kind: str, result: Result[object]) -> None:
        self.answered.emit(kind, result)

    def _on_ended(self, token: SourceToken) -> None:
        self.answered.emit("failed", Result(token, _DIED))
        self.answered.emit("done", Result(token, None))


class InlineRecordingWorker(RecordingWorker):
    """Works at once, while the caller waits: deterministic, for tests and pictures."""

    def ask(self, request: object, token: SourceToken) -> None:
        """Do it now."""

        def tell(kind: str, content: object) -> None:
            self.answered.emit(kind, Result(token, content))

        try:
            make_handler()(request, tell)
        except TactileMapsError as error:
            tell("failed", str(error))
        tell("done", None)
