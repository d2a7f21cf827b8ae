"""The Accuracy/time panel: it measures the present skin in a real process, when asked and never by itself.

What does not hang on the process is measured here: to start one takes longer than to try a stage on a small body.
"""

from __future__ import annotations

import multiprocessing as mp
import os
import signal
from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QPushButton

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.studies.stages.registry import STAGES
from tactile_maps.studies.study.work_precision import Setting
from tactile_maps.studies.study.work_precision import method_title as method_name
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.document.stage_settings import reflatten_for
from tactile_widgets.jobs.executor import InlineExecutor, ProcessExecutor
from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tests.support.touch import prepared_bar
from tests.widgets.support.samples import tube_and_hemisphere

LONG = 60_000


@pytest.fixture(scope="module")
def document():
    return tube_and_hemisphere(200)


@pytest.fixture
def executor(request):
    """Executor of the panel."""
    return getattr(request, "param", InlineExecutor)("accuracy")


in_a_process = pytest.mark.parametrize("executor", [ProcessExecutor], indirect=True)


@pytest.fixture
def panel(qtbot, document, executor):
    apply_theme(QApplication.instance(), DARK)
    made = AccuracyPanel(DARK)
    executor.setParent(made)
    made.measure_with(executor)
    qtbot.addWidget(made)
    made.resize(300, 480)
    made.show_document(document, (1,))
    made.show()
    qtbot.waitExposed(made)
    yield made
    made.shut()
    assert not mp.active_children(), "a process outlived its test"


def press(panel, name, qtbot):
    button = panel.board.findChild(QPushButton, f"accuracy-{name}")
    assert button.isVisible()
    assert button.isEnabled()
    qtbot.mouseClick(button, Qt.MouseButton.LeftButton)


def said(panel, name):
    return panel.board.findChild(QLabel, f"accuracy-{name}").text()


def measure(panel, qtbot, stage):
    press(panel, stage, qtbot)
    press_measure(panel, qtbot)


def press_measure(panel, qtbot):
    press(panel, "measure", qtbot)
    panel._executor.run_waiting()
    qtbot.waitUntil(lambda: not panel.busy, timeout=LONG)


def drawn(panel):
    return [point for point, _ in panel.board.plot.places()] if panel.board.plot.isVisible() else []


def alone(panel):
    """A setting that is not the present one, with no other on its point wherever times put them; and where it is."""
    places = [(point, at) for point, at in panel.board.plot.places() if point.usable]
    present = panel.board.plot._present
    apart = [
        (min((at - other).manhattanLength() for known, other in places if known != point), point, at)
        for point, at in places
        if point.setting != present
    ]
    distance, point, at = max(apart, key=lambda entry: entry[0])
    assert distance > 2
    return point, at


@in_a_process
def test_panel_before_a_measurement_explains_content_and_duration(panel, qtbot):
    assert "Measuring hemisphere takes about 2\u202fs" in said(panel, "question")
    press(panel, "image", qtbot)
    assert "Measuring the whole map takes about" in said(panel, "question")
    assert "a press, smooth pressure, round trip" in said(panel, "question")
    assert not panel.busy
    assert not mp.active_children(), "nothing is measured by itself"
    panel.show_document(None)
    assert "Open a robot" in said(panel, "question")
    assert not panel.board.findChild(QPushButton, "accuracy-measure").isEnabled()


def test_click_on_a_measured_point_applies_it_and_the_applied_setting_moves_the_ring(panel, qtbot, document):
    measure(panel, qtbot, "flatten")
    points = drawn(panel)
    usable = {p.setting.method for p in points if p.usable}
    assert usable == set(STAGES["flatten"].methods)
    assert said(panel, "note") == f"Measured on hemisphere. {STAGES['flatten'].certainty}"
    assert panel.board.plot._named(None).startswith("Present: Symmetric Dirichlet: ")
    target, at = alone(panel)
    with qtbot.waitSignal(panel.chosen) as got:
        qtbot.mouseClick(panel.board.plot.canvas.viewport(), Qt.MouseButton.LeftButton, pos=at.toPoint())
    assert got.args == [target.setting]
    assert target.setting.patches == (1,)
    after = apply_result(document, reflatten(reflatten_for(document, got.args[0])))
    panel.show_document(after, (1,))
    assert panel.board.plot._named(None).startswith(f"Present: {method_name(target.setting.method)}")
    assert len(drawn(panel)) == len(points), "kept"
    assert "has changed" not in said(panel, "note"), "the cuts are the same"


@pytest.mark.long
def test_results_are_kept_by_stage_and_discarded_with_the_skin(panel, qtbot, document):
    measure(panel, qtbot, "cut")
    count = len(drawn(panel))
    assert count >= 16
    press(panel, "flatten", qtbot)
    assert drawn(panel) == []
    press(panel, "cut", qtbot)
    assert len(drawn(panel)) == count
    panel.show_document(tube_and_hemisphere(200), (1,))
    assert drawn(panel) == []
    assert "takes about" in said(panel, "question")


