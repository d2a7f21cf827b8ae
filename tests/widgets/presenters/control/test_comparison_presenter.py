"""Comparison of controllers in the real window: run, inspected, applied and exported."""

from __future__ import annotations

import csv
from dataclasses import replace

import numpy as np
import pyqtgraph as pg
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import UsageError
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.session import Session
from tactile_maps.studies.controller_comparison import controller_metrics
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.dialogs.controller_comparison.comparison_plots import LETTERS, contender_pen
from tactile_widgets.dialogs.controller_comparison.comparison_view import ComparisonView
from tactile_widgets.dialogs.controller_comparison.metrics_table import NONE, ROWS, format_metric
from tactile_widgets.presenters.control.comparison_presenter import _first_two
from tests.widgets.support.mouse import left_click, left_double_click, left_release
from tests.widgets.support.samples import middle_taxel
from tests.widgets.support.window_driver import replay_run, run


@pytest.fixture(scope="module")
def prepared(coarse_prepared):
    """Scene without scripted stimuli."""
    return replace(coarse_prepared, scene=replace(coarse_prepared.scene, stimuli=()))


@pytest.fixture
def window(window_again):
    """Window without a comparison dialog."""
    yield window_again
    comparison = window_again.presenters.comparison
    if comparison.dialog is not None:
        comparison.close()
        comparison.dialog.deleteLater()
        comparison.dialog = None


@pytest.fixture
def touched_window(window, prepared):
    """Window in which hybrid control has moved a finger on the forearm for half a second."""
    panel = window.column["controller"]
    panel.choose_controller("hybrid")
    panel.choose_task("follow_path")
    window.live.reset()
    run(window, 0.2)
    window.presenters.touch.press(window.live.prepared.skin.taxel_point(middle_taxel(prepared.map, 1)))
    run(window, 0.4)
    assert window.live.runner.session.frame.regions
    return window


@pytest.fixture
def board(touched_window) -> ComparisonView:
    touched_window.column.reveal(touched_window.column["controller"])
    click(touched_window.column["controller"], "compare-controllers")
    dialog = touched_window.presenters.comparison.dialog
    assert dialog.isVisible()
    return dialog.board


def click(parent, name):
    button = parent.findChild(QPushButton, name)
    assert button.isVisible(), name
    assert button.isEnabled(), name
    left_click(button)
    QApplication.processEvents()


def note(board):
    label = board.findChild(QLabel, "comparison-note")
    return label.text() if label.isVisible() else ""


def choose(box, value):
    """Choose from a list by keys."""
    box.setFocus()
    QTest.keyClick(box, Qt.Key.Key_Home)
    while box.itemData(box.currentIndex()) != value:
        row = box.currentIndex()
        QTest.keyClick(box, Qt.Key.Key_Down)
        assert box.currentIndex() != row


def curves(board, name):
    return [item for item in board.plots.plots[name].getPlotItem().listDataItems() if item.name() in tuple(LETTERS)]


@pytest.mark.long
def test_comparison_starts_with_two_controllers_and_the_past_touch(board, touched_window, tmp_path):
    assert [card.settings.controller for card in board.cards] == ["hybrid", "qp"]
    assert board.stimulus.occasion.touches == 1
    assert board.stimulus.occasion.words.startswith("0.6\u202fs, 1 touch")
    assert board.stimulus.seconds.value() == pytest.approx(0.6)
    assert not board.stimulus.own_task
    assert board.traces == ()
    assert board._empty.isVisible()
    assert not board.findChild(QPushButton, "comparison-export").isVisible()
    path = tmp_path / "torn.mcap"
    path.write_bytes(b"nothing")
    touched_window.presenters.comparison.read_stimulus(str(path))
    assert "torn.mcap" in note(board)
    assert board.stimulus.occasion.touches == 1


@pytest.mark.long
def test_progress_and_cancel_replace_the_run_button(board):
    board.show_progress("1.0 of 2.0\u202fs", 0.5)
    assert board._progress.value() == 500
    assert not board.findChild(QPushButton, "comparison-run").isVisible()
    click(board, "comparison-cancel")
    assert board.findChild(QPushButton, "comparison-run").isVisible()
    assert note(board) == ""


