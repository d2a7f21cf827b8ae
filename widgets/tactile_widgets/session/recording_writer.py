"""Writes a running session to a file beside it: ticks are handed over in memory, a thread of its own meets the disk."""

from __future__ import annotations

import shutil
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import SessionInput

MOST_WAITING = 4000
"""Ticks that may wait for a slow disk: 20 s of them, about 40 MB for 1000 taxels."""

CHECK_SECONDS = 2.0
"""Between two looks at the file and the space that is left [s]."""
TOLD_AT = (3600.0, 600.0, 60.0)
"""Space for so many seconds of recording is left: each is told once [s]."""


@dataclass(frozen=True)
class DiskSpace:
    """How long the disk lasts at the rate of the recording so far.

    Attributes:
        folder: On the disk.
        free: Bytes left.
        seconds: For so long [s].
    """

    folder: Path
    free: int
    seconds: float


def free_space(folder: Path) -> int:
    """Bytes left on the disk of ``folder``."""
    return shutil.disk_usage(folder).free


_Inputs = tuple[tuple[int, SessionInput], ...]


class RecordingWriter:
    """The recording being written, if there is one. Mutable; ``write`` may be called from another thread.

    Args:
        free: Bytes left on the disk of a folder.
        clock: Wall time [s].
    """

    def __init__(
        self, *, free: Callable[[Path], int] = free_space, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._free = free
        self._clock = clock
        self._file: _OpenFile | None = None
        self._closing: list[_OpenFile] = []

    @property
    def recorder(self) -> Recorder | None:
        """Where ticks go; None while nothing is recorded."""
        return None if self._file is None else self._file.recorder

    def begin(self, recorder: Recorder) -> None:
        """Write there from now on, until ``end``."""
        self._file = _OpenFile(recorder, self._free, self._clock)

    def write(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Keep a tick, with all inputs since the session's reset. Never waits for the disk.

        A file that takes no more is left as it is and told by ``take_failure``; the session goes on.
        """
        if (file := self._file) is not None:
            file.put(frame, inputs)

    def mark(self, mark: Mark) -> None:
        """Keep a moment with a name, behind the ticks that were handed over."""
        if (file := self._file) is not None:
            file.put_mark(mark)

    def end(self) -> None:
        """Take no more ticks, and complete the file when what waits is written; ``take_closed`` tells of it."""
        file = self._file
        self._file = None
        assert file is not None
        file.end()
        self._closing.append(file)

    def wait(self) -> None:
        """Until every file that was ended is complete."""
        for file in self._closing:
            file.join()

    def take_closed(self) -> list[Path | TactileMapsError]:
        """The files completed since the last question, or why one could not be."""
        closed = [file for file in self._closing if file.closed]
        self._closing = [file for file in self._closing if file not in closed]
        return [file.error or file.recorder.path for file in closed]

    def take_failure(self) -> TactileMapsError | None:
        """Why writing ended by itself since the last question; what was written by then stays readable."""
        file = self._file
        if file is None or file.error is None:
            return None
        self._file = None
        file.end()
        return file.error

    def take_warning(self) -> DiskSpace | None:
        """That the disk will soon be full, once for each of ``TOLD_AT``; None where there is nothing to say."""
        file = self._file
        if file is None:
            return None
        warning = file.warning
        file.warning = None
        return warning


class _OpenFile:
    """One recorder and the thread that feeds it. Mutable."""

    def __init__(self, recorder: Recorder, free: Callable[[Path], int], clock: Callable[[], float]) -> None:
        self.recorder = recorder
        self._free = free
        self._clock = clock
        self.error: TactileMapsError | None = None
        self.warning: DiskSpace | None = None
        self._start = self._checked = clock()
        self._start_bytes: int | None = None  # behind the scene, which is written once
        self._told_at = float("inf")
        self._handed_over = 0
        self._inputs = InputLog()  # the thread's own: the session's list goes on growing
        self._queue: SimpleQueue[tuple[Frame, _Inputs] | Mark | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._loop, name="recording", daemon=True)
        self._thread.start()

    def put(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Hand a tick over."""
        if self.error is not None:
            return
        if self._queue.qsize() >= MOST_WAITING:
            self.error = RecordingError(
                "the disk is too slow for this recording",
                file=self.recorder.path,
                value=f"{MOST_WAITING} ticks wait to be written",
                remedy="Record to a faster disk; what was written so far can be read with recover",
            )
            return
        new = tuple(inputs[self._handed_over :])
        self._handed_over = len(inputs)
        self._queue.put((frame, new))

    def put_mark(self, mark: Mark) -> None:
        """Hand a moment with a name over."""
        if self.error is None:
            self._queue.put(mark)

    def end(self) -> None:
        """Close the file when all that was handed over is written, or refused."""
        self._queue.put(None)

    def join(self) -> None:
        """Wait until it is closed."""
        self._thread.join()

    @property
    def closed(self) -> bool:
        """Whether nothing more happens to it."""
        return not self._thread.is_alive()

    def _loop(self) -> None:
        while (item := self._queue.get()) is not None:
            if self.error is None:
                try:
                    self._write(item)
                except TactileMapsError as error:
                    self.error = error
        self._close()

    def _write(self, item: tuple[Frame, _Inputs] | Mark) -> None:
        if isinstance(item, Mark):
            self.recorder.mark(item)
            return
        frame, new = item
        for tick, session_input in new:
            self._inputs.append(tick, session_input)
        self.recorder.write(frame, self._inputs)
        self._check()

    def _close(self) -> None:
        if self.error is not None:
            self.recorder.abandon()
            return
        try:
            self.recorder.close()
        except TactileMapsError as error:
            self.error = error

    def _check(self) -> None:
        """Now and then: is the file still there, and how long will there be space."""
        now = self._clock()
        if self._start_bytes is None:
            self._start_bytes = self.recorder.bytes_written
        if now - self._checked < CHECK_SECONDS:
            return
        self._checked = now
        self.recorder.check_file()
        written = self.recorder.bytes_written - self._start_bytes
        if written <= 0:
            return
        folder = self.recorder.written.parent
        try:
            free = self._free(folder)
        except OSError:
            return  # nobody knows; a full disk is told when it is met
        seconds = free * (now - self._start) / written
        reached = min((limit for limit in TOLD_AT if seconds < limit), default=float("inf"))
        if reached < self._told_at:
            self._told_at = reached
            self.warning = DiskSpace(folder, free, seconds)


class InlineRecordingWriter(RecordingWriter):
    """Completes a file while the caller waits: for tests and pictures."""

    def end(self) -> None:
        """Take no more ticks, and complete the file."""
        super().end()
        self.wait()


def make_recording_folder(folder: Path) -> None:
    """Make the folder that recordings are kept in.

    Raises:
        RecordingError: It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordingError(
            "recordings cannot be kept there",
            file=folder,
            value=error.strerror,
            remedy="Free space or make the folder writable",
        ) from error
