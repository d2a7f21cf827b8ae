"""Tables of studies in the window: from the menu, by a drop, and by a click on a point."""

from __future__ import annotations

import pyqtgraph as pg
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMenu, QPushButton

from tactile_maps.core.assets import asset
from tactile_maps.studies.catalogue import STUDY_NAMES, load_study
from tactile_maps.studies.running.study_table import read_study_table
from tactile_widgets.common.colours import LIGHT
from tactile_widgets.dialogs.study_dialog import StudyDialog
from tactile_widgets.presenters.files.study_presenter import no_replay
from tests.widgets.support.mouse import left_click

LOOPS = asset("findings", "loop-laws.csv")
PATHS = asset("findings", "representation.csv")


def shown(window):
    (dialog,) = window.findChildren(StudyDialog)
    return dialog


def test_click_on_a_point_lists_its_rows(window_again):
    window_again.presenters.files.open_path(str(LOOPS))
    dialog = shown(window_again)
    assert len(dialog.model.rows) == len(read_study_table(LOOPS).rows)
    dialog.factor.setCurrentText("delay")
    dialog.curves.setCurrentText("plant")
    dialog.only.setText("law=onset")
    QTest.keyClick(dialog.only, Qt.Key.Key_Tab)
    dialog.only.editingFinished.emit()
    point = next(point for point in dialog.points if point.x == 2)
    lines = [item for item in dialog.plot.canvas.getPlotItem().items if isinstance(item, pg.PlotDataItem)]
    drawn = [item.yData for item in lines]
    assert any(1236.1 in y for y in drawn), "the onset that theory predicts at a delay of 2 is drawn"
    at = dialog.plot.on_canvas(point).toPoint()
    left_click(dialog.plot.canvas.viewport(), at)
    assert dialog.model.rows == list(point.rows)
    assert {(row["law"], row["delay"]) for row in dialog.model.rows} == {("onset", 2)}
    left_click(dialog.findChild(QPushButton, "study-all-rows"))
    assert {row["law"] for row in dialog.model.rows} == {"onset"}
    assert len(dialog.model.rows) > len(point.rows)
    dialog.set_theme(LIGHT)
    dialog.close()


@pytest.mark.long
def test_chart_names_the_median_and_missing_columns(window_again):
    window_again.presenters.studies.open(str(PATHS))
    dialog = shown(window_again)
    assert "most of their seeds fail" in dialog.note.text()
    assert "Points combine rows with different" in dialog.note.text()
    dialog.only.setText("colour=red")
    dialog.only.editingFinished.emit()
    assert "invalid condition" in dialog.note.text()
    assert not dialog.points
    dialog.close()


def test_findings_are_listed_and_a_broken_table_is_reported(window_again, tmp_path, choose_file):
    menu = QMenu()
    window_again.presenters.studies.list_findings(menu)
    assert len(menu.actions()) == len(list(asset("findings").glob("*.csv")))
    menu.actions()[0].trigger()
    shown(window_again).close()
    menu.deleteLater()
    (tmp_path / "mine.csv").write_text("level,seed\n1\n", encoding="utf8")
    choose_file("open_file", tmp_path / "mine.csv")
    window_again.action("open_study").trigger()
    assert "line 2 is incomplete" in window_again.notification_bar.text


def test_replay_button_explains_rows_without_a_run(window_again):
    window_again.presenters.studies.open(str(LOOPS))
    dialog = shown(window_again)
    dialog.view.selectRow(0)
    assert not dialog.replay.isEnabled()
    assert "A row of loop-laws summarizes several runs" in dialog.replay.toolTip()
    dialog.close()
    assert "mine is unknown" in no_replay("mine")
    assert no_replay("representation") == ""


def test_invalid_case_is_reported_and_leaves_no_file(window_again, tmp_path):
    row = {**read_study_table(PATHS).rows[0], "robot": "nobody"}
    window_again.presenters.studies.replay("representation", row)
    assert "The row does not belong to a case of this study" in window_again.notification_bar.text
    assert not list(tmp_path.rglob("*.mcap")) + list(tmp_path.rglob("*.part"))


@pytest.mark.long
def test_studies_with_one_run_per_row_can_be_replayed():
    assert {name for name in STUDY_NAMES if load_study(name).replay is not None} == {
        name for name in STUDY_NAMES if not no_replay(name)
    }


@pytest.mark.long
def test_run_of_a_row_is_simulated_and_replayed(window_again):
    window_again.presenters.studies.open(str(PATHS))
    dialog = shown(window_again)
    dialog.view.selectRow(0)
    left_click(dialog.replay)
    player = window_again.live.replay.player
    assert player is not None
    assert player.path.stem == "representation arm nominal 0"
    assert player.duration == pytest.approx(1.0 + dialog.model.rows[0]["seconds"], abs=0.02)
    dialog.close()
    window_again.live.replay.leave()
