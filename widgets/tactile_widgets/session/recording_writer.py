"""Writes a running session to a file: ticks are queued in memory, and a separate thread writes them to the disk."""

from __future__ import annotations

import errno
import shutil
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.core.files import try_writing
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import SessionInput

MOST_WAITING = 4000
"""Maximum number of ticks that wait for a slow disk: 20 s, about 40 MB for 1000 taxels."""

CHECK_SECONDS = 2.0
"""Time between checks of the file and of the remaining space [s]."""
WARN_BELOW = (3600.0, 600.0, 60.0)
"""Remaining recording times below which a warning is reported, each once [s]."""


@dataclass(frozen=True)
class DiskSpace:
    """Remaining space on a disk.

    Attributes:
        folder: Folder on the disk.
        free: Remaining space [bytes].
        seconds: Remaining time at the rate of the recording so far [s].
    """

    folder: Path
    free: int
    seconds: float


def free_space(folder: Path) -> int:
    """Return the remaining bytes on the disk of ``folder``."""
    return shutil.disk_usage(folder).free


_Inputs = tuple[tuple[int, SessionInput], ...]


class RecordingWriter:
    """The recording being written, if there is one. Mutable; ``write`` may be called from another thread.

    Args:
        free: Returns the remaining bytes on the disk of a folder.
        clock: Returns wall time [s].
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
        """Recorder of the current recording; None if there is none."""
        return None if self._file is None else self._file.recorder

    def begin(self, recorder: Recorder) -> None:
        """Write to a recorder until ``end``."""
        self._file = _OpenFile(recorder, self._free, self._clock)

    def write(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Record a tick, given all inputs since the session's reset. Never waits for the disk.

        If writing fails, the file keeps what was written, ``take_failure`` reports why, and the session continues.
        """
        if (file := self._file) is not None:
            file.put(frame, inputs)

    def mark(self, mark: Mark) -> None:
        """Record a mark after the ticks recorded so far."""
        if (file := self._file) is not None:
            file.put_mark(mark)

    def end(self) -> None:
        """Complete the file once all waiting ticks are written; ``take_closed`` reports it."""
        file = self._file
        self._file = None
        assert file is not None
        file.end()
        self._closing.append(file)

    def wait(self) -> None:
        """Wait until all ended files are complete."""
        for file in self._closing:
            file.join()

    def take_closed(self) -> list[Path | TactileMapsError]:
        """Return the files completed since the previous call, or the reasons why they could not be."""
        closed = [file for file in self._closing if file.closed]
        self._closing = [file for file in self._closing if file not in closed]
        return [file.error or file.recorder.path for file in closed]

    def take_failure(self) -> TactileMapsError | None:
        """Return the reason if writing failed since the previous call; what was written before stays readable."""
        file = self._file
        if file is None or file.error is None:
            return None
        self._file = None
        file.end()
        return file.error

    def take_warning(self) -> DiskSpace | None:
        """Return the remaining space if it is low, once per limit of ``WARN_BELOW``; None otherwise."""
        file = self._file
        if file is None:
            return None
        warning = file.warning
        file.warning = None
        return warning


class _OpenFile:
    """A recorder and the thread that writes to it. Mutable."""

    def __init__(self, recorder: Recorder, free: Callable[[Path], int], clock: Callable[[], float]) -> None:
        self.recorder = recorder
        self._free = free
        self._clock = clock
        self.error: TactileMapsError | None = None
        self.warning: DiskSpace | None = None
        self._start = self._checked = clock()
        self._start_bytes: int | None = None  # after the scene, which is written once
        self._warned_below = float("inf")
        self._handed_over = 0
        self._inputs = InputLog()  # a copy for the thread, because the session's list keeps growing
        self._queue: SimpleQueue[tuple[Frame, _Inputs] | Mark | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._loop, name="recording", daemon=True)
        self._thread.start()

    def put(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Queue a tick."""
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
        """Queue a mark."""
        if self.error is None:
            self._queue.put(mark)

    def end(self) -> None:
        """Close the file once the queue is written or discarded."""
        self._queue.put(None)

    def join(self) -> None:
        """Wait until the file is closed."""
        self._thread.join()

    @property
    def closed(self) -> bool:
        """True once the thread has ended."""
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
        """Check every ``CHECK_SECONDS`` that the file still exists, and how long the space lasts."""
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
            return  # unknown; a full disk is reported when writing fails
        seconds = free * (now - self._start) / written
        reached = min((limit for limit in WARN_BELOW if seconds < limit), default=float("inf"))
        if reached < self._warned_below:
            self._warned_below = reached
            self.warning = DiskSpace(folder, free, seconds)


class InlineRecordingWriter(RecordingWriter):
    """Completes files while the caller waits, for tests and pictures."""

    def end(self) -> None:
        """Complete the file and wait for it."""
        super().end()
        self.wait()


IN_PREFERENCES = " in Edit > Preferences"
"""Where the remedy of an unusable folder is, for the messages of the window."""


def make_recording_folder(folder: Path) -> None:
    """Create the folder of recordings, and check that a file can be written there.

    Raises:
        RecordingError: The folder cannot be created, or no file can be written there.
    """
    try:
        try_writing(folder)
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        choose = f"another folder of recordings{IN_PREFERENCES}"
        raise RecordingError(
            "no recording can be written to this folder",
            file=folder,
            # A file system like /proc reports that the new file does not exist, which explains nothing.
            value=None if error.errno == errno.ENOENT else error.strerror,
            remedy=f"Free space, or choose {choose}" if full else f"Choose {choose}",
        ) from error