@pytest.mark.long
def test_comparison_without_touch_offers_the_script_of_the_scene(window, prepared):
    scripted = replace(prepared.scene, stimuli=load_scene("arm").stimuli)
    window.live.show_prepared(replace(prepared, scene=scripted))
    window.action("compare_controllers").trigger()
    board = window.presenters.comparison.board
    assert board.stimulus.own_task
    assert board.stimulus.occasion.inputs is None
    assert "repeated" in board.findChild(QLabel, "stimulus-note").text()


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (0.000123, "0.000123"), (0.01, "0.0100"), (10.0, "10.0"), (-2.0, "-2.00"), (1234.0, "1.23e+03")],
)
def test_metric_has_three_significant_digits(value, text):
    assert format_metric(ROWS[0], value) == text


@pytest.mark.long
def test_run_draws_all_traces_and_metrics(board, touched_window):
    before = touched_window.live.runner.session.frame.tick
    click(board, "comparison-run")
    assert [trace.name for trace in board.traces] == ["A", "B"]
    assert touched_window.live.runner.session.frame.tick == before, "the session does not advance"
    for trace, curve in zip(board.traces, curves(board, "map_error"), strict=True):
        np.testing.assert_allclose(curve.yData, 1e3 * trace.map_error)
        assert len(curve.xData) == 120
    found = [controller_metrics(trace) for trace in board.traces]
    row = next(row for row in ROWS if row.name == "map_rms_mm")
    assert [board.table.text("map_rms_mm", k) for k in (0, 1)] == [format_metric(row, one.map_rms_mm) for one in found]
    assert found[0].map_rms_mm > 0
    metrics = board.table.fontMetrics()
    for column, title in enumerate(("A: Hybrid", "B: Quadratic program")):
        room = board.table.columnWidth(column)
        texts = [title, *(board.table.text(row.name, column) for row in ROWS)]
        assert all(metrics.horizontalAdvance(word) < room for text in texts for word in text.split())
    assert not board.table.horizontalScrollBar().isVisible()
    assert not board._empty.isVisible()
    assert note(board) == ""
    frame = touched_window.live.runner.session.frame
    assert board.traces[0].time[-1] == frame.time
    assert board.traces[0].force[-1] == frame.regions[0].force
    assert board.traces[0].map_error[-1] == frame.task.error


@pytest.mark.long
def test_contender_is_applied_with_its_gains_but_without_its_task(board, touched_window):
    click(board, "contender-gains-B")
    QTest.keyClick(board.cards[1].sliders.by_name["force_gain"]._slider, Qt.Key.Key_End)
    click(board, "comparison-run")
    check_best_is_bold(board)
    click(board, "use-B")
    settings = touched_window.column["controller"].settings
    assert (settings.controller, settings.task, settings.force_gain) == ("qp", "follow_path", 0.04)
    run(touched_window, 0.1)
    assert touched_window.live.runner.session.settings == settings


def check_best_is_bold(board):
    figures = [controller_metrics(trace) for trace in board.traces]
    clear = 0
    for number, row in enumerate(ROWS):
        if not (row.better and row.unit):
            continue
        one, other = (getattr(metrics, row.name) for metrics in figures)
        if one is None or other is None or abs(one - other) <= 0.05 * max(abs(one), abs(other)):
            continue
        bold = [board.table.item(number, column).font().bold() for column in (0, 1)]
        assert bold == [one < other, other < one], row.name
        clear += 1
    assert clear, "some figures differ clearly"


@pytest.mark.long
def test_change_after_a_run_marks_the_results_as_outdated(board):
    choose(board.cards[0]._controller, "priority")
    assert note(board) == ""
    click(board, "comparison-run")
    choose(board.cards[0]._controller, "hybrid")
    assert "run again" in note(board)
    assert board.traces[0].settings.controller == "priority"
    click(board, "comparison-run")
    assert note(board) == ""


