"""Measurements of the scene that is shown: in processes, only the newest, and dropped with their scene."""

from __future__ import annotations

import os
import signal
from dataclasses import replace
from functools import partial

import pytest
from PySide6.QtCore import QObject

from tactile_maps.editing.arrange import scale
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten, set_method
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import compare_maps
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.scene.scene import with_override
from tactile_maps.simulation.known_load_check import WeighingResult
from tactile_maps.studies.ablation import ablation_cost
from tactile_widgets.jobs.executor import InlineExecutor, ProcessExecutor
from tactile_widgets.jobs.measuring_jobs import KNOWN_MASS
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.measurements import Measurements
from tactile_widgets.session.session_host import SessionHost
from tests.support.surfaces import cap, frustum, skin_of
from tests.support.touch import prepared_bar

LONG = 60_000
FACTS = ("measured", "compared", "map_failed", "priced", "weighed", "cost_failed", "weighing_changed")


def notes_of(measurements):
    """Collect every signal as (name, value)."""
    notes = []
    for name in FACTS:
        getattr(measurements, name).connect(lambda value, name=name: notes.append((name, value)))
    return notes


@pytest.fixture(scope="module")
def bar():
    """A bar on a hinge, whose ticks cost least: thousands of them are timed."""
    return prepared_bar()


@pytest.fixture
def live(qtbot, prepared):
    made = SessionHost(backends=replace(INLINE, executor=partial(InlineExecutor, hold=True)))
    made.show_prepared(prepared)
    made.measurements.cost_seconds = 0.2
    yield made
    made.close()
    made.deleteLater()


@pytest.fixture
def live_notes(live):
    return notes_of(live.measurements)


def request_everything(live, prepared):
    larger = scale(MapDocument.of(prepared.map), [0], 2.0).map
    live.measurements.measure(prepared.map)
    live.measurements.compare(prepared.map, larger)
    live.measurements.price(prepared, prepared.scene.effects)
    live.measurements.weigh(prepared, prepared.scene.effects)


def finish(live):
    live.measurements.map_executor.run_waiting()
    live.measurements.cost_executor.run_waiting()


@pytest.mark.long
def test_results_of_the_shown_scene_are_reported(live, live_notes, prepared):
    request_everything(live, prepared)
    assert live.measurements.weighing
    finish(live)
    assert not live.measurements.weighing
    values = dict(live_notes)
    assert [name for name, _ in live_notes] == [
        "weighing_changed",
        "measured",
        "compared",
        "priced",
        "weighing_changed",
        "weighed",
    ]
    assert isinstance(values["weighed"], WeighingResult)
    assert values["priced"].keys() == ablation_cost(prepared, effects=prepared.scene.effects, seconds=0.05).keys()


def test_results_of_the_previous_scene_are_dropped(live, live_notes, prepared):
    request_everything(live, prepared)
    live.show_prepared(prepared)  # the same scene, from its start
    assert live_notes == [("weighing_changed", True), ("weighing_changed", False)]
    finish(live)
    assert live_notes[2:] == []


def test_failure_for_the_previous_scene_is_dropped(live, live_notes, prepared):
    live.measurements.weigh(prepared, with_override(prepared.scene, "skin", "off").effects)
    live.show_prepared(prepared)
    live.measurements.weigh(prepared, prepared.scene.effects)
    finish(live)
    assert "cost_failed" not in dict(live_notes)
    assert live_notes[-1][0] == "weighed"


def test_costs_of_an_earlier_request_are_dropped(live, live_notes, bar):
    for state in ("on", "auto"):
        live.measurements.price(bar, with_override(bar.scene, "noise", state).effects)
    finish(live)
    assert [name for name, _ in live_notes] == ["priced"]
    assert "joint_limits" in live_notes[0][1]
    assert "noise" not in live_notes[0][1]


@pytest.fixture(scope="module")
def shown():
    """The map of two curved patches with few taxels."""
    return build_map(skin_of(frustum(around=24, along=12), cap(1.2, rings=10)))


@pytest.fixture(scope="module")
def shared_measurements(qapp):
    """Measurements in processes, for all tests: starting one takes longer than most of them."""
    parent = QObject()
    made = Measurements(replace(INLINE, executor=ProcessExecutor), parent)
    made.cost_seconds = 0.1
    yield made
    made.close()


