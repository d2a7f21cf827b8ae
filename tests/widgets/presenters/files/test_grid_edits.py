"""A taxel grid is an edit: marked, asked about, undone and redone with the map's edits, autosaved and restored."""

from __future__ import annotations

import pickle
from functools import partial

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.skin.fitting.grid import is_grid_patch
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.panels.history_panel import HistoryPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import answer, record_run, replay_run, run
from tests.widgets.tools.map_editing.test_grid_tool import corners

pytestmark = pytest.mark.usefixtures("scene_cache")


@pytest.fixture
def window(window_again):
    return window_again


def place_grid(window):
    """Place a grid of 8 x 8 taxels on the hand, with the mouse and the Enter key on the map."""
    window.action("grid").trigger()
    view = window.map_view
    for at in corners(window.live.prepared.skin, "hand"):
        left_click(view.viewport(), view.pixel_of(at).toPoint())
    QTest.keyClick(view, Qt.Key.Key_Return)
    run(window, 0.02)
    assert [patch.link for patch in window.live.prepared.skin.patches if is_grid_patch(patch)] == ["hand"]


def layout_of(window, patch):
    """Placement of the patch of this name on the map."""
    document = window.editor.document
    return document.layout.placements[[one.name for one in document.skin.patches].index(patch)]


def edited(window, angle=0.5):
    """Rotate the forearm; the document after it."""
    number = [patch.link for patch in window.live.prepared.skin.patches].index("forearm")
    window.editor.do("Rotate", lambda document: rotate(document, [number], angle))
    return window.editor.document


def question(window):
    """Names of the questions that are shown."""
    return [box.objectName() for box in window.findChildren(QMessageBox) if box.isVisible()]


def autosave(window):
    """Autosave the document, after an autosave that the timer started."""
    files = window.presenters.map_files
    files._wait()
    files.autosave()
    files._wait()


@pytest.mark.long
def test_grid_is_unsaved_until_it_is_undone(window):
    assert not window.isWindowModified()
    place_grid(window)
    assert question(window) == [], "nothing is lost by placing it"
    assert window.isWindowModified()
    for leave in (window.close, partial(window.presenters.files.open_robot, "arm")):
        leave()
        assert question(window) == ["leave"]
        answer(window, Button.Cancel)
        assert len(window.live.prepared.scene.grids) == 1
    window.action("poke").trigger()
    assert window.presenters.state.state.undo.undo_name == "Taxel grid"
    window.action("undo").trigger()
    assert window.live.prepared.scene.grids == ()
    assert not window.isWindowModified()
    window.action("redo").trigger()
    assert len(window.live.prepared.scene.grids) == 1
    assert window.isWindowModified()


@pytest.mark.long
def test_undo_and_redo_of_a_grid_keep_the_edits_of_the_map(window):
    first = window.editor.document
    before = edited(window)
    placement = layout_of(window, "forearm")
    place_grid(window)
    placed = window.editor.document
    assert layout_of(window, "forearm") == placement, "the patches that stay keep their edits"
    after = edited(window, 0.25)
    stages = [first, before, placed, after]
    for document in reversed(stages[:-1]):
        window.action("undo").trigger()
        assert window.editor.document is document
        run(window, 0.02)
        assert window.live.runner.session.map is document.map
    for document in stages[1:]:
        window.action("redo").trigger()
        assert window.editor.document is document
    assert not window.action("redo").isEnabled()
    for _ in range(2):
        window.action("undo").trigger()
    edited(window, 0.1)
    assert not window.action("redo").isEnabled(), "another edit was made instead"


def test_grid_keeps_controller_effects_and_edits_in_view(window):
    window.presenters.effects.choose("gravity", "on")
    controller = window.presenters.control_tools.settings_editor
    controller.do("choose", controller="hybrid", force_goal=4.5)
    forearm = [patch.link for patch in window.live.prepared.skin.patches].index("forearm")
    window.editor.do("Move", lambda document: move(document, [forearm], (0.5, 0.0)))
    run(window, 0.02)
    effects = window.live.runner.session.effects
    place_grid(window)
    settings = window.live.runner.session.settings
    assert (settings.controller, settings.force_goal) == ("hybrid", 4.5)
    assert window.live.runner.session.effects == effects
    view = window.map_view
    pixels = view.taxel_pixels()
    assert (pixels >= 0).all()
    assert (pixels <= [view.viewport().width(), view.viewport().height()]).all()


@pytest.mark.long
def test_path_stays_on_the_body_when_a_grid_changes_the_map(window):
    skin = window.live.prepared.skin
    before = window.editor.document.map
    forearm = [k for k in range(len(skin)) if skin.link(skin.taxel_point(k)) == "forearm"]
    path = tuple(tuple(before.to_map(skin.taxel_point(k)).tolist()) for k in (forearm[3], forearm[20]))
    window.presenters.control_tools.settings_editor.do("draw", path=path)
    run(window, 0.02)
    place_grid(window)
    after = window.editor.document.map
    for old, new in zip(path, window.live.runner.session.settings.path, strict=True):
        places = [map_.skin.position(map_.to_body(np.array(at))) for map_, at in ((before, old), (after, new))]
        np.testing.assert_allclose(*places, atol=1e-6)


@pytest.mark.long
def test_saved_scene_contains_the_grid(window, tmp_path, choose_file):
    place_grid(window)
    choose_file("save_file", tmp_path / "own.toml")
    window.action("save_scene").trigger()
    assert load_scene(str(tmp_path / "own.toml")).grids == window.live.prepared.scene.grids
    assert not window.isWindowModified()
    edited(window)
    assert window.isWindowModified()


