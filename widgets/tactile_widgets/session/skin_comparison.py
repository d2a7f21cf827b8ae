"""Comparison of a measured skin with the simulated one in the same posture."""

from __future__ import annotations

from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError
from tactile_maps.live.simulated_skin import SimulatedSkin, check_comparable, skin_difference
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.jobs.executor import Job, Kept, Running
from tactile_widgets.jobs.measuring_jobs import prepare_simulated_skin, simulate_pressures
from tactile_widgets.session.backends import Backends
from tactile_widgets.session.live_input import LiveInput

_DIED = "The simulation of the measured skin ended unexpectedly. Fold and unfold the panel to try again."


class SkinComparison(QObject):
    """Compares the newest measured frame that is shown, while it is switched on.

    Args:
        backends: Makes the process.
        parent: Qt parent.

    Attributes:
        executor: Runs the simulations.
    """

    compared = Signal(object)
    """SkinDifference of a recent frame."""
    failed = Signal(str)
    """Reason why the frame cannot be compared."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.executor = backends.executor("simulated skin", self)
        self._input: LiveInput | None = None
        self._enabled = False
        self._prepared: PreparedScene | None = None
        self._skin: Kept[SimulatedSkin] | None = None
        self._refused: str | None = None  # why that scene cannot be simulated
        self._newest: Running[Any] | None = None

    def show_input(self, live: LiveInput | None) -> None:
        """Compare the readings of another source, or of none."""
        self._input = live
        self.executor.ignore_all()
        if live is None:
            self.close()

    def set_enabled(self, enabled: bool) -> None:
        """Switch the comparison on or off; off ends the process."""
        self._enabled = enabled
        if not enabled:
            self.close()

    def show_frame(self, frame: Frame) -> None:
        """Compare a measured frame, unless a newer one arrives first."""
        if self._enabled and self._input is not None:
            self.compare(self._input.origin, frame)

    def compare(self, prepared: PreparedScene, frame: Frame) -> None:
        """Simulate the skin of a scene in the posture of a measured frame, and report the difference."""
        try:
            check_comparable(frame)
        except TactileMapsError as error:
            self.failed.emit(str(error))
            return
        if self._skin is None or prepared is not self._prepared:
            self.close()
            self._prepared = prepared
            self._skin = Kept(partial(SimulatedSkin, prepared))
            self.executor.start(Job(prepare_simulated_skin, self._skin, died=_DIED), failed=self._on_refused)
        elif self._refused is not None:
            self.failed.emit(self._refused)
        if self._refused is not None:
            return
        if self._newest is not None and not self._newest.begun:
            self._newest.ignore()
        job = Job(simulate_pressures, self._skin, frame.posture, died=_DIED)
        self._newest = self.executor.start(job, partial(self._on_simulated, frame), self.failed.emit)

    def close(self) -> None:
        """End the process."""
        self.executor.close()
        self._prepared = self._skin = self._refused = None

    def _on_simulated(self, frame: Frame, pressures: FloatArray) -> None:
        try:
            self.compared.emit(skin_difference(frame, pressures))
        except TactileMapsError as error:
            self.failed.emit(str(error))

    def _on_refused(self, text: str) -> None:
        self.executor.close()
        self._refused = text
        self.failed.emit(text)