def test_results_are_dropped_with_their_scene(board, touched_window, prepared, tmp_path):
    click(board, "comparison-run")
    window = touched_window
    replay_run(window, tmp_path / "same.mcap", 0.1)
    window.live.replay.leave()
    assert len(board.traces) == 2, "results of the scene that is shown stay"
    comparison = window.presenters.comparison
    comparison.dialog.close()
    window.live.show_prepared(replace(prepared, scene=replace(prepared.scene, seed=prepared.scene.seed + 1)))
    window.action("compare_controllers").trigger()
    assert board.traces == ()
    assert not curves(board, "force")
    assert board._empty.isVisible()
    assert not board.findChild(QPushButton, "comparison-export").isVisible()
    assert not any(button.isVisible() for button in board.findChildren(QPushButton) if button.text() == "Use A")
    assert note(board) == "Results of the previous scene are dropped: run again."
    click(board, "comparison-run")
    assert note(board) == ""
    assert len(board.traces) == 2


@pytest.mark.long
def test_contenders_are_added_and_removed(board):
    assert not board.cards[0]._remove.isVisible(), "two must stay"
    click(board, "comparison-more")
    click(board, "comparison-more")
    assert [card.letter for card in board.cards] == ["A", "B", "C", "D"]
    assert not board.findChild(QPushButton, "comparison-more").isVisible(), "more could not be distinguished"
    remove = board.cards[1]._remove
    left_click(remove)
    choose(board.cards[1]._controller, "parallel")
    click(board, "comparison-run")
    assert [(trace.name, trace.settings.controller) for trace in board.traces] == [
        ("A", "hybrid"),
        ("C", "parallel"),
        ("D", "qp"),
    ]
    click(board, "comparison-more")
    assert [card.letter for card in board.cards] == list("ABCD")


@pytest.mark.long
def test_next_comparison_includes_later_touches(board, touched_window):
    click(board, "comparison-run")
    run(touched_window, 0.4)
    words = board.findChild(QLabel, "stimulus-note").text()
    seconds = board.stimulus.seconds.value()
    board.findChild(QPushButton, "stimulus-refresh").click()
    assert board.stimulus.seconds.value() > seconds
    assert board.findChild(QLabel, "stimulus-note").text() != words
    click(board, "comparison-run")
    assert board.traces[0].time[-1] == pytest.approx(1.0)
    board.stimulus.seconds.setValue(0.3)
    run(touched_window, 0.2)
    click(board, "comparison-run")
    assert board.traces[0].time[-1] == pytest.approx(0.3), "a time that a person chose stays"


@pytest.mark.long
def test_all_contenders_can_do_the_current_task(board, touched_window):
    touched_window.column["controller"].choose_task("keep_force")
    choose(board.stimulus._tasks, "own")
    click(board, "comparison-run")
    assert {trace.settings.task for trace in board.traces} == {"keep_force"}
    assert board.table.text("map_rms_mm", 0) == NONE


@pytest.mark.long
def test_recording_is_used_as_stimulus(board, prepared, tmp_path, choose_file):
    path = tmp_path / "other.mcap"
    session = Session(prepared)
    with Recorder(session.prepared, path) as recorder:
        session.submit(PokePressed(1, prepared.skin.taxel_point(30)))
        for _ in range(80):
            recorder.write(session.tick(), session.inputs)
    choose_file("open_file", path)
    choose(board.stimulus._box, "file")
    assert board.stimulus._box.words == "other.mcap"
    assert board.stimulus.seconds.value() == pytest.approx(0.4)
    click(board, "comparison-run")
    assert board.traces[0].touched.any()


