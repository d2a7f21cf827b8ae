"""What does the window's work: threads and processes while a person waits, or all of it here and now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject

from widgets.measurer import InlineMeasurer, Measurer
from widgets.runner import InlineRunner, Runner, ThreadRunner
from widgets.worker import InlineWorker, Worker


@dataclass(frozen=True)
class Engines:
    """How each is made.

    Attributes:
        runner: Drives the session.
        worker: Prepares scenes and lays patches flat.
        measurer: Measures maps.
    """

    runner: Callable[..., Runner]
    worker: Callable[[QObject], Worker]
    measurer: Callable[[QObject], Measurer]


BESIDE = Engines(ThreadRunner, Worker, Measurer)
"""A thread and two processes beside the window, which never waits."""
INLINE = Engines(InlineRunner, InlineWorker, InlineMeasurer)
"""Here and now, and only when told to: deterministic, for tests and pictures."""
