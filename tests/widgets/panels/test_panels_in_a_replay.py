"""While a recording is shown, no panel shows the session that is paused behind it."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import QPointF
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QLineEdit, QListView, QPushButton

from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.document import rename_patch
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tests.support.touch import prepared_bar
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import run


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A recording of another robot."""
    path = tmp_path_factory.mktemp("bar") / "bar.mcap"
    bar = prepared_bar()
    session = Session(bar)
    with Recorder(bar, path, viewers=False) as recorder:
        for _ in range(20):
            recorder.write(session.tick(), session.inputs)
    return path


@pytest.fixture
def window(window_again):
    """A session with an edited map and a selected patch; the tab *Map* is shown."""
    editor = window_again.editor
    window_again.column.set_folded(())
    window_again.column.show_tab(PanelTab.MAP)
    editor.do("Rename a patch", partial(rename_patch, number=0, name="Biceps"))
    editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    editor.select([0])
    yield window_again
    window_again.live.replay.leave()


def texts(window, panel):
    """Everything that a panel shows, after events were processed."""
    QApplication.processEvents()
    column = window.column[panel]
    shown = [
        widget.text()
        for kind in (QLabel, QPushButton, QLineEdit)
        for widget in column.findChildren(kind)
        if widget.isVisible()
    ]
    for view in column.findChildren(QListView):
        if view.isVisible():
            model = view.model()
            shown += [str(model.index(row, 0).data()) for row in range(model.rowCount())]
    return shown


@pytest.mark.long
def test_panel_lists_the_patches_of_the_recording(window, recording):
    session = ["Biceps", "forearm", "hand"]
    assert texts(window, "patches")[-3:] == session
    window.live.open_recording(recording)
    patch = window.live.prepared.skin.patches[0]
    shown = texts(window, "patches")
    assert shown[-1] == patch.name
    assert not {*session} & {*shown}
    assert any("patches of the recording" in text for text in shown)
    assert not window.column["patches"].list.selectedIndexes(), "the selection is that of the session"
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(0))
    QTest.mouseMove(view.viewport(), QPointF(pixel).toPoint())
    QApplication.processEvents()
    assert window.column["patches"].list._rows.hovered == 0
    window.live.replay.leave()
    assert texts(window, "patches")[-3:] == session
    assert [index.row() for index in window.column["patches"].list.selectedIndexes()] == [0]
    assert window.column["patches"].findChild(QPushButton, "patch-mirror").isVisible()


def test_recorded_edits_of_names_and_layout_reach_the_list(window, tmp_path, prepared):
    """A recording of the same skin has its own map, without the later names of the session."""
    session = Session(prepared)
    with Recorder(prepared, tmp_path / "own.mcap", viewers=False) as recorder:
        for _ in range(20):
            recorder.write(session.tick(), session.inputs)
    window.live.open_recording(tmp_path / "own.mcap")
    assert texts(window, "patches")[-3:] == [patch.name for patch in prepared.skin.patches]


def test_history_does_not_list_the_steps_of_the_session(window, recording):
    assert {"Rename a patch", "Rotate"} <= {*texts(window, "history")}
    window.live.open_recording(recording)
    shown = texts(window, "history")
    assert not {"Rename a patch", "Rotate"} & {*shown}
    assert any("The timeline marks the edits" in text for text in shown)
    window.live.replay.leave()
    assert {"Rename a patch", "Rotate"} <= {*texts(window, "history")}


def test_accuracy_and_rate_of_the_session_are_not_shown_during_a_replay(window, recording):
    window.column.show_tab(PanelTab.MODEL)
    run(window, 0.01)
    panel = window.column["accuracy"]
    measure = panel.findChild(QPushButton, "accuracy-measure")
    assert measure.isEnabled()
    window.live.open_recording(recording)
    assert not measure.isEnabled()
    assert any("return to it" in text for text in texts(window, "accuracy"))
    window.column.get(LiveInputPanel).rate_changed.emit(50.0)
    assert window.status_line.factor.text() == "Replay", "readings may still arrive"
    left_click(measure)
    assert not panel.busy
    window.live.replay.leave()
    assert measure.isEnabled()
