"""Writes frames to a recording on a thread of its own, so that a slow disk delays nothing else."""

from __future__ import annotations

import queue
import threading
from collections.abc import Sequence

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import SessionInput

MOST_WAITING = 500
"""Frames that may wait to be written."""


class FrameRecording:
    """Hands frames over to a recorder. Mutable; used by one thread.

    Args:
        recorder: Writes them; the caller closes it after ``close``.
        lossless: True to wait where ``MOST_WAITING`` frames wait, for a file, which can be read more slowly; else a
            frame that finds no place is left out, and counted.

    Attributes:
        left_out: Number of frames that were left out.
        error: Why the recorder failed; None where it did not.
    """

    def __init__(self, recorder: Recorder, *, lossless: bool) -> None:
        self._recorder = recorder
        self._lossless = lossless
        # the thread's own: the session's list goes on growing
        self._inputs = InputLog()
        self._handed_over = 0
        self._queue: queue.Queue[tuple[Frame, Sequence[tuple[int, SessionInput]]] | None] = queue.Queue(MOST_WAITING)
        self.left_out = 0
        self.error: TactileMapsError | None = None
        self._thread = threading.Thread(target=self._loop, name="recording", daemon=True)
        self._thread.start()

    def put(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Record a frame and the session's inputs up to it."""
        try:
            self._queue.put((frame, tuple(inputs[self._handed_over :])), block=self._lossless)
        except queue.Full:
            self.left_out += 1
        else:
            self._handed_over = len(inputs)

    def close(self) -> None:
        """Wait until all is written; raises the error of the recorder."""
        self._queue.put(None)
        self._thread.join()
        if self.error is not None:
            raise self.error

    def _loop(self) -> None:
        while (item := self._queue.get()) is not None:
            if self.error is None:
                frame, inputs = item
                try:
                    for tick, session_input in inputs:
                        self._inputs.append(tick, session_input)
                    self._recorder.write(frame, self._inputs)
                except TactileMapsError as error:
                    self.error = error
