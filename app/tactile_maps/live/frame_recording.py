"""Writes frames to a recording on a separate thread, so that a slow disk delays nothing else."""

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
"""Maximum number of frames in the queue."""


class FrameRecording:
    """Queue between a session and a recorder. Mutable; used by one thread.

    Args:
        recorder: Recorder of the frames; the caller closes it after ``close``.
        lossless: Whether ``put`` waits while the queue is full, for a file, which can be read more slowly. Otherwise
            the frame is dropped and counted.

    Attributes:
        left_out: Number of dropped frames.
        error: Error of the recorder; None if it has not failed.
    """

    def __init__(self, recorder: Recorder, *, lossless: bool) -> None:
        self._recorder = recorder
        self._lossless = lossless
        self._inputs = InputLog()  # separate from the session's list, which keeps growing
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
        """Wait until all frames are written; raises the error of the recorder."""
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
