"""What does the window's work: threads and processes while a person waits, or all of it here and now."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject

from tactile_widgets.jobs.executor import Executor, InlineExecutor, ProcessExecutor
from tactile_widgets.session.live_input import InlineReadingsRunner, ThreadReadingsRunner
from tactile_widgets.session.recording_writer import InlineRecordingWriter, RecordingWriter
from tactile_widgets.session.session_runner import InlineRunner, SessionRunner, ThreadRunner
from tactile_widgets.workers.accuracy_worker import AccuracyWorker, InlineAccuracyWorker
from tactile_widgets.workers.cost_worker import CostWorker, InlineCostWorker
from tactile_widgets.workers.map_quality_worker import InlineMapQualityWorker, MapQualityWorker
from tactile_widgets.workers.reference_worker import InlineReferenceWorker, ReferenceWorker
from tactile_widgets.workers.scene_worker import InlineSceneWorker, SceneWorker
from tactile_widgets.workers.simulated_skin_worker import InlineSimulatedSkinWorker, SimulatedSkinWorker


@dataclass(frozen=True)
class Backends:
    """How each is made.

    Attributes:
        runner: Drives the session.
        readings_runner: Takes readings of a real skin.
        recording_writer: Writes recordings.
        executor: Runs jobs, by the name of its process.
        worker: Prepares scenes and lays patches flat.
        map_quality_worker: Measures maps.
        cost_worker: Measures on copies of the scene.
        accuracy_worker: Measures a stage for its work-precision diagram.
        simulated_skin_worker: Simulates the skin in the posture of a measured one.
        reference_worker: Simulates the running session once more, finer.
    """

    runner: Callable[..., SessionRunner]
    readings_runner: Callable[..., SessionRunner]
    recording_writer: Callable[[], RecordingWriter]
    executor: Callable[[str, QObject], Executor]
    worker: Callable[[QObject], SceneWorker]
    map_quality_worker: Callable[[QObject], MapQualityWorker]
    cost_worker: Callable[[QObject], CostWorker]
    accuracy_worker: Callable[[QObject], AccuracyWorker]
    simulated_skin_worker: Callable[[QObject], SimulatedSkinWorker]
    reference_worker: Callable[[QObject], ReferenceWorker]


BACKGROUND = Backends(
    ThreadRunner,
    ThreadReadingsRunner,
    RecordingWriter,
    ProcessExecutor,
    SceneWorker,
    MapQualityWorker,
    CostWorker,
    AccuracyWorker,
    SimulatedSkinWorker,
    ReferenceWorker,
)
"""Two threads and processes beside the window, each begun when it is needed: the window never waits."""
INLINE = Backends(
    InlineRunner,
    InlineReadingsRunner,
    InlineRecordingWriter,
    InlineExecutor,
    InlineSceneWorker,
    InlineMapQualityWorker,
    InlineCostWorker,
    InlineAccuracyWorker,
    InlineSimulatedSkinWorker,
    InlineReferenceWorker,
)
"""Here and now, and only when told to: deterministic, for tests and pictures."""
