"""Writes a session to a file while it runs, so that what was recorded survives a crash.

``record`` writes a session within a block. ``save_failure_report`` saves what stopped a session, as a recording that
stops in the same way when it is replayed.
"""

from __future__ import annotations

import platform
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import version
from itertools import takewhile
from pathlib import Path
from types import TracebackType

from mcap.writer import CompressionType, Writer

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.interrupts import interrupts_held
from tactile_maps.recording.encoding.annotations import Mark
from tactile_maps.recording.encoding.frame_codec import encode_frame
from tactile_maps.recording.encoding.message_codecs import encode_event, encode_failure, encode_input, encode_mark
from tactile_maps.recording.encoding.viewer_messages import ViewerMessages
from tactile_maps.recording.file.mcap_file import MEASURED, NO_SPACE, STARTED, add_viewer_channels, begin_recording
from tactile_maps.recording.file.recording_file import RecordingFile
from tactile_maps.recording.machine import machine_facts
from tactile_maps.session.bundle import pack_scene
from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.inputs import MapEdited, SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.running_session import RunningSession

FRAMES_A_CHUNK = 6
"""A killed process loses at most the frames of the chunk being filled."""


class Recorder:
    """A recording being written. Mutable; ``close`` completes the file. Also a context manager.

    A block that ends with an exception, including Ctrl-C, does not replace an existing file: the new recording is
    completed as ``written``, and a note on the exception names both files. Ctrl-C is delayed until the current write is
    complete.

    The file is created and locked at once, see ``RecordingFile``. The robot, skin, map and scene are written and
    flushed with the first tick, then chunks of a few frames, each flushed when full. A recording without a frame is
    removed when it is closed.

    Args:
        prepared: The scene of the session.
        path: The file; it must not exist.
        overwrite: Replace an existing file once the new recording is complete.
        viewers: Also write messages for viewers of other programs, see ``viewer_messages``; replays do not need them.
        started: Wall-clock time of the session's tick 0 [ns since 1970], the zero of the file's times; by default now.
        measured: Source of the readings of a real skin; None if they are simulated.

    Raises:
        RecordingError: The file exists, another program writes it, or it cannot be written.

    Cost: about 0.05 ms per frame of 1000 taxels, twice that with messages for viewers; for the first frame 0.1 to 1 s,
    in which robot and map are compressed.
    """

    def __init__(
        self,
        prepared: PreparedScene,
        path: str | Path,
        *,
        overwrite: bool = False,
        viewers: bool = True,
        started: int | None = None,
        measured: str | None = None,
    ) -> None:
        self._measured = {} if measured is None else {MEASURED: measured}
        self.path = Path(path)
        self.frames = 0
        self._started = time.time_ns() if started is None else started
        self._for_viewers = viewers
        self._viewers: ViewerMessages | None = None  # created by ``_begin``
        self.tick = prepared.scene.tick
        self._inputs = 0
        self._map = prepared.map
        self._first = self._latest = -1
        self._prepared: PreparedScene | None = prepared  # until it is written
        self._file = RecordingFile(self.path, overwrite=overwrite)
        self._stream = self._file.stream
        frame_bytes = 8 * (len(prepared.skin) + 6 * len(prepared.robot.joints)) + 256
        self._writer = Writer(
            self._stream,
            chunk_size=FRAMES_A_CHUNK * frame_bytes,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )

    def _begin(self) -> None:
        """Write the beginning of the file at the first message, so that only the writing thread waits for it."""
        prepared = self._prepared
        self._prepared = None
        if prepared is None:
            return
        scene = prepared.scene
        metadata = versions() | machine_facts()
        metadata |= {"seed": str(scene.seed), "tick_s": repr(scene.tick), STARTED: str(self._started)}
        metadata |= self._measured
        try:
            channels = begin_recording(self._writer, metadata, pack_scene(prepared))
            if self._for_viewers:
                self._viewers = ViewerMessages(prepared, started=self._started)
                channels = {**channels, **add_viewer_channels(self._writer, self._viewers.schemas)}
            self._channels = channels
            self._numbers = dict.fromkeys(channels, 0)
            self._stream.flush()
        except OSError as error:
            self.abandon()
            problem = "the recording cannot be written"
            remedy = "Free space or choose another folder"
            raise RecordingError(problem, file=self.written, value=error.strerror, remedy=remedy) from error

    def write(self, frame: Frame, inputs: Sequence[tuple[int, SessionInput]]) -> None:
        """Add a frame and the inputs and contact events of the session that are not in the file yet.

        Args:
            frame: The newest frame.
            inputs: All inputs of the session since its reset.

        Raises:
            RecordingError: The disk is full or the file is gone; the file stays readable up to there.
        """
        with interrupts_held():
            self._begin()
            new = takewhile(lambda event: event.tick > self._latest, frame.recent)
            events = [("/event", event.tick, encode_event(event)) for event in new][::-1]
            shown = self._shown(frame, inputs[self._inputs :])
            self._add(inputs, *events, ("/frame", frame.tick, encode_frame(frame)), *shown)
            if not self.frames:
                self._first = frame.tick
            self._latest = frame.tick
            self.frames += 1

    def mark(self, mark: Mark) -> None:
        """Add a mark, after the frame of its tick.

        Raises:
            RecordingError: Same as for ``write``.
        """
        with interrupts_held():
            self._put([("/mark", mark.tick, encode_mark(mark))])

    def fail(self, failure: Failure) -> None:
        """Add the error that stopped the session and the inputs of its last tick, so that a replay stops as well.

        If there is no frame yet, the last good frame is written first.

        Raises:
            RecordingError: Same as for ``write``.
        """
        if not self.frames:
            self.write(failure.frame, [item for item in failure.inputs if item[0] < failure.tick])
        shown = [] if self._viewers is None else self._viewers.of_failure(failure)
        messages = [("/failure", encode_failure(failure.tick, failure.error)), *shown]
        with interrupts_held():
            self._add(failure.inputs, *((topic, failure.tick, data) for topic, data in messages))

    def _shown(self, frame: Frame, news: Sequence[tuple[int, SessionInput]]) -> list[tuple[str, int, bytes]]:
        """Return the messages of a frame for viewers; ``news`` are the inputs since the previous frame."""
        if self._viewers is None:
            return []
        for _, session_input in news:
            if isinstance(session_input, MapEdited):
                self._viewers.use_map(session_input.map)
        messages = self._viewers.of(frame)
        if not self.frames:
            messages = self._viewers.opening(frame.tick) + messages
        return [(topic, frame.tick, data) for topic, data in messages]

    def _add(self, inputs: Sequence[tuple[int, SessionInput]], *more: tuple[str, int, bytes]) -> None:
        """Write inputs that are not in the file yet, then other messages (topic, tick, data)."""
        news = [
            ("/input", tick, encode_input(tick, session_input, self._map))
            for tick, session_input in inputs[self._inputs :]
        ]
        self._put([*news, *more])
        self._inputs = len(inputs)

    def _put(self, messages: Sequence[tuple[str, int, bytes]]) -> None:
        """Write messages (topic, tick, data)."""
        self._begin()
        try:
            for topic, tick, data in messages:
                at = self._started + round(1e9 * tick * self.tick)
                # Running numbers of each topic reveal lost messages.
                self._writer.add_message(self._channels[topic], at, data, at, self._numbers[topic])
                self._numbers[topic] += 1
            self._stream.flush()
        except OSError as error:
            problem = "the recording cannot be written further"
            raise RecordingError(problem, file=self.written, value=error.strerror, remedy=NO_SPACE) from error

    @property
    def written(self) -> Path:
        """The file being written: different from ``path`` while an existing file is being replaced."""
        return self._file.written

    @property
    def seconds(self) -> float:
        """Time from the first frame to the newest one [s]."""
        return (self._latest - self._first) * self.tick

    @property
    def bytes_written(self) -> int:
        """Number of bytes written so far."""
        return self._stream.tell()

    def check_file(self) -> None:
        """Check that the file still exists: writing to a removed file does not fail.

        Raises:
            RecordingError: The file was removed or replaced.
        """
        if not self._file.is_present():
            problem = "the recording was removed or replaced while it was written"
            remedy = "Record again; do not move a recording before it is complete"
            raise RecordingError(problem, file=self.written, remedy=remedy)

    def close(self, *, replace: bool = True) -> None:
        """Complete the file with its index; remove one without a frame. Closing it again has no effect.

        Args:
            replace: Replace an existing file; False to keep it, and the new recording as ``written``.

        Raises:
            RecordingError: The last bytes could not be written, or the file was removed meanwhile.
        """
        if self._stream.closed:
            return
        with interrupts_held():
            self._complete(replace=replace)

    def _complete(self, *, replace: bool) -> None:
        if not self.frames:
            self._file.discard()
            return
        try:
            self._writer.finish()
            self._stream.flush()
            self.check_file()
            self._file.complete(replace=replace)
        except RecordingError:
            self.abandon()
            raise
        except OSError as error:
            self.abandon()
            problem = "the recording could not be completed"
            raise RecordingError(problem, file=self.written, value=error.strerror, remedy=NO_SPACE) from error

    def abandon(self) -> None:
        """Close a file that cannot grow, without completing it; remove one without a frame."""
        if self.frames:
            self._file.abandon()
        else:
            self._file.discard()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        both_kept = self._file.replaces and self.frames > 0
        try:
            self.close(replace=kind is None)
        except RecordingError as failure:
            error = failure
            raise
        finally:
            if both_kept and error is not None:
                error.add_note(f"{self.path} is unchanged; the new recording up to here is {self.written}")