@pytest.mark.long
def test_results_follow_zoom_theme_and_units(board, touched_window):
    click(board, "comparison-run")
    plot = board.plots.plots["force"]
    plot.setXRange(0.2, 0.4, padding=0)
    middle = plot.viewport().rect().center()
    left_double_click(plot.viewport(), middle)
    left_release(plot.viewport(), middle)
    low, high = plot.getPlotItem().viewRange()[0]
    assert low <= 0
    assert high >= 0.6
    dark = [ink_of(item) for item in curves(board, "force")]
    touched_window.set_theme("light")
    assert [ink_of(item) for item in curves(board, "force")] != dark
    touched_window.set_theme("dark")
    assert [ink_of(item) for item in curves(board, "force")] == dark
    title = board.plots._titles[list(board.plots.plots).index("joint_speed")]
    row = [row.name for row in ROWS].index("joint_speed_max")
    assert title.text() == "Max joint speed (rad/s)"
    for unit, limit, speed, drawn in (
        ("m/s", 0.25, 0.2, True),
        ("m/s", 0.25, 0.1, False),
        ("% of limit", 100.0, 80, True),
    ):
        given = {"speed_unit": unit, "speed_limit": limit}
        traces = [replace(trace, joint_speed=np.full(len(trace), speed), **given) for trace in board.traces]
        board.plots.show_traces(traces)
        board.table.show_traces(traces, ["A", "B"])
        assert title.text() == f"Max joint speed ({unit})"
        assert board.table.verticalHeaderItem(row).text() == f"Max joint speed ({unit})"
        lines = board.plots.plots["joint_speed"].getPlotItem().items
        assert [item.value() for item in lines if isinstance(item, pg.InfiniteLine)] == [limit] * drawn


def test_traces_are_exported_and_errors_shown(board, touched_window, tmp_path, monkeypatch, choose_file):
    click(board, "comparison-run")
    strongest = next(row for row in ROWS if row.name == "force_max_N")
    for column, trace in enumerate(board.traces):
        assert board.table.text("force_max_N", column) == format_metric(strongest, float(np.nanmax(trace.force)))
    assert {trace.settings.controller for trace in board.traces} == {"hybrid", "qp"}
    path = tmp_path / "controllers.csv"
    choose_file("save_file", path)
    click(board, "comparison-export")
    with path.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == sum(len(trace) for trace in board.traces)
    touched_window.presenters.comparison.export(str(tmp_path / "no folder" / "controllers.csv"))
    assert "cannot be written" in note(board)
    monkeypatch.setattr("tactile_widgets.presenters.control.comparison_presenter.run_comparison", reject)
    click(board, "comparison-run")
    assert note(board) == "▲ It broke."
    assert len(board.traces) == 2, "earlier results are kept"
    torn = replace(board.traces[1], ended="the simulation diverged.")
    board.show_compared((board.traces[0], torn))
    assert note(board) == "▲ B: Quadratic program stopped after 0.6\u202fs: the simulation diverged."


@pytest.mark.parametrize(("current", "other"), [("hybrid", "qp"), ("qp", "hybrid")])
def test_second_contender_has_another_controller(current, other):
    assert [one.controller for one in _first_two(ControlSettings(controller=current))] == [current, other]


def reject(*_arguments):
    raise UsageError("It broke")


def test_contenders_differ_in_colour_and_dash():
    for theme in (DARK, LIGHT):
        pens = [contender_pen(theme, letter) for letter in LETTERS]
        assert len({pen.color().name() for pen in pens}) == len({tuple(pen.dashPattern()) for pen in pens}) == 4


def ink_of(item):
    return pg.mkPen(item.opts["pen"]).color().name()


@pytest.mark.long
def test_menu_selects_controllers_and_tasks(window):
    for controller in ("qp", "impedance", "parallel"):
        window.action(f"controller_{controller}").trigger()
        assert window.column["controller"].settings.controller == controller
        assert window.action(f"controller_{controller}").isChecked()
    window.action("task_retreat").trigger()
    assert window.column["controller"].settings.task == "retreat"
    assert not window.action("start_again").isEnabled()
    window.action("task_follow_path").trigger()
    window.action("start_again").trigger()
    assert window.column["controller"].settings.starts == 1
    window.action("controller_impedance").trigger()
    assert not window.action("task_retreat").isEnabled(), "that controller has no task"
