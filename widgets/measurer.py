"""A process that measures maps: it keeps what it knows of the body, so that an edit's quality is there at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.maps.body_distances import BodyDistances
from app.maps.chart import Chart
from app.maps.compare import TaxelLayout, compare
from app.maps.layout import MapLayout
from app.maps.quality import measure
from app.maps.tactile_map import TactileMap
from app.skin.skin import Skin
from widgets.process import Process, Serve, Tell

_DIED = "Measuring the map ended unexpectedly; its quality stays unknown. Open the scene again to measure it."


@dataclass(frozen=True, eq=False)
class _Measure:
    """Measure the map of these charts on the skin sent last."""

    charts: tuple[Chart, ...]
    layout: MapLayout


@dataclass(frozen=True, eq=False)
class _Compare:
    """Compare two maps of the same skin."""

    first: TactileMap | TaxelLayout
    second: TactileMap | TaxelLayout


def make_serve() -> Serve:
    """In the process: skins, charts and pairs in; qualities and comparisons out."""
    known: list[tuple[Skin, BodyDistances]] = []

    def serve(request: object, tell: Tell) -> None:
        if isinstance(request, Skin):
            known[:] = [(request, BodyDistances(request))]
        elif isinstance(request, _Measure):
            ((skin, distances),) = known
            tell("measured", measure(TactileMap(skin, request.charts, request.layout), distances=distances))
        elif isinstance(request, _Compare):
            of_body = known[0][1] if known else None
            tell("compared", compare(request.first, request.second, distances=of_body))

    return serve


class Measurer(QObject):
    """Measures the newest map asked for: one at a time, and those that were overtaken never."""

    measured = Signal(object)
    """The MapQuality of the newest map."""
    compared = Signal(object)
    """The Comparison asked for last."""
    failed = Signal(str)
    """Why there is none."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.process = Process("measure", make_serve, self)
        self.process.answered.connect(self._on_answered)
        self.process.ended.connect(self._on_ended)
        self._skin: Skin | None = None
        self._next: _Measure | None = None

    def warm(self) -> None:
        """Start the process now, so that the first map need not wait for it."""
        self.process.warm()

    def measure(self, map_: TactileMap) -> None:
        """Measure ``map_``. Cost: the body's distances once a skin, about a second; then 40 ms for 1000 taxels."""
        fresh = map_.skin is not self._skin
        if fresh:
            self.process.close()  # whatever it measured is of another skin
            self._skin = map_.skin
            self.process.send(map_.skin)
        self._next = _Measure(map_.charts, map_.layout)
        if fresh or not self.process.waiting:
            self._send()

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout) -> None:
        """Compare two maps of one skin."""
        self.process.send(_Compare(first, second))

    def close(self) -> None:
        """End the process, whatever it does."""
        self._skin = self._next = None
        self.process.close()

    def _send(self) -> None:
        request, self._next = self._next, None
        if request is not None:
            self.process.send(request)

    def _on_answered(self, kind: str, content: Any) -> None:
        if kind == "done":
            self._send()
        elif kind == "failed":
            self.failed.emit(content)
        elif kind == "compared":
            self.compared.emit(content)
        elif self._next is None:
            self.measured.emit(content)

    def _on_ended(self) -> None:
        self.close()
        self.failed.emit(_DIED)


class InlineMeasurer(Measurer):
    """Measures when told to, while the caller waits: deterministic, for tests and pictures."""

    def warm(self) -> None:
        """There is no process to start."""

    def measure(self, map_: TactileMap) -> None:
        """Remember ``map_`` for ``run``."""
        self._newest = map_

    def run(self) -> None:
        """Measure the newest map asked for."""
        self.measured.emit(measure(self._newest))

    def compare(self, first: TactileMap | TaxelLayout, second: TactileMap | TaxelLayout) -> None:
        """Compare at once."""
        self.compared.emit(compare(first, second))