def test_saving_the_map_reports_that_the_scene_contains_the_grid(window, tmp_path, choose_file):
    place_grid(window)
    choose_file("save_file", tmp_path / "own.npz")
    window.action("save_map_as").trigger()
    assert "Save the scene too" in window.notification_bar.text
    assert window.presenters.map_files.unsaved == ("skin",)


@pytest.mark.long
def test_grid_and_edits_are_restored_after_a_crash(window, prepared):
    place_grid(window)
    document = edited(window)
    scene = window.live.prepared.scene
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    assert "not saved" in window.notification_bar.text
    assert not window.isWindowModified()
    window.action("restore_map").trigger()
    run(window, 0.02)
    assert window.live.prepared.scene.grids == scene.grids
    restored = window.editor.document
    assert restored.layout == document.layout
    np.testing.assert_array_equal(restored.map.taxel_points, document.map.taxel_points)
    assert window.isWindowModified()
    assert "not saved when the program" not in window.notification_bar.text
    assert not window.action("restore_map").isEnabled()
    window.action("undo").trigger()
    assert window.live.prepared.scene.grids == ()


@pytest.mark.long
def test_replay_and_live_input_keep_the_grid(window, tmp_path):
    place_grid(window)
    replay_run(window, tmp_path / "a.mcap", 0.1)
    window.live.replay.leave()
    assert window.action("undo").isEnabled()
    (tmp_path / "readings.csv").write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv")))
    window.action("undo").trigger()
    assert window.live.live_input is not None
    assert "Disconnect first" in window.notification_bar.text
    window.action("disconnect").trigger()
    window.editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    for _ in range(2):
        window.action("undo").trigger()
    assert window.live.prepared.scene.grids == ()


def record_grid(window, path):
    """Record a scene with a grid that is in no scene file."""
    place_grid(window)
    record_run(window, path, 0.2)


def take_over(window, path, qtbot):
    """Take over a recording, giving up unsaved edits of the map behind it."""
    window.live.open_recording(path)
    window.live.replay.seek(0.1)
    window.action("take_over").trigger()
    if question(window):
        answer(window, Button.Discard)
    qtbot.waitUntil(lambda: window.live.mode is Mode.RUNNING)
    assert len(window.live.prepared.scene.grids) == 1


def test_grid_of_a_continued_recording_is_unsaved(window, tmp_path, qtbot, choose_file, prepared):
    record_grid(window, tmp_path / "a.mcap")
    take_over(window, tmp_path / "a.mcap", qtbot)
    assert window.isWindowModified(), "the same grid was placed before, and is not in a file either"
    window.presenters.map_files.give_up()
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
    assert not window.isWindowModified()
    take_over(window, tmp_path / "a.mcap", qtbot)
    assert window.isWindowModified()
    window.close()
    assert question(window) == ["leave"]
    answer(window, Button.Cancel)
    choose_file("save_file", tmp_path / "own.toml")
    window.action("save_scene").trigger()
    assert load_scene(str(tmp_path / "own.toml")).grids == window.live.prepared.scene.grids
    assert window.presenters.map_files.unsaved == ()
    assert not window.isWindowModified()
    take_over(window, tmp_path / "a.mcap", qtbot)
    assert not window.isWindowModified(), "the scene behind the recording has this grid in its file"


@pytest.mark.long
def test_grid_of_a_continued_recording_is_restored_after_a_crash(window, tmp_path, qtbot, prepared):
    record_grid(window, tmp_path / "a.mcap")
    take_over(window, tmp_path / "a.mcap", qtbot)
    grids = window.live.prepared.scene.grids
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    window.action("restore_map").trigger()
    run(window, 0.02)
    assert window.live.prepared.scene.grids == grids


@pytest.mark.long
def test_changes_of_the_skin_are_listed_in_the_history_and_reached_from_it(window):
    panel = window.column.get(HistoryPanel)

    def rows():
        return [
            panel.steps.index(row).data(Qt.ItemDataRole.AccessibleTextRole) for row in range(panel.steps.rowCount())
        ]

    def click(row):
        left_click(panel.list.viewport(), panel.list.visualRect(panel.steps.index(row)).center())
        run(window, 0.02)
        return len(window.live.prepared.scene.grids)

    opened = window.editor.document
    edited(window)
    place_grid(window)
    placed = window.editor.document
    edited(window, 0.2)
    assert rows() == ["Open, done", "Taxel grid, done", "Rotate, now"]
    assert click(0) == 0
    assert window.editor.document is opened
    assert rows() == ["Open, now", "Rotate, undone", "Taxel grid, undone"]
    assert click(2) == 1
    assert window.editor.document is placed, "the edits after the step are undone"
    assert rows() == ["Open, done", "Taxel grid, now", "Rotate, undone"]
    window.action("undo").trigger()
    run(window, 0.02)
    assert rows() == ["Open, now", "Rotate, undone", "Taxel grid, undone"]
    for _ in range(2):
        window.action("redo").trigger()
    assert window.editor.document is placed
    for _ in range(2):
        window.action("undo").trigger()
    run(window, 0.02)
    window.action("redo").trigger()
    edited(window, 0.1)
    assert rows() == ["Open, done", "Rotate, done", "Rotate, now"], "the grid cannot be redone any more"
