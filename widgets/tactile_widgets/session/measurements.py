"""Measurements of the scene that is shown: map quality, comparison of maps, costs of effects, the known load.

Results for a scene that is no longer shown are dropped.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.flattening.chart import Chart
from tactile_maps.maps.evaluation.comparison import TaxelLayout
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Effects
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.simulation.known_load_check import WeighingResult
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.jobs.executor import Job, Kept, Running, keep
from tactile_widgets.jobs.measuring_jobs import (
    SkinMeasurements,
    compare_two_maps,
    measure_costs,
    measure_map,
    weigh_known_load,
)
from tactile_widgets.session.backends import Backends

_MAP_DIED = "Measuring the map ended unexpectedly; its quality stays unknown. Open the scene again to measure it."
_COST_DIED = "The cost measurement ended unexpectedly; the scene continues. Try again."


class Measurements(QObject):
    """Measures in two processes, and reports results for the scene that is shown.

    Args:
        backends: Makes the processes.
        parent: Qt parent.

    Attributes:
        map_executor: Measures and compares maps.
        cost_executor: Measures on copies of the scene.
        cost_seconds: Approximate duration of measuring the costs of effects [s].
    """

    measured = Signal(object)
    """``MapQuality`` of the newest map."""
    compared = Signal(object)
    """Comparison of the maps requested last."""
    map_failed = Signal(str)
    """Reason why a map could not be measured or compared."""
    priced = Signal(object)
    """Milliseconds per tick by effect, for the effects requested last."""
    weighed = Signal(object)
    """``WeighingResult`` of the known load."""
    cost_failed = Signal(str)
    """Reason why costs or the known load could not be measured."""
    weighing_changed = Signal(bool)
    """True while the known load is being weighed on the scene that is shown."""

    def __init__(self, backends: Backends, parent: QObject) -> None:
        super().__init__(parent)
        self.map_executor = backends.executor("measure", self)
        self.cost_executor = backends.executor("costs", self)
        self.cost_seconds = 2.0
        self._skin: Skin | None = None
        self._kept_skin: Kept[SkinMeasurements] | None = None
        self._measuring: tuple[Running[Any], tuple[Chart, ...]] | None = None  # newest map
        self._sent: tuple[Chart | None, ...] = ()  # charts that the process has
        self._prepared: PreparedScene | None = None
        self._kept_scene: Kept[PreparedScene] | None = None
        self._pricing: Running[Any] | None = None
        self._load: Running[Any] | None = None
        self._weighing = False

    @property
    def weighing(self) -> bool:
        """True while the known load is being weighed on the scene that is shown."""
        return self._weighing

    def show_scene(self) -> None:
        """Drop what is being measured: another scene is shown, or the same one again."""
        self.map_executor.ignore_all()
        if self.cost_executor.busy:
            self.cost_executor.close()  # saves processor time
        self._set_weighing(weighing=False)

    def measure(self, map_: TactileMap) -> None:
        """Measure a map of the scene that is shown; the previous map is not measured any more."""
        if map_.skin is not self._skin:
            self.map_executor.close()
            self._skin = map_.skin
            self._kept_skin = Kept(partial(SkinMeasurements, map_.skin))
            self._sent = (None,) * len(map_.charts)
        elif self._measuring is not None:
            running, charts = self._measuring
            if running.begun:
                self._sent = charts
            running.ignore()
        assert self._kept_skin is not None
        pairs = enumerate(zip(map_.charts, self._sent, strict=True))
        changed = {k: chart for k, (chart, sent) in pairs if chart is not sent}
        job = Job(measure_map, self._kept_skin, changed, map_.layout, died=_MAP_DIED, deferrable=True)
        self._measuring = (self.map_executor.start(job, self.measured.emit, self._on_map_failed), map_.charts)

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout) -> None:
        """Compare two maps of its skin."""
        job = Job(compare_two_maps, self._kept_skin, first, second, died=_MAP_DIED)
        self.map_executor.start(job, self.compared.emit, self._on_map_failed)

    def price(self, prepared: PreparedScene, effects: Effects) -> None:
        """Measure what each of these effects costs per tick [ms]; earlier requests are dropped."""
        if self._pricing is not None:
            self._pricing.ignore()
        scene = self._kept(prepared)
        job = Job(measure_costs, scene, effects, self.cost_seconds, died=_COST_DIED, deferrable=True)
        self._pricing = self.cost_executor.start(job, self.priced.emit, self.cost_failed.emit)

    def weigh(self, prepared: PreparedScene, effects: Effects) -> None:
        """Put the known load on the skin, unless it is being weighed."""
        if not self._weighing:
            self._set_weighing(weighing=True)
            job = Job(weigh_known_load, self._kept(prepared), effects, died=_COST_DIED)
            self._load = self.cost_executor.start(job, self._on_weighed, self._on_weighing_failed)

    def cancel_weighing(self) -> None:
        """Remove the load."""
        if self._load is not None:
            self._load.cancel()
        self._set_weighing(weighing=False)

    def close(self) -> None:
        """End the processes."""
        self.map_executor.close()
        self.cost_executor.close()

    def _kept(self, prepared: PreparedScene) -> Kept[PreparedScene]:
        if self._kept_scene is None or prepared is not self._prepared:
            self.cost_executor.close()
            self._prepared = prepared
            self._kept_scene = keep(prepared)
        return self._kept_scene

    def _set_weighing(self, *, weighing: bool) -> None:
        if weighing != self._weighing:
            self._weighing = weighing
            self.weighing_changed.emit(weighing)

    def _on_map_failed(self, text: str) -> None:
        self._skin = None  # the process may have lost charts
        self.map_failed.emit(text)

    def _on_weighed(self, result: WeighingResult) -> None:
        self._set_weighing(weighing=False)
        self.weighed.emit(result)

    def _on_weighing_failed(self, text: str) -> None:
        self._set_weighing(weighing=False)
        self.cost_failed.emit(text)
