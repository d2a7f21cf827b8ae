"""A process that measures maps: it keeps what it knows of the body, so that an edit's quality is there at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.flattening.chart import Chart
from tactile_maps.maps.evaluation.comparison import TaxelLayout, compare_maps
from tactile_maps.maps.evaluation.quality import MapQuality, measure
from tactile_maps.maps.evaluation.topography import BodyDistances
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.workers.worker_process import Reply, RequestHandler, Result, SourceToken, WorkerProcess

_PIXELS = 512
"""Along the longer side of the map as it was first measured, as ``measure`` would take."""
_DIED = "Measuring the map ended unexpectedly; its quality stays unknown. Open the scene again to measure it."


@dataclass(frozen=True, eq=False)
class _Measure:
    """Measure the map of the skin sent last, with these charts for those patches and the others as they were."""

    charts: Mapping[int, Chart]
    layout: MapLayout


@dataclass(frozen=True, eq=False)
class _Compare:
    """Compare two maps of the same skin."""

    first: TactileMap | TaxelLayout
    second: TactileMap | TaxelLayout


class _SkinCache:
    """What the process keeps of one skin. Mutable: charts are replaced as they are edited.

    An edit of the layout leaves all of it as it is, and another chart costs only its own image.
    """

    def __init__(self, skin: Skin) -> None:
        self.skin = skin
        self.distances = BodyDistances(skin)
        self._charts: dict[int, Chart] = {}
        self._images: dict[int, TactileImage] = {}
        self._resolution: float | None = None

    def measured(self, request: _Measure) -> MapQuality:
        """The quality of the map asked for."""
        self._charts |= request.charts
        map_ = TactileMap(self.skin, tuple(self._charts[k] for k in range(len(self._charts))), request.layout)
        if self._resolution is None:
            self._resolution = max(float(np.ptp(map_.bounds, axis=0).max()) / _PIXELS, 1e-9)
        for number, chart in request.charts.items():
            alone = TactileMap(Skin((self.skin.patches[number],)), (chart,), MapLayout((Placement(),)))
            self._images[number] = TactileImage(alone, resolution=self._resolution)
        return measure(map_, distances=self.distances, images=tuple(self._images.values()))


def make_handler() -> RequestHandler:
    """In the process: skins, charts and pairs in; qualities and comparisons out."""
    known: list[_SkinCache] = []

    def serve(request: object, tell: Reply) -> None:
        if isinstance(request, Skin):
            known[:] = [_SkinCache(request)]
        elif isinstance(request, _Measure):
            tell("measured", known[0].measured(request))
        elif isinstance(request, _Compare):
            tell(
                "compared", compare_maps(request.first, request.second, distances=known[0].distances if known else None)
            )

    return serve


class MapQualityWorker(QObject):
    """Measures the newest map asked for: one at a time, and those that were overtaken never."""

    measured = Signal(object)
    """The Result with the MapQuality of the newest map."""
    compared = Signal(object)
    """The Result with the Comparison asked for last."""
    failed = Signal(object)
    """The Result with why there is none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = WorkerProcess("measure", make_handler, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self._skin: Skin | None = None
        self._next: tuple[TactileMap, SourceToken] | None = None
        self._measuring: int | None = None
        self._sent: tuple[Chart | None, ...] = ()

    def warm(self) -> None:
        """Start the process now, so that the initial map need not wait for it."""
        self.process.warm()

    def measure(self, map_: TactileMap, token: SourceToken) -> None:
        """Measure ``map_``. Cost: the body's distances once a skin, 1 to 3 s; then 40 ms, and 30 ms a new chart."""
        if map_.skin is not self._skin:
            self.close()  # whatever it measured is of another skin
            self._skin = map_.skin
            self._sent = (None,) * len(map_.charts)
            self.process.send(map_.skin, token)
        self._next = map_, token
        if self._measuring is None:
            self._send()

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout, token: SourceToken) -> None:
        """Compare two maps of one skin."""
        self.process.send(_Compare(first, second), token)

    def close(self) -> None:
        """End the process, whatever it does."""
        self._skin = self._next = self._measuring = None
        self.process.close()

    def _send(self) -> None:
        asked = self._next
        self._next = None
        self._measuring = None
        if asked is not None:
            map_, token = asked
            pairs = enumerate(zip(map_.charts, self._sent, strict=True))
            request = _Measure({k: chart for k, (chart, sent) in pairs if chart is not sent}, map_.layout)
            self._measuring = self.process.send(request, token)
            self._sent = map_.charts

    def _on_answered(self, number: int, kind: str, result: Result[Any]) -> None:
        if kind == "done":
            if number == self._measuring:
                self._send()
        elif kind == "failed":
            self.failed.emit(result)
        elif kind == "compared":
            self.compared.emit(result)
        elif self._next is None:  # nothing newer was asked for
            self.measured.emit(result)

    def _on_ended(self, token: SourceToken) -> None:
        self.close()
        self.failed.emit(Result(token, _DIED))


class InlineMapQualityWorker(MapQualityWorker):
    """Measures when told to, while the caller waits: deterministic, for tests and pictures."""

    def warm(self) -> None:
        """There is no process to start."""

    def measure(self, map_: TactileMap, token: SourceToken) -> None:
        """Remember ``map_`` for ``run``."""
        self._newest = map_, token

    def run(self) -> None:
        """Measure the newest map asked for."""
        map_, token = self._newest
        self.measured.emit(Result(token, measure(map_)))

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout, token: SourceToken) -> None:
        """Compare at once."""
        self.compared.emit(Result(token, compare_maps(first, second)))
