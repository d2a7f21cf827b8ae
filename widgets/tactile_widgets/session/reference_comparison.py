"""The reference run beside the session that is shown, while somebody wants it."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import InputLog, TimedInput
from tactile_maps.session.running_session import RunningSession
from tactile_widgets.session.backends import Backends
from tactile_widgets.workers.reference_worker import ReferenceWorker
from tactile_widgets.workers.worker_process import Result, SourceToken


class ReferenceComparison(QObject):
    """Follows the session that is shown and compares what it can, of the frames shown always the newest.

    Nothing is done while nobody wants it.

    Args:
        backends: Makes the process.
        parent: Qt parent.

    Attributes:
        worker: Simulates.
    """

    compared = Signal(object)
    """The ReferenceDifference of a frame that was shown."""
    behind = Signal(float)
    """How far it still is from what was shown [s]."""
    failed = Signal(str)
    """Why there is no reference of this session."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.worker: ReferenceWorker = backends.reference_worker(self)
        self.worker.compared.connect(self._on_compared)
        self.worker.behind.connect(self._on_behind)
        self.worker.failed.connect(self._on_failed)
        self._token = SourceToken("reference run")
        self._inputs: InputLog | None = None  # of the session that is followed
        self._given = 0
        self._wanted = self._refused = False

    def set_wanted(self, wanted: bool) -> None:
        """Compare from now on, or not; the process ends with the wish."""
        if wanted != self._wanted:
            self._wanted = wanted
            self._end()

    def show_frame(self, session: RunningSession, frame: Frame) -> None:
        """Compare a frame of this session, unless the reference is still on its way to one before."""
        if not self._wanted:
            return
        if session.inputs is not self._inputs:  # another session, or it started again
            self._end()
            self._inputs = session.inputs
            self.worker.begin(session.prepared, self._next(session.inputs, 0), self._token)
        if not (self._refused or self.worker.busy):
            self.worker.follow(self._next(session.inputs, frame.tick), frame, self._token)

    def close(self) -> None:
        """End the process."""
        self._end()

    def _next(self, inputs: InputLog, tick: int) -> list[TimedInput]:
        """Those up to ``tick`` that have not been given yet."""
        first = self._given
        end = len(inputs)
        while self._given < end and inputs[self._given][0] <= tick:
            self._given += 1
        return inputs[first : self._given]

    def _end(self) -> None:
        self.worker.close()
        self._inputs = None
        self._given = 0
        self._refused = False
        self._token = self._token.next()

    def _on_compared(self, result: Result[object]) -> None:
        if result.token == self._token:
            self.compared.emit(result.value)

    def _on_behind(self, result: Result[float]) -> None:
        if result.token == self._token:
            self.behind.emit(result.value)

    def _on_failed(self, result: Result[str]) -> None:
        if result.token == self._token:
            self._refused = True
            self.failed.emit(result.value)
