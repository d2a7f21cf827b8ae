"""A process beside the window that runs several controllers on the same stimulus, and that stimulus as a value."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.studies.controller_comparison import Contender, compare_controllers
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess


@dataclass(frozen=True, eq=False)
class ComparisonStimulus:
    """A scene and what was done in it.

    Attributes:
        prepared: The scene.
        inputs: (tick, input) from its start; None for its own script.
        seconds: How long it lasted, or is to last.
        file: Name of the recording it is from; empty for none.
    """

    prepared: PreparedScene
    inputs: tuple[tuple[int, SessionInput], ...] | None
    seconds: float
    file: str = ""

    @property
    def touches(self) -> int:
        """How often the skin was, or is to be, touched."""
        if self.inputs is None:
            return len(self.prepared.scene.stimuli)
        return sum(isinstance(act, PokePressed) for _, act in self.inputs)

    @property
    def words(self) -> str:
        """Like "12.4 s, 3 touches"."""
        touches = f"{self.touches} touch{'es' * (self.touches != 1)}" if self.touches else "no touch"
        return f"{touches}, again and again" if self.inputs is None else f"{self.seconds:.1f}\u202fs, {touches}"


_DIED = "The comparison ended unexpectedly; earlier results are kept. Run it again, for fewer seconds."


@dataclass(frozen=True, eq=False)
class ComparisonRequest:
    """Who is compared on what, for how long, and whose task they do; see ``compare_controllers``."""

    occasion: ComparisonStimulus
    contenders: tuple[Contender, ...]
    seconds: float
    own_task: bool


@dataclass(frozen=True)
class ReadStimulus:
    """Take a stimulus from a recording."""

    path: Path


def make_handler() -> RequestHandler:
    """In the process: recordings and matches in; progress, stimuli and traces out."""

    def serve(request: Any, tell: Reply) -> None:
        if isinstance(request, ReadStimulus):
            player = RecordingPlayer(request.path, progress=lambda *how: tell("reading", how))
            last = float(player.times[-1])
            tell("read", ComparisonStimulus(player.prepared, tuple(player.inputs), last, request.path.name))
            return
        match: ComparisonRequest = request
        traces = compare_controllers(
            match.occasion.prepared,
            match.contenders,
            inputs=match.occasion.inputs,
            seconds=match.seconds,
            own_task=match.own_task,
            progress=lambda *how: tell("progress", how),
        )
        tell("compared", traces)

    return serve


class ComparisonWorker(QObject):
    """Runs one match at a time, or reads what to run it on.

    In a process of its own, so that nothing of the window disturbs its clock.
    """

    progressed = Signal(str, float)
    """How far it is: seconds in words, and 0 to 1."""
    compared = Signal(object)
    """The Result with a ControllerTrace of each contender."""
    reading = Signal(str, float)
    """A recording is being read: what is done, and how far it is, 0 to 1."""
    read = Signal(object)
    """The Result with the ComparisonStimulus of a recording."""
    failed = Signal(object)
    """The Result with why there is neither."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("compare controllers", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)

    @property
    def busy(self) -> bool:
        """Whether controllers are being run."""
        return bool(self.process.waiting)

    def run(self, match: ComparisonRequest, token: SourceToken) -> None:
        """Run these controllers; what was being run is dropped."""
        self.close()
        self.progressed.emit("starting", 0.0)
        self._request(match, token)

    def read_stimulus(self, path: Path, token: SourceToken) -> None:
        """Take a stimulus from a recording; what was being run is dropped. Cost: 20 ms a recorded second, beside."""
        self.close()
        self.reading.emit("starting", 0.0)
        self._request(ReadStimulus(path), token)

    def _request(self, request: ComparisonRequest | ReadStimulus, token: SourceToken) -> None:
        self.process.send(request, token)

    def close(self) -> None:
        """End the process, whatever it does."""
        self.process.close()

    def _on_answered(self, _number: int, kind: str, result: Result[Any]) -> None:
        if kind == "progress":
            self.progressed.emit(*result.value)
        elif kind == "reading":
            self.reading.emit(*result.value)
        elif kind != "done":
            self.close()
            {"compared": self.compared, "read": self.read, "failed": self.failed}[kind].emit(result)

    def _on_ended(self, token: SourceToken) -> None:
        self.close()
        self.failed.emit(Result(token, _DIED))


class InlineComparisonWorker(ComparisonWorker):
    """Runs them at once, while the caller waits: deterministic, for tests and pictures."""

    def _request(self, request: ComparisonRequest | ReadStimulus, token: SourceToken) -> None:
        def tell(kind: str, content: object) -> None:
            self._on_answered(0, kind, Result(token, content))

        try:
            make_handler()(request, tell)
        except TactileMapsError as error:
            tell("failed", str(error))
