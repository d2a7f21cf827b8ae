"""A process beside the window that measures one stage for its work-precision diagram, and ends when it has."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.studies.study.work_precision import Subject, Trial
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_DIED = "The measurement ended unexpectedly; the diagram before it is kept. Measure again."

BUDGET = "budget"
BUDGET_WITH_PATHS = "budget-with-paths"
"""What is measured in place of a stage."""


def make_handler() -> RequestHandler:
    """In the process: a stage's name, or ``BUDGET`` or ``BUDGET_WITH_PATHS``, and a subject in; progress and trials,
    or one BudgetMeasurement, out.
    """
    from tactile_maps.studies.budget.measurement import measure_for_budget
    from tactile_maps.studies.stages.registry import STAGES
    from tactile_maps.studies.study.work_precision import run_trials

    def serve(request: Any, tell: Reply) -> None:
        name, subject = request
        if name in (BUDGET, BUDGET_WITH_PATHS):
            paths = name == BUDGET_WITH_PATHS
            tell("options", measure_for_budget(subject, paths=paths, progress=lambda *how: tell("progress", how)))
            return
        for trial in run_trials(STAGES[name], subject, progress=lambda *how: tell("progress", how)):
            tell("tried", trial)

    return serve


class AccuracyWorker(QObject):
    """Measures one stage at a time in a process of its own, so that nothing of the window disturbs its clock."""

    progressed = Signal(str, float)
    """What is being tried, and how far it is, 0 to 1."""
    tried = Signal(object)
    """The Result with the Trials that are there since the last time."""
    options_found = Signal(object)
    """The Result with the BudgetMeasurement that was asked for."""
    finished = Signal(object)
    """The Result with nothing: all of them are there."""
    failed = Signal(object)
    """The Result with why not all could be."""

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

    def measure(self, stage: str, subject: Subject, token: SourceToken) -> None:
        """Measure a stage of ``stages.registry``; what was being measured is dropped."""
        self.close()
        self.progressed.emit("starting", 0.0)
        self._request((stage, subject), token)

    def _request(self, request: tuple[str, Subject], token: SourceToken) -> None:
        self.process.send(request, token)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._trials.clear()
        self.process.close()

    def _on_answered(self, _number: int, kind: str, result: Result[Any]) -> None:
        if kind == "tried":
            self._trials.append(result.value)
            return
        if kind == "options":
            self.options_found.emit(result)
            return
        if self._trials:  # rounds come in bursts; they are told, and drawn, at once
            trials = tuple(self._trials)
            self._trials = []
            self.tried.emit(Result(result.token, trials))
        if kind == "progress":
            self.progressed.emit(*result.value)
        else:  # failed comes before done, and ends it
            self.close()
            (self.finished if kind == "done" else self.failed).emit(result)

    def _on_ended(self, token: SourceToken) -> None:
        self.failed.emit(Result(token, _DIED))


class InlineAccuracyWorker(AccuracyWorker):
    """Measures when told to, while the caller waits: deterministic, for tests and pictures."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._waiting: tuple[tuple[str, Subject], SourceToken] | None = None

    @property
    def busy(self) -> bool:
        """Whether something waits for ``run``."""
        return self._waiting is not None

    def close(self) -> None:
        """Forget what was asked for."""
        super().close()
        self._waiting = None

    def _request(self, request: tuple[str, Subject], token: SourceToken) -> None:
        self._waiting = request, token

    def run(self) -> None:
        """Measure what was asked for last; nothing where that was dropped."""
        if self._waiting is None:
            return
        (request, token), self._waiting = self._waiting, None

        def tell(kind: str, content: object) -> None:
            self._on_answered(0, kind, Result(token, content))

        try:
            make_handler()(request, tell)
        except TactileMapsError as error:
            tell("failed", str(error))
        else:
            tell("done", None)
