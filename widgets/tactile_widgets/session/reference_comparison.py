"""Comparison of the running session with a finer reference run in the background."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Signal

from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import InputLog, TimedInput
from tactile_maps.session.reference_run import ReferenceRun
from tactile_maps.session.running_session import RunningSession
from tactile_widgets.jobs.executor import Job, Kept
from tactile_widgets.jobs.measuring_jobs import follow_session
from tactile_widgets.session.backends import Backends

_DIED = "The reference run ended unexpectedly. Switch it off and on to try again."


class ReferenceComparison(QObject):
    """Follows the session that is shown and compares the newest frame that it can, while it is switched on.

    Args:
        backends: Makes the process.
        parent: Qt parent.

    Attributes:
        executor: Runs the simulations.
    """

    compared = Signal(object)
    """ReferenceDifference of a frame that was shown."""
    behind = Signal(float)
    """Time between the reference and the frame that was shown [s]."""
    failed = Signal(str)
    """Reason why this session has no reference."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.executor = backends.executor("reference run", self)
        self._inputs: InputLog | None = None  # of the session that is followed
        self._run: Kept[ReferenceRun] | None = None
        self._given = 0
        self._enabled = False

    def set_enabled(self, enabled: bool) -> None:
        """Switch the comparison on or off; off ends the process."""
        if enabled != self._enabled:
            self._enabled = enabled
            self.close()

    def show_frame(self, session: RunningSession, frame: Frame) -> None:
        """Compare a frame of this session, unless the reference has not reached an earlier one yet."""
        if not self._enabled:
            return
        if session.inputs is not self._inputs:  # another session, or a reset one
            self.close()
            self._inputs = session.inputs
            self._run = Kept(partial(ReferenceRun, session.prepared, self._next(session.inputs, 0)))
        if self._run is not None and not self.executor.busy:
            inputs = self._next(session.inputs, frame.tick)
            job = Job(follow_session, self._run, inputs, frame, died=_DIED)
            self.executor.start(job, self.compared.emit, self._on_failed, received=self.behind.emit)

    def close(self) -> None:
        """End the process."""
        self.executor.close()
        self._inputs = None
        self._run = None
        self._given = 0

    def _next(self, inputs: InputLog, tick: int) -> tuple[TimedInput, ...]:
        """Return the inputs up to ``tick`` that have not been given yet."""
        first = self._given
        end = len(inputs)
        while self._given < end and inputs[self._given][0] <= tick:
            self._given += 1
        return tuple(inputs[first : self._given])

    def _on_failed(self, text: str) -> None:
        self.executor.close()
        self._run = None
        self.failed.emit(text)