@pytest.fixture
def measurements(shared_measurements):
    yield shared_measurements
    assert not shared_measurements.weighing


@pytest.fixture
def notes(measurements):
    made = notes_of(measurements)
    yield made
    for name in FACTS:
        getattr(measurements, name).disconnect()


@pytest.fixture
def wait(qtbot, measurements):
    """Wait until everything is measured."""
    return lambda: qtbot.waitUntil(
        lambda: not (measurements.map_executor.busy or measurements.cost_executor.busy), timeout=LONG
    )


def facts(quality):
    """Return what does not depend on the pixels of the image, which the process uses per chart."""
    return {key: value for key, value in quality.to_json().items() if key not in ("round_trip_mm", "force_error")}


@pytest.mark.long
def test_process_measures_the_newest_of_many_maps_as_this_process_does(measurements, notes, wait, shown):
    document = MapDocument.of(shown)
    for step in range(30):
        measurements.measure(scale(document, [0], 1 + step / 10).map)
    wait()
    assert [name for name, _ in notes] == ["measured"]
    assert facts(notes[0][1]) == facts(measure(scale(document, [0], 3.9).map))
    assert notes[0][1].force_error < 1e-12


@pytest.mark.long
def test_edited_chart_is_measured_with_the_charts_that_the_process_has(measurements, notes, wait, shown):
    document = MapDocument.of(shown)
    edited = apply_result(document, reflatten(set_method(document, [1], "lscm"))).map
    for map_ in (shown, edited, shown):
        measurements.measure(map_)
        wait()
        assert facts(notes[-1][1]) == facts(measure(map_))


@pytest.mark.long
def test_chart_of_a_measurement_that_never_started_is_sent_again(measurements, notes, wait, shown):
    document = MapDocument.of(shown)
    edited = apply_result(document, reflatten(set_method(document, [1], "lscm"))).map
    moved = scale(MapDocument.of(edited), [0], 2.0).map
    for map_ in (shown, edited, moved):
        measurements.measure(map_)
    wait()
    assert facts(notes[-1][1]) == facts(measure(moved))


@pytest.mark.long
def test_two_maps_are_compared(measurements, notes, wait, shown):
    larger = scale(MapDocument.of(shown), [0], 2.0).map
    measurements.compare(shown, larger)
    wait()
    assert notes[0][1].to_json() == compare_maps(shown, larger).to_json()


@pytest.mark.long
def test_death_of_the_process_is_reported_and_the_next_map_is_measured(measurements, notes, wait, shown):
    measurements.measure(shown)
    os.kill(measurements.map_executor.pid, signal.SIGKILL)
    wait()
    measurements.measure(shown)
    wait()
    assert [name for name, _ in notes] == ["map_failed", "measured"]
    assert "ended unexpectedly" in notes[0][1]


@pytest.mark.long
def test_only_the_newest_request_is_measured_for_enabled_effects(measurements, notes, wait, bar, qtbot):
    measurements.price(bar, with_override(bar.scene, "noise", "on").effects)
    qtbot.waitUntil(lambda: measurements._pricing.begun, timeout=LONG)
    for state in ("on", "auto"):
        measurements.price(bar, with_override(bar.scene, "noise", state).effects)
    wait()
    assert [name for name, _ in notes] == ["priced"]
    assert "joint_limits" in notes[0][1]
    assert "noise" not in notes[0][1]


@pytest.mark.long
def test_known_load_is_weighed_or_the_reason_is_reported(measurements, notes, wait, bar):
    for scene in (bar.scene, with_override(bar.scene, "skin", "off")):
        measurements.weigh(bar, scene.effects)
        assert measurements.weighing
        wait()
    assert notes[2][0] == "weighed"
    assert notes[2][1].expected_N == pytest.approx(9.81 * KNOWN_MASS)
    assert abs(notes[2][1].error) < 0.01
    assert notes[-1][0] == "cost_failed"
    assert "known-load check cannot run" in notes[-1][1]


def test_cancelled_weighing_reports_nothing_and_costs_continue(measurements, notes, wait, bar):
    measurements.price(bar, bar.scene.effects)
    measurements.weigh(bar, bar.scene.effects)
    measurements.cancel_weighing()
    measurements.cancel_weighing()
    wait()
    assert [name for name, _ in notes] == ["weighing_changed", "weighing_changed", "priced"]
