"""Recording of the running session: start, mark, stop, and the report of a session that failed."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.recorder import Recorder, save_failure_report
from tactile_widgets.session.recording_writer import DiskSpace, RecordingWriter, make_recording_folder
from tactile_widgets.session.session_run import ShownSession


class RecordingControl(QObject):
    """Records the running session.

    Args:
        session: The session that is shown.
        writer: Writes the file.
        parent: Qt parent.

    Attributes:
        writer: Writes the file.
        marks: Number of marks in the recording being written.
        for_viewers: True if new recordings contain the messages for viewers of other programs.
    """

    changed = Signal(object)
    """Path of the recording being written, or None."""
    disk_filling = Signal(DiskSpace)
    """Space left for the recording being written, below an hour, ten minutes and one minute."""
    failed = Signal(str)
    """Reason why a recording was not written, or not completed."""
    saved = Signal(str)
    """Path of a complete recording."""
    for_viewers_changed = Signal(bool)
    """True if new recordings contain the messages for viewers of other programs."""

    def __init__(self, session: ShownSession, writer: RecordingWriter, parent: QObject) -> None:
        super().__init__(parent)
        self._session = session
        self.writer = writer
        self.marks = 0
        self.for_viewers = True

    @property
    def recorder(self) -> Recorder | None:
        """The recorder of the recording being written; None if there is none."""
        return self.writer.recorder

    def set_for_viewers(self, *, on: bool) -> None:
        """Choose whether new recordings contain messages for viewers; the one being written does not change."""
        self.for_viewers = on
        self.for_viewers_changed.emit(on)

    def start(self, path: str | Path, *, overwrite: bool = False) -> None:
        """Record the tick that is shown and all later ones to a new file."""
        run = self._session.shown_run
        if run is None or self.recorder is not None:
            return
        measured = self._session.measured_from
        try:
            recorder = Recorder(run.prepared, path, overwrite=overwrite, viewers=self.for_viewers, measured=measured)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        with run.runner.lock:
            self.writer.begin(recorder)
            # Without the current frame, a file that is completed before the next tick, or while paused, would be empty.
            session = run.runner.session
            self.writer.write(session.frame, session.inputs)
        self.marks = 0
        self.changed.emit(str(path))

    def mark(self, name: str, tick: int | None = None) -> None:
        """Name a moment of the recording being written; by default the one that is shown."""
        shown = self._session.shown
        if self.recorder is None or shown is None:
            return
        try:
            mark = Mark(shown.tick if tick is None else tick, name)
        except TactileMapsError as error:
            self._session.report_failure(str(error))
            return
        self.writer.mark(mark)
        self.marks += 1

    def stop(self) -> None:
        """Complete the file in the background; ``saved`` is emitted when it is complete."""
        if self.recorder is None:
            return
        self.writer.end()
        self._report_closed()
        self.changed.emit(None)

    def check(self) -> None:
        """Report files that were completed, a failure to write, and a disk that is nearly full."""
        self._report_closed()
        if (torn := self.writer.take_failure()) is not None:
            self.failed.emit(str(torn))
            self.changed.emit(None)
        if (space := self.writer.take_warning()) is not None:
            self.disk_filling.emit(space)

    def close(self) -> None:
        """Complete the file and wait for it."""
        self.stop()
        self.writer.wait()
        self._report_closed()

    def _report_closed(self) -> None:
        for closed in self.writer.take_closed():
            if isinstance(closed, TactileMapsError):
                self.failed.emit(str(closed))
            else:
                self.saved.emit(str(closed))

    @property
    def can_report(self) -> bool:
        """True if the session that is shown has failed in a way that a report can reproduce."""
        run = self._session.shown_run
        return run is not None and run.runner.session.failure is not None

    def save_report(self, path: Path) -> None:
        """Write a recording that reproduces the failure of the session."""
        run = self._session.shown_run
        if run is None or not self.can_report:
            return
        try:
            make_recording_folder(path.parent)
            with run.runner.lock:
                save_failure_report(run.runner.session, path)
        except TactileMapsError as error:
            self._session.report_failure(str(error))
        else:
            self.saved.emit(str(path))
