"""What does the window's work: threads and processes while a person waits, or all of it here and now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject

from widgets.bench import Bench, InlineBench
from widgets.law_comparison.comparer import Comparer, InlineComparer
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
        bench: Measures on copies of the scene.
        comparer: Runs laws side by side.
    """

    runner: Callable[..., Runner]
    worker: Callable[[QObject], Worker]
    measurer: Callable[[QObject], Measurer]
    bench: Callable[[QObject], Bench]
    comparer: Callable[[QObject], Comparer]


BESIDE = Engines(ThreadRunner, Worker, Measurer, Bench, Comparer)
"""A thread and four processes beside the window, which never waits."""
INLINE = Engines(InlineRunner, InlineWorker, InlineMeasurer, InlineBench, InlineComparer)
"""Here and now, and only when told to: deterministic, for tests and pictures."""
