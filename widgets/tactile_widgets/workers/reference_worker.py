"""A process beside the window that simulates the running session once more, finer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import SimulationError, TactileMapsError
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import TimedInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.reference_run import ReferenceRun
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_DIED = "The reference run ended unexpectedly. Switch it off and on to try again."
_TELL_EVERY = 0.2
"""Wall seconds after which it says how far it has come."""


@dataclass(frozen=True, eq=False)
class _Begin:
    """A session of ``prepared``, with the inputs of its tick 0."""

    prepared: PreparedScene
    inputs: tuple[TimedInput, ...]


@dataclass(frozen=True, eq=False)
class _Follow:
    """Up to a frame of it, with the inputs since the one before."""

    inputs: tuple[TimedInput, ...]
    frame: Frame


def make_handler() -> RequestHandler:
    """In the process: a session's beginning and then its frames in, differences out."""
    runs: list[ReferenceRun] = []

    def serve(request: object, tell: Reply) -> None:
        if isinstance(request, _Begin):
            runs[:] = [ReferenceRun(request.prepared, request.inputs)]
        elif isinstance(request, _Follow):
            if not runs:  # its process died while nothing was asked of it, and this is another
                raise SimulationError(_DIED)
            run = runs[0]
            run.take(request.inputs)
            while not run.advance(request.frame.tick, _TELL_EVERY):
                tell("behind", request.frame.time - run.time)
            tell("compared", run.compare(request.frame))

    return serve


class ReferenceWorker(QObject):
    """Follows one session, one frame at a time.

    ``close`` ends the process.
    """

    compared = Signal(object)
    """The Result with the ReferenceDifference of a frame that was asked for."""
    behind = Signal(object)
    """The Result with how far it still is from that frame [s]."""
    failed = Signal(object)
    """The Result with why there is no reference; there will be none until ``begin``."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("reference_worker", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)

    @property
    def busy(self) -> bool:
        """Whether it has not come to the last frame yet."""
        return self.process.waiting > 0

    def begin(self, prepared: PreparedScene, inputs: Sequence[TimedInput], token: SourceToken) -> None:
        """Follow another session, from its start.

        Cost: beside, as opening its scene; a process.
        """
        self.process.close()
        self.process.send(_Begin(prepared, tuple(inputs)), token)

    def follow(self, inputs: Sequence[TimedInput], frame: Frame, token: SourceToken) -> None:
        """Go on to a frame of it.

        Args:
            inputs: Those since the frame before.
            frame: To compare.
            token: What it is for.
        """
        self.process.send(_Follow(tuple(inputs), frame), token)

    def close(self) -> None:
        """End the process, whatever it does."""
        self.process.close()

    def _on_answered(self, _number: int, kind: str, result: Result[Any]) -> None:
        if kind == "failed":
            self.process.close()
            self.failed.emit(result)
        elif kind == "compared":
            self.compared.emit(result)
        elif kind == "behind":
            self.behind.emit(result)

    def _on_ended(self, token: SourceToken) -> None:
        self.failed.emit(Result(token, _DIED))


class InlineReferenceWorker(ReferenceWorker):
    """Simulates at once, while the caller waits: deterministic, for tests and pictures."""

    @property
    def busy(self) -> bool:
        """Never."""
        return False

    def begin(self, prepared: PreparedScene, inputs: Sequence[TimedInput], token: SourceToken) -> None:
        """Follow another session."""
        self._serve(make_handler(), _Begin(prepared, tuple(inputs)), token)

    def follow(self, inputs: Sequence[TimedInput], frame: Frame, token: SourceToken) -> None:
        """Go on to a frame."""
        self._serve(self._handler, _Follow(tuple(inputs), frame), token)

    def _serve(self, handler: RequestHandler, request: object, token: SourceToken) -> None:
        self._handler = handler
        try:
            handler(request, lambda kind, content: self._on_answered(0, kind, Result(token, content)))
        except TactileMapsError as error:
            self.failed.emit(Result(token, str(error)))
