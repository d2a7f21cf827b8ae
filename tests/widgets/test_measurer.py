"""The measurer: a real process that keeps the body's distances and measures the newest map asked for."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal

import pytest

from app.editing.arrange import scale
from app.editing.document import MapDocument
from app.editing.reflatten import apply, reflatten, set_method
from app.maps.compare import compare
from app.maps.quality import measure
from widgets.measurer import InlineMeasurer, Measurer

LONG = 60_000


@pytest.fixture
def measurer():
    """A measurer whose process is gone after the test."""
    made = Measurer()
    yield made
    made.close()
    made.deleteLater()
    assert not mp.active_children(), "a process outlived its test"


def test_a_map_is_measured_as_it_would_be_here(measurer, prepared, qtbot):
    with qtbot.waitSignal(measurer.measured, timeout=LONG) as got:
        measurer.measure(prepared.map)
    assert facts(got.args[0]) == facts(measure(prepared.map))
    assert got.args[0].round_trip_mm < 2, "a pixel of this map is a millimetre and a half across"
    assert got.args[0].force_error < 1e-12


def test_maps_that_were_overtaken_are_never_measured(measurer, prepared, qtbot):
    document, got = MapDocument.of(prepared.map), []
    measurer.measured.connect(got.append)
    for step in range(30):
        measurer.measure(scale(document, [0], 1 + step / 10).map)
    qtbot.waitUntil(lambda: not measurer.process.waiting, timeout=LONG)
    assert len(got) <= 2
    assert facts(got[-1]) == facts(measure(scale(document, [0], 3.9).map))


def test_an_edited_chart_is_measured_as_it_is_now(measurer, prepared, qtbot):
    document = MapDocument.of(prepared.map)
    edited = apply(document, reflatten(set_method(document, [1], "lscm"))).map
    for map_ in (prepared.map, edited, prepared.map):
        with qtbot.waitSignal(measurer.measured, timeout=LONG) as got:
            measurer.measure(map_)
        assert facts(got.args[0]) == facts(measure(map_))


def facts(quality):
    """All but what depends on the image's pixels, which the process lays in each chart's own frame."""
    return {key: value for key, value in quality.to_json().items() if key not in ("round_trip_mm", "force_error")}


def test_the_window_never_waits_for_a_process_to_read(measurer, prepared, qtbot):
    """A pipe holds 64 kB: a larger request, written before it is read, would hold up whoever writes it."""
    measurer.measure(prepared.map)
    assert not measurer.process._busy, "nothing is written before it reads"
    assert measurer.process.waiting == 2, "skin and map wait here, not in the pipe"
    with qtbot.waitSignal(measurer.measured, timeout=LONG):
        pass
    qtbot.waitUntil(lambda: measurer.process.ready, timeout=LONG)
    assert not measurer.process.waiting


def test_two_maps_are_compared(measurer, prepared, qtbot):
    larger = scale(MapDocument.of(prepared.map), [0], 2.0).map
    with qtbot.waitSignal(measurer.compared, timeout=LONG) as got:
        measurer.compare(prepared.map, larger)
    assert got.args[0].to_json() == compare(prepared.map, larger).to_json()


def test_a_process_that_dies_is_told_and_replaced(measurer, prepared, qtbot):
    with qtbot.waitSignal(measurer.failed, timeout=LONG) as failure:
        measurer.measure(prepared.map)
        os.kill(measurer.process.pid, signal.SIGKILL)
    assert "ended unexpectedly" in failure.args[0]
    with qtbot.waitSignal(measurer.measured, timeout=LONG):
        measurer.measure(prepared.map)


def test_inline_it_measures_when_told_to(prepared, qtbot):
    measurer, got = InlineMeasurer(), []
    measurer.measured.connect(got.append)
    measurer.measure(prepared.map)
    assert not got
    measurer.run()
    assert len(got) == 1
