"""The simulated skin beside the measured one that is shown, while somebody looks at it."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from tactile_maps.session.frame import Frame
from tactile_widgets.session.backends import Backends
from tactile_widgets.session.live_input import LiveInput
from tactile_widgets.workers.simulated_skin_worker import SimulatedSkinWorker
from tactile_widgets.workers.worker_process import Result, SourceToken


class SkinComparison(QObject):
    """Asks for the simulated skin of each measured frame that is shown. Nothing is done while nobody wants it.

    Args:
        backends: Makes the process.
        parent: Qt parent.

    Attributes:
        worker: Simulates.
    """

    compared = Signal(object)
    """The SkinDifference of a frame that was shown a moment ago."""
    failed = Signal(str)
    """Why the frame shown cannot be compared."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.worker: SimulatedSkinWorker = backends.simulated_skin_worker(self)
        self.worker.compared.connect(self._on_compared)
        self.worker.failed.connect(self._on_failed)
        self._token = SourceToken("measured skin")
        self._input: LiveInput | None = None
        self._wanted = False

    def show_input(self, live: LiveInput | None) -> None:
        """Compare the readings of another source; None for none."""
        self._input = live
        self._token = self._token.next()
        if live is None:
            self.worker.close()

    def set_wanted(self, wanted: bool) -> None:
        """Compare from now on, or not; the process ends with the wish."""
        self._wanted = wanted
        if not wanted:
            self.worker.close()

    def show_frame(self, frame: Frame) -> None:
        """Compare a measured frame, unless a newer one comes first."""
        if self._wanted and self._input is not None:
            self.worker.compare(self._input.origin, frame, self._token)

    def close(self) -> None:
        """End the process."""
        self.worker.close()

    def _on_compared(self, result: Result[object]) -> None:
        if result.token == self._token:
            self.compared.emit(result.value)

    def _on_failed(self, result: Result[str]) -> None:
        if result.token == self._token:
            self.failed.emit(result.value)