@pytest.mark.long
def test_simulation_is_measured_on_the_robot_of_the_skin(panel, qtbot):
    """The measurement needs the robot, and nothing is drawn without it."""
    prepared = prepared_bar()
    panel.show_document(MapDocument.of(prepared.map))
    measure(panel, qtbot, "simulation")
    assert drawn(panel) == []
    panel.show_prepared(prepared)
    press_measure(panel, qtbot)
    assert {point.setting.method for point in drawn(panel)} >= {"implicitfast", "discrete"}
    assert said(panel, "note").startswith("Measured on the whole map.")
    panel.show_present(Setting("simulation", "discrete", {"timestep_ms": 1.0}))
    assert panel.board.plot._named(None).startswith("Present: ")


@pytest.mark.long
def test_another_error_redraws_and_a_changed_map_is_reported(panel, qtbot, document):
    measure(panel, qtbot, "cut")
    distortion = [p.error for p in drawn(panel)]
    box = panel.board.findChild(QComboBox, "accuracy-error")
    qtbot.keyClick(box, Qt.Key.Key_Down)
    assert box.currentText() == "Angles (°)"
    assert [p.error for p in drawn(panel)] != distortion
    slid = MapDocument(document.map, (document.patches[0], replace(document.patches[1], lengths=0.5)), document.order)
    panel.show_document(slid, (1,))
    assert "The map has changed: measure again." in said(panel, "note")
    assert drawn(panel)


@pytest.mark.long
def test_current_image_setting_of_the_view_is_ringed(panel, qtbot, monkeypatch):
    monkeypatch.setattr("tactile_maps.studies.stages.image.PIXELS", (64, 128))
    panel.show_present(Setting("image", "nearest", {"pixels": 128}))
    measure(panel, qtbot, "image")
    assert panel.board.plot._named(None).startswith("Present: Nearest, ")
    assert said(panel, "note") == f"Measured on the whole map. {STAGES['image'].certainty}"


@pytest.mark.long
@in_a_process
def test_cancel_keeps_earlier_results(panel, qtbot):
    press(panel, "measure", qtbot)
    assert panel.busy
    qtbot.waitUntil(lambda: "Cut: trying" in said(panel, "note"), timeout=LONG)
    press(panel, "cancel", qtbot)
    assert not panel.busy
    assert not mp.active_children()
    assert drawn(panel) == []
    assert panel.board.findChild(QPushButton, "accuracy-measure").isVisible()


@pytest.mark.long
@in_a_process
def test_points_appear_during_a_measurement_and_a_dead_process_is_reported(panel, qtbot):
    press(panel, "measure", qtbot)
    qtbot.waitUntil(lambda: len(drawn(panel)) > 0, timeout=LONG)
    assert panel.busy
    os.kill(panel._executor.pid, signal.SIGKILL)
    qtbot.waitUntil(lambda: not panel.busy, timeout=LONG)
    assert said(panel, "note") == "▲ The measurement ended unexpectedly; the diagram before it is kept. Measure again."
    assert drawn(panel) == []


@pytest.mark.long
@in_a_process
def test_another_skin_stops_the_measurement(panel, qtbot):
    press(panel, "measure", qtbot)
    panel.show_document(tube_and_hemisphere(200), ())
    assert not panel.busy
    assert not mp.active_children()
    assert "Measuring all patches takes" in said(panel, "question")


@pytest.mark.long
def test_enlarged_diagram_has_its_own_window_until_escape(panel, qtbot):
    measure(panel, qtbot, "flatten")
    small = panel.board.plot.canvas.width()
    press(panel, "enlarge", qtbot)
    window = panel.board.window()
    qtbot.waitExposed(window)
    assert window.objectName() == "accuracy-window"
    assert panel.board.plot.canvas.width() > 2 * small
    assert drawn(panel)
    qtbot.keyClick(window, Qt.Key.Key_Escape)
    assert panel.board.window() is panel.window()
    assert panel.board.isVisible()
    press(panel, "enlarge", qtbot)
    assert panel.board.window() is not panel.window()
    press(panel, "enlarge", qtbot)
    assert panel.board.window() is panel.window()


@pytest.mark.long
def test_panel_fits_the_column_and_follows_the_theme(panel, qtbot):
    press(panel, "flatten", qtbot)
    press_measure(panel, qtbot)
    assert drawn(panel)
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"
    dark = panel.board.plot.grab().toImage()
    panel.set_theme(LIGHT)
    QApplication.processEvents()
    assert panel.board.plot.grab().toImage() != dark
