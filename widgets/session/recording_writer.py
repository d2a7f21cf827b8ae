"""What keeps a running session in a file, and what a file says about the session that ran."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from app.core.errors import RecordingError, TactileMapsError
from app.recording.recorder import Recorder
from app.session.frame import Frame
from app.session.inputs import SessionInput
from app.session.prepare import PreparedScene

Lock = AbstractContextManager[bool | None]


class RecordingWriter:
    """The recording being written, if there is one. Mutable, only under the runner's lock; two methods take it.

    Attributes:
        recorder: Where ticks go; None while nothing is recorded.
    """

    def __init__(self) -> None:
        self.recorder: Recorder | None = None
        self._torn: tuple[Recorder, TactileMapsError] | None = None

    def write(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Keep a tick. A file that takes no more is put aside and told by ``take_failure``; the session goes on."""
        if self.recorder is None:
            return
        try:
            self.recorder.write(frame, inputs)
        except TactileMapsError as error:
            self._torn, self.recorder = (self.recorder, error), None

    def begin(self, path: str | Path, prepared: PreparedScene, lock: Lock, *, overwrite: bool = False) -> None:
        """Write to a new file from now on. Raises RecordingError when it exists or cannot be written."""
        recorder = Recorder(path, prepared, overwrite=overwrite)
        with lock:
            self.recorder = recorder

    def complete(self, lock: Lock) -> Path:
        """Stop writing and complete the file, outside the lock; its path. Raises RecordingError when that fails."""
        with lock:
            recorder = self.take_recorder()
        assert recorder is not None
        recorder.close()
        return recorder.path

    def take_recorder(self) -> Recorder | None:
        """Stop writing; the recorder, to be closed by the caller outside the lock."""
        recorder, self.recorder = self.recorder, None
        return recorder

    def take_failure(self) -> TactileMapsError | None:
        """Why writing ended by itself since the last question; what was written by then stays readable."""
        if self._torn is None:
            return None
        (recorder, error), self._torn = self._torn, None
        recorder.abandon()
        return error


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
