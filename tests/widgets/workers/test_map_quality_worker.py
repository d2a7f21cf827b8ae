"""The measurer: a real process that keeps the body's distances and measures the newest map asked for."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal

import pytest

from tactile_maps.editing.arrange import scale
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten, set_method
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import compare_maps
from tactile_maps.maps.evaluation.quality import measure
from tactile_widgets.workers.map_quality_worker import InlineMapQualityWorker, MapQualityWorker
from tactile_widgets.workers.worker_process import SourceToken
from tests.support.surfaces import cap, frustum, skin_of

LONG = 60_000
HERE = SourceToken("here")


@pytest.fixture(scope="module")
def shown():
    """Two curved patches with few taxels: what a body's distances cost grows with both."""
    return build_map(skin_of(frustum(around=24, along=12), cap(1.2, rings=10)))


@pytest.fixture(scope="module")
def map_quality_worker(qapp):
    """One for all tests that leave its process alone: to start one takes longer than to measure a small map."""
    made = MapQualityWorker()
    yield made
    _end(made)


@pytest.fixture
def fresh_worker(map_quality_worker):
    """One whose process has not been started; it is gone after the test."""
    others = mp.active_children()
    made = MapQualityWorker()
    yield made
    _end(made, others)


def _end(worker, others=()):
    worker.close()
    worker.deleteLater()
    assert [p.pid for p in mp.active_children()] == [p.pid for p in others], "a process outlived its tests"


def test_a_map_is_measured_as_it_would_be_here(map_quality_worker, shown, qtbot):
    with qtbot.waitSignal(map_quality_worker.measured, timeout=LONG) as got:
        map_quality_worker.measure(shown, HERE)
    assert facts(got.args[0].value) == facts(measure(shown))
    assert got.args[0].value.round_trip_mm < 2, "a pixel of this map is a millimetre and a half across"
    assert got.args[0].value.force_error < 1e-12


def test_maps_that_were_overtaken_are_never_measured(map_quality_worker, shown, qtbot):
    document = MapDocument.of(shown)
    got = []
    map_quality_worker.measured.connect(got.append)
    for step in range(30):
        map_quality_worker.measure(scale(document, [0], 1 + step / 10).map, HERE)
    qtbot.waitUntil(lambda: not map_quality_worker.process.waiting, timeout=LONG)
    assert len(got) <= 2
    assert facts(got[-1].value) == facts(measure(scale(document, [0], 3.9).map))


def test_an_edited_chart_is_measured_as_it_is_now(map_quality_worker, shown, qtbot):
    document = MapDocument.of(shown)
    edited = apply_result(document, reflatten(set_method(document, [1], "lscm"))).map
    for map_ in (shown, edited, shown):
        with qtbot.waitSignal(map_quality_worker.measured, timeout=LONG) as got:
            map_quality_worker.measure(map_, HERE)
        assert facts(got.args[0].value) == facts(measure(map_))


def facts(quality):
    """All but what depends on the image's pixels, which the process lays in each chart's own frame."""
    return {key: value for key, value in quality.to_json().items() if key not in ("round_trip_mm", "force_error")}


def test_the_window_never_waits_for_a_process_to_read(fresh_worker, shown, qtbot):
    """A pipe holds 64 kB: a larger request, written before it is read, would hold up whoever writes it."""
    fresh_worker.measure(shown, HERE)
    assert not fresh_worker.process._busy, "nothing is written before it reads"
    assert fresh_worker.process.waiting == 2, "skin and map wait here, not in the pipe"
    with qtbot.waitSignal(fresh_worker.measured, timeout=LONG):
        pass
    qtbot.waitUntil(lambda: fresh_worker.process.ready, timeout=LONG)
    assert not fresh_worker.process.waiting


def test_two_maps_are_compared(map_quality_worker, shown, qtbot):
    larger = scale(MapDocument.of(shown), [0], 2.0).map
    with qtbot.waitSignal(map_quality_worker.compared, timeout=LONG) as got:
        map_quality_worker.compare(shown, larger, HERE)
    assert got.args[0].value.to_json() == compare_maps(shown, larger).to_json()


def test_a_process_that_dies_is_told_and_replaced(fresh_worker, shown, qtbot):
    with qtbot.waitSignal(fresh_worker.failed, timeout=LONG) as failure:
        fresh_worker.measure(shown, HERE)
        os.kill(fresh_worker.process.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failure.args[0].value
    with qtbot.waitSignal(fresh_worker.measured, timeout=LONG):
        fresh_worker.measure(shown, HERE)


def test_inline_it_measures_when_told_to(shown, qtbot):
    map_quality_worker = InlineMapQualityWorker()
    got = []
    map_quality_worker.measured.connect(got.append)
    map_quality_worker.measure(shown, HERE)
    assert not got
    map_quality_worker.run()
    assert len(got) == 1
