"""A process beside the window that simulates the skin in the posture of a measured one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.live.simulated_skin import SimulatedSkin, check_comparable, skin_difference
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_DIED = "The simulation beside the measured skin ended unexpectedly. Fold and unfold the panel to try again."


@dataclass(frozen=True, eq=False)
class _Posture:
    """Of the robot sent last (joints,)."""

    joints: FloatArray


def make_handler() -> RequestHandler:
    """In the process: a scene and then postures in, pressures out."""
    known: list[SimulatedSkin] = []

    def serve(request: object, tell: Reply) -> None:
        if isinstance(request, PreparedScene):
            known[:] = [SimulatedSkin(request)]
        elif isinstance(request, _Posture):
            tell("simulated", known[0].pressures(request.joints))

    return serve


class SimulatedSkinWorker(QObject):
    """Simulates one posture at a time, of those asked for only the newest.

    ``close`` ends the process.
    """

    compared = Signal(object)
    """The Result with the SkinDifference of a frame that was asked for."""
    failed = Signal(object)
    """The Result with why there is none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("simulated_skin_worker", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self._scene: PreparedScene | None = None
        self._loading: int | None = None
        self._refused: str | None = None  # why that scene cannot be simulated
        self._asked: tuple[int, Frame] | None = None
        self._next: tuple[Frame, SourceToken] | None = None

    def compare(self, prepared: PreparedScene, frame: Frame, token: SourceToken) -> None:
        """Simulate the skin of a scene in the posture of a measured frame, and take the difference.

        Cost: beside, 0.2 to 1 ms, 25 for 4,000 taxels on a whole body; 0.5 to 10 s for another scene, and a process.
        """
        try:
            check_comparable(frame)
        except TactileMapsError as error:
            self.failed.emit(Result(token, str(error)))
            return
        self._take(prepared, token)
        if self._refused is not None:
            self.failed.emit(Result(token, self._refused))
            return
        self._next = frame, token
        if self._asked is None:
            self._send()

    def close(self) -> None:
        """End the process, whatever it does."""
        self._scene = self._loading = self._refused = self._asked = self._next = None
        self.process.close()

    def _take(self, prepared: PreparedScene, token: SourceToken) -> None:
        if prepared is not self._scene:
            self.close()
            self._scene = prepared
            self._loading = self.process.send(prepared, token)

    def _send(self) -> None:
        wanted = self._next
        self._next = None
        self._asked = None
        if wanted is not None:
            frame, token = wanted
            self._asked = self.process.send(_Posture(frame.posture), token), frame

    def _on_answered(self, number: int, kind: str, result: Result[Any]) -> None:
        if kind == "failed":
            if number == self._loading:
                self._refused = result.value
                self._asked = None
                self._next = None
                self.process.close()
            self.failed.emit(result)
        elif self._asked is None or number != self._asked[0]:
            return
        elif kind == "done":
            self._send()
        else:
            self._tell(self._asked[1], result)

    def _tell(self, frame: Frame, result: Result[FloatArray]) -> None:
        try:
            self.compared.emit(Result(result.token, skin_difference(frame, result.value)))
        except TactileMapsError as error:
            self.failed.emit(Result(result.token, str(error)))

    def _on_ended(self, token: SourceToken) -> None:
        self.close()
        self.failed.emit(Result(token, _DIED))


class InlineSimulatedSkinWorker(SimulatedSkinWorker):
    """Simulates at once, while the caller waits: deterministic, for tests and pictures."""

    def compare(self, prepared: PreparedScene, frame: Frame, token: SourceToken) -> None:
        """Take the difference at once."""
        try:
            if prepared is not self._scene:
                self._scene = prepared
                self._skin = SimulatedSkin(prepared)
            self.compared.emit(Result(token, self._skin.compare(frame)))
        except TactileMapsError as error:
            self.failed.emit(Result(token, str(error)))
