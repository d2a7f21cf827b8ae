"""What is measured beside of what is shown: map quality, comparison of maps, prices of effects, the known load.

A request is about the scene that is shown when it is made, and its result knows that scene. A result for another one is
dropped here, whenever it comes.
"""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.maps.evaluation.comparison import TaxelLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.session.backends import Backends
from tactile_widgets.workers.worker_process import Result, SourceToken


class Measurements(QObject):
    """Asks the measuring processes, and tells what they find of the scene that is shown.

    Args:
        backends: Makes the processes.
        parent: Qt parent.

    Attributes:
        token: Of the scene that is shown.
        map_quality_worker: Measures and compares maps.
        cost_worker: Measures on copies of the scene.
    """

    measured = Signal(object)
    """The MapQuality of the newest map."""
    compared = Signal(object)
    """The Comparison asked for last."""
    map_failed = Signal(str)
    """Why there is none of these."""
    priced = Signal(object)
    """Milliseconds a tick by effect, of the effects asked for last."""
    weighed = Signal(object)
    """The WeighingResult of the known load."""
    cost_failed = Signal(str)
    """Why there is none of these."""
    weighing_changed = Signal(bool)
    """Whether the known load is being weighed on the scene that is shown."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.token = SourceToken("scene")
        self._weighing = False
        self.map_quality_worker = backends.map_quality_worker(self)
        self.cost_worker = backends.cost_worker(self)
        self.map_quality_worker.measured.connect(self._on_measured)
        self.map_quality_worker.compared.connect(self._on_compared)
        self.map_quality_worker.failed.connect(self._on_map_failed)
        self.cost_worker.priced.connect(self._on_priced)
        self.cost_worker.weighed.connect(self._on_weighed)
        self.cost_worker.failed.connect(self._on_cost_failed)

    @property
    def weighing(self) -> bool:
        """Whether the known load is being weighed on the scene that is shown."""
        return self._weighing

    def show_scene(self) -> None:
        """Another scene is shown, or one of before again: results of what was asked so far are dropped."""
        self.token = self.token.next()
        if self.cost_worker.process.waiting:
            self.cost_worker.close()  # spares the processor: nobody wants it any more
        self._set_weighing(weighing=False)

    def measure(self, map_: TactileMap) -> None:
        """Measure a map of the scene that is shown; costs as ``MapQualityWorker.measure``."""
        self.map_quality_worker.measure(map_, self.token)

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout) -> None:
        """Compare two maps of its skin."""
        self.map_quality_worker.compare(first, second, self.token)

    def price(self, prepared: PreparedScene, effects: Effects) -> None:
        """Measure what each of these effects costs a tick [ms]. Cost: 2 s, beside."""
        self.cost_worker.price(prepared, effects, self.token)

    def weigh(self, prepared: PreparedScene, effects: Effects) -> None:
        """Lay the known load on the skin, unless it is there. Cost: 1 to 5 s, beside."""
        if not self._weighing:
            self._set_weighing(weighing=True)
            self.cost_worker.weigh(prepared, effects, self.token)

    def cancel_weighing(self) -> None:
        """Take the load off again."""
        self.cost_worker.cancel_weighing()
        self._set_weighing(weighing=False)

    def close(self) -> None:
        """End the processes, whatever they do."""
        self.map_quality_worker.close()
        self.cost_worker.close()

    def _set_weighing(self, *, weighing: bool) -> None:
        if weighing != self._weighing:
            self._weighing = weighing
            self.weighing_changed.emit(weighing)

    def _tell(self, signal: Any, result: Result[Any]) -> None:
        if result.token == self.token:
            signal.emit(result.value)

    def _on_measured(self, result: Result[Any]) -> None:
        self._tell(self.measured, result)

    def _on_compared(self, result: Result[Any]) -> None:
        self._tell(self.compared, result)

    def _on_map_failed(self, result: Result[str]) -> None:
        self._tell(self.map_failed, result)

    def _on_priced(self, result: Result[Any]) -> None:
        self._tell(self.priced, result)

    def _on_weighed(self, result: Result[Any]) -> None:
        self._end_weighing(result)
        self._tell(self.weighed, result)

    def _on_cost_failed(self, result: Result[str]) -> None:
        self._end_weighing(result)
        self._tell(self.cost_failed, result)

    def _end_weighing(self, result: Result[Any]) -> None:
        """Where it was a price that failed, the load is still weighed."""
        if result.token == self.token:
            self._set_weighing(weighing=self.cost_worker.busy_weighing)
