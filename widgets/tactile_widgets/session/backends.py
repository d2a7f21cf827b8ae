"""Runners, writers and executors that do the window's work: in threads and processes, or inline for tests."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject

from tactile_widgets.jobs.executor import Executor, InlineExecutor, ProcessExecutor
from tactile_widgets.session.live_input import InlineReadingsRunner, ThreadReadingsRunner
from tactile_widgets.session.recording_writer import InlineRecordingWriter, RecordingWriter
from tactile_widgets.session.session_runner import InlineRunner, SessionRunner, ThreadRunner


@dataclass(frozen=True)
class Backends:
    """Factories of runners, writers and executors.

    Attributes:
        runner: Drives the session.
        readings_runner: Takes readings of a real skin.
        recording_writer: Writes recordings.
        executor: Runs jobs, by the name of its process.
    """

    runner: Callable[..., SessionRunner]
    readings_runner: Callable[..., SessionRunner]
    recording_writer: Callable[[], RecordingWriter]
    executor: Callable[[str, QObject], Executor]


BACKGROUND = Backends(
    ThreadRunner,
    ThreadReadingsRunner,
    RecordingWriter,
    ProcessExecutor,
)
"""Threads and separate processes, each started when it is first needed, so that the window never waits."""
INLINE = Backends(
    InlineRunner,
    InlineReadingsRunner,
    InlineRecordingWriter,
    InlineExecutor,
)
"""Work is done in the caller, and only on request: deterministic, for tests and pictures."""
