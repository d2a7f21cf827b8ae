"""A process beside the window that measures one stage for its work-precision diagram, and ends when it has."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal

from app.studies.work_precision import Subject, Trial
from widgets.workers.worker_process import Reply, RequestHandler, WorkerProcess


def make_handler() -> RequestHandler:
    """In the process: a stage's name and a subject in; progress and trials out."""
    from app.studies.stages.registry import STAGES
    from app.studies.work_precision import run_trials

    def serve(request: Any, tell: Reply) -> None:
        name, subject = request
        for trial in run_trials(STAGES[name], subject, progress=lambda *how: tell("progress", how)):
            tell("tried", trial)

    return serve


class AccuracyWorker(QObject):
    """Measures one stage at a time in a process of its own, so that nothing of the window disturbs its clock."""

    progressed = Signal(str, float)
    """What is being tried, and how far it is, 0 to 1."""
    tried = Signal(tuple)
    """The Trials that are there since the last time."""
    finished = Signal()
    """All of them are."""
    failed = Signal(str)
    """Why not all could be."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._trials: list[Trial] = []
        self.process = WorkerProcess("accuracy", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)

    @property
    def busy(self) -> bool:
        """Whether something is being measured."""
        return bool(self.process.waiting)

    def measure(self, stage: str, subject: Subject) -> None:
        """Measure a stage of ``stages.registry``; what was being measured is dropped."""
        self.close()
        self.process.send((stage, subject))
        self.progressed.emit("starting", 0.0)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._trials.clear()
        self.process.close()

    def _on_answered(self, _number: int, kind: str, content: Any) -> None:
        if kind == "tried":
            self._trials.append(content)
            return
        self._tell()
        if kind == "progress":
            self.progressed.emit(*content)
        else:  # failed comes before done, and ends it
            self.close()
            self.finished.emit() if kind == "done" else self.failed.emit(content)

    def _tell(self) -> None:
        """Rounds come in bursts; they are told, and drawn, at once."""
        if self._trials:
            trials, self._trials = tuple(self._trials), []
            self.tried.emit(trials)

    def _on_ended(self) -> None:
        self.failed.emit("The measurement ended unexpectedly; the diagram before it is kept. Measure again.")