def versions() -> dict[str, str]:
    """Return what the numbers depend on: versions of programs and libraries, and the kind of machine."""
    names = ("tactile-maps", "numpy", "scipy", "libigl")
    return {name: version(name) for name in names} | {
        "mujoco": version("mujoco-core"),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }


def save_failure_report(session: RunningSession, path: str | Path) -> Path:
    """Write why ``session`` stopped: its scene, all inputs, the last good frame and the error; return the file's path.

    The report can be replayed and verified: the simulation of the inputs must stop at the same tick with the same
        error.

    Args:
        session: A session whose ``failure`` is set.
        path: The file; it must not exist.
        overwrite: Replace an existing file.

    Raises:
        RecordingError: The session did not stop by itself, or the file cannot be written.
    """
    failure = session.failure
    if failure is None:
        raise RecordingError("the session did not stop by itself, so there is nothing to report", file=path)
    with Recorder(session.prepared, path, viewers=False) as recorder:
        recorder.fail(failure)
    return Path(path)


@contextmanager
def record(
    session: RunningSession, path: str | Path, *, overwrite: bool = False, viewers: bool = True
) -> Iterator[Recorder]:
    """Write every tick of ``session`` to a file while the block runs, including the current frame.

    If the simulation fails, the file contains the error, and a replay stops at the same tick.

    Args:
        session: The session.
        path: The file, usually ``.mcap``; it must not exist.
        overwrite: Replace an existing file.
        viewers: Also write messages for viewers of other programs, see ``Recorder``.

    Raises:
        RecordingError: The file exists or cannot be written.

    Example:
        >>> with tm.record(session, "touch.mcap") as recording:
        ...     frame = session.run_for(0.1)
        >>> recording.frames
        21
    """
    with Recorder(session.prepared, path, overwrite=overwrite, viewers=viewers) as recorder:
        recorder.write(session.frame, session.inputs)
        with session.watched(lambda frame: recorder.write(frame, session.inputs)):
            try:
                yield recorder
            finally:
                if session.failure is not None:
                    recorder.fail(session.failure)
