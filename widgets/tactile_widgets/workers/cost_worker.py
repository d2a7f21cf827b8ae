"""A process beside the window that measures on copies of the scene: what effects cost, and what a known load reads."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.scene.effects import Effects
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.simulation.known_load_check import WeighingResult, weigh
from tactile_maps.studies.ablation import ablation_cost
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

MASS = 0.1
"""Of the known load [kg]."""
_SECONDS = 2.0
_INLINE_SECONDS = 0.2
_DIED = "The cost measurement ended unexpectedly; the scene goes on. Try again."


@dataclass(frozen=True)
class _MeasureCosts:
    """Measure what each effect costs in the scene sent last."""

    effects: Effects


@dataclass(frozen=True)
class _Weigh:
    """Lay the known load on the skin of the scene sent last."""

    effects: Effects


def make_handler(seconds: float) -> RequestHandler:
    """In the process: a scene, and what to measure of it, in; prices, in ``seconds``, and weights out."""
    known: list[PreparedScene] = []

    def serve(request: object, tell: Reply) -> None:
        if isinstance(request, PreparedScene):
            known[:] = [request]
        elif isinstance(request, _MeasureCosts):
            tell("priced", dict(ablation_cost(known[0], effects=request.effects, seconds=seconds)))
        elif isinstance(request, _Weigh):
            tell("weighed", _weighed(known[0], request.effects))

    return serve


def _weighed(prepared: PreparedScene, effects: Effects) -> WeighingResult:
    return weigh(prepared.robot, prepared.skin, prepared.scene.layer, effects.skin, mass=MASS)


class CostWorker(QObject):
    """Measures one thing at a time, and of prices only the newest asked for.

    Args:
        parent: Qt parent.
        seconds: About how long the prices of a scene are measured.
    """

    priced = Signal(object)
    """The Result with milliseconds a tick by effect, of the effects asked for last."""
    weighed = Signal(object)
    """The Result with the WeighingResult of it."""
    failed = Signal(object)
    """The Result with why something is not known."""

    def __init__(self, parent: QObject | None = None, *, seconds: float = _SECONDS) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("cost_worker", partial(make_handler, seconds), self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self._scene: PreparedScene | None = None
        self._next: tuple[_MeasureCosts, SourceToken] | None = None
        self._pricing: int | None = None
        self._weighing: int | None = None

    @property
    def busy_weighing(self) -> bool:
        """Whether the known load is being weighed."""
        return self._weighing is not None

    def price(self, prepared: PreparedScene, effects: Effects, token: SourceToken) -> None:
        """Measure what each of these effects costs a tick of a scene. Cost: 2 s, beside."""
        self._take(prepared, token)
        self._next = _MeasureCosts(effects), token
        if self._pricing is None:
            self._send()

    def weigh(self, prepared: PreparedScene, effects: Effects, token: SourceToken) -> None:
        """Lay the known load on the skin of a scene, read by these effects' model. Cost: 1 to 5 s, beside."""
        self._take(prepared, token)
        self._weighing = self.process.send(_Weigh(effects), token)

    def cancel_weighing(self) -> None:
        """Drop the load; what was priced is kept by whoever was told."""
        if self.busy_weighing:
            self.close()

    def close(self) -> None:
        """End the process, whatever it does."""
        self._scene = self._next = self._pricing = self._weighing = None
        self.process.close()

    def _take(self, prepared: PreparedScene, token: SourceToken) -> None:
        """Measure on this scene; measurements of another are dropped."""
        if prepared is not self._scene:
            self.close()
            self._scene = prepared
            self.process.send(prepared, token)

    def _send(self) -> None:
        request = self._next
        self._next = None
        self._pricing = None
        if request is not None:
            self._pricing = self.process.send(*request)

    def _on_answered(self, number: int, kind: str, result: Result[Any]) -> None:
        if number == self._pricing:
            if kind == "done":
                self._send()
            elif self._next is None:  # nothing newer was asked for
                (self.priced if kind == "priced" else self.failed).emit(result)
        elif number == self._weighing and kind != "done":
            self._weighing = None
            (self.weighed if kind == "weighed" else self.failed).emit(result)

    def _on_ended(self, token: SourceToken) -> None:
        self.close()
        self.failed.emit(Result(token, _DIED))


class InlineCostWorker(CostWorker):
    """Prices when told to, weighs at once, while the caller waits: deterministic, for tests and pictures."""

    def price(self, prepared: PreparedScene, effects: Effects, token: SourceToken) -> None:
        """Remember what to price for ``run``."""
        self._newest = prepared, effects, token

    def run(self) -> None:
        """Measure the newest prices asked for."""
        prepared, effects, token = self._newest
        self.priced.emit(Result(token, dict(ablation_cost(prepared, effects=effects, seconds=_INLINE_SECONDS))))

    def weigh(self, prepared: PreparedScene, effects: Effects, token: SourceToken) -> None:
        """Weigh at once."""
        try:
            weighed = _weighed(prepared, effects)
        except TactileMapsError as error:
            self.failed.emit(Result(token, str(error)))
        else:
            self.weighed.emit(Result(token, weighed))
