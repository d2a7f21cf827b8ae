"""Content that arrives from the background replaces no work that the user was not asked about."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.document_file import load_document
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.dialogs import Button
from tactile_widgets.document.skin_steps import have_same_skin
from tests.widgets.presenters.files.test_grid_edits import autosave
from tests.widgets.presenters.test_live_input_presenter import draw_path
from tests.widgets.presenters.test_skin_presenter import click, click_box, counts
from tests.widgets.support.window_driver import answer, press_map, run

pytestmark = pytest.mark.usefixtures("scene_cache")
COVERS = {"follow_path": ("forearm",), "poke": ("forearm", "upper_arm")}
"""Links with skin in the scenes that are opened: each has a skin of its own."""


@pytest.fixture
def window(window_again, monkeypatch):
    """Scenes are prepared when ``arrive`` is called, as in a process that takes long."""

    def prepare(scene, **options):
        if links := COVERS.get(scene.name):
            scene = replace(scene, cover=replace(scene.cover, links=links, taxels=60, thickness=0.01))
        return prepare_cached(scene, **options)

    monkeypatch.setattr("tactile_widgets.jobs.scene_jobs.prepare_cached", prepare)
    monkeypatch.setattr("tactile_widgets.session.session_host.find_prepared", lambda _scene: None)
    window_again.live.scene_jobs.executor.hold = True
    yield window_again
    window_again.live.scene_jobs.executor.hold = False
    window_again.live.cancel_loading()


@pytest.fixture
def saving(monkeypatch, tmp_path):
    """Return ``kept.npz`` or ``kept.toml`` from each save dialog."""
    monkeypatch.setattr(
        FileDialog,
        "save_file",
        lambda _parent, title, *_args: str(tmp_path / ("kept.npz" if title == "Save map" else "kept.toml")),
    )


def arrive(window):
    """Complete what is being opened."""
    window.live.scene_jobs.executor.run_waiting()
    run(window, 0.02)


def links(window):
    """Links with skin in the session."""
    return {*counts(window)}


def edited(window, angle=0.3):
    """The document after another edit."""
    window.editor.do("Rotate", lambda document: rotate(document, [0], angle))
    return window.editor.document


def open_scene(window, name):
    window.presenters.files.open_shipped(name)


def question(window):
    """Text of the question that is shown; empty without one."""
    return next((box.text() for box in window.findChildren(QMessageBox) if box.isVisible()), "")


def apply_skin(window, *names):
    """Check links in the panel and apply."""
    window.action("choose_skin").trigger()
    for link in names:
        click_box(window, link)
    click(window, "skin-apply")


def key(window, letter):
    QTest.keyClick(window.map_view, letter, Qt.KeyboardModifier.ControlModifier)


@pytest.fixture
def changed(window):
    """Window on a changed skin, with another change being made."""
    apply_skin(window, "wrist")
    arrive(window)
    assert "wrist" in links(window)
    apply_skin(window, "turret")
    assert window.live.opening
    return window


@pytest.mark.long
def test_undo_cancels_the_skin_that_is_being_made(changed):
    window = changed
    shown = window.live.prepared
    window.map_view.setFocus()
    key(window, Qt.Key.Key_Z)
    assert not window.live.opening
    assert window.statusBar().currentMessage() == "Change skin: cancelled"
    arrive(window)
    assert window.live.prepared is shown
    assert window.isWindowModified()
    undo = window.presenters.state.state.undo
    assert (undo.can_undo, undo.can_redo) == (True, True)
    window.action("redo").trigger()
    arrive(window)
    assert "turret" in links(window)
    assert window.isWindowModified()
    for _ in range(2):
        key(window, Qt.Key.Key_Z)
    run(window, 0.02)
    assert not {"wrist", "turret"} & links(window)
    assert not window.isWindowModified()


@pytest.mark.long
def test_work_made_while_a_skin_is_prepared_is_kept(changed):
    window = changed
    document = edited(window)
    window.live.failed.emit("A measurement failed")
    draw_path(window, (5, 12, 20))
    path = window.live.runner.session.settings.path
    window.action("poke").trigger()
    arrive(window)
    assert "turret" in links(window)
    assert window.editor.history.names == ("Change skin",)
    assert window.isWindowModified()
    assert len(window.live.runner.session.settings.path) == len(path)
    window.action("undo").trigger()
    assert window.editor.document is document
    run(window, 0.02)
    assert window.live.runner.session.settings.path == path
    assert window.action("redo").isEnabled()
    window.action("undo").trigger()
    run(window, 0.02)
    assert window.live.runner.session.settings.path == (), "it was drawn before the new skin was shown"
    assert window.editor.document is document
    for _ in range(2):
        window.action("redo").trigger()
        run(window, 0.02)
    assert "turret" in links(window)
    assert len(window.live.runner.session.settings.path) == len(path)


@pytest.mark.long
def test_step_that_replaces_one_being_made_follows_the_skin_that_is_shown(changed):
    window = changed
    before = links(window)
    apply_skin(window, "shoulder")
    arrive(window)
    window.action("undo").trigger()
    arrive(window)
    assert links(window) == before


@pytest.mark.parametrize(
    "button",
    [Button.Cancel, *(pytest.param(button, marks=pytest.mark.long) for button in (Button.Save, Button.Discard))],
)
def test_edits_made_while_another_robot_is_opened_are_asked_about(window, saving, tmp_path, button):
    open_scene(window, "follow_path")
    document = edited(window)
    arrive(window)
    assert question(window).endswith("not saved: map.")
    assert window.editor.document is document
    answer(window, button)
    run(window, 0.02)
    assert (tmp_path / "kept.npz").is_file() == (button == Button.Save)
    assert not window.live.opening
    if button == Button.Cancel:
        assert window.editor.document is document
        assert window.isWindowModified()
    else:
        assert links(window) == {"forearm"}
        assert not window.isWindowModified()


@pytest.mark.long
def test_path_drawn_while_another_robot_is_opened_is_asked_about(window):
    open_scene(window, "poke")
    draw_path(window, (5, 12, 20))
    path = window.live.runner.session.settings.path
    arrive(window)
    assert "path" in question(window)
    answer(window, Button.Cancel)
    assert window.live.runner.session.settings.path == path


@pytest.mark.long
def test_discarded_edits_are_not_asked_about_again_unless_there_are_newer_ones(window):
    edited(window)
    open_scene(window, "follow_path")
    answer(window, Button.Discard)
    arrive(window)
    assert question(window) == ""
    assert links(window) == {"forearm"}
    edited(window)
    open_scene(window, "poke")
    answer(window, Button.Discard)
    newer = edited(window)
    arrive(window)
    assert question(window)
    answer(window, Button.Cancel)
    assert window.editor.document is newer


@pytest.mark.parametrize("button", [pytest.param(Button.Save, marks=pytest.mark.long), Button.Cancel])
def test_robot_that_arrives_during_a_question_waits_for_the_answer(window, saving, tmp_path, button, qtbot):
    open_scene(window, "follow_path")
    document = edited(window)
    open_scene(window, "poke")
    arrive(window)
    assert window.editor.document is document
    answer(window, button)
    if button == Button.Save:
        assert load_document(tmp_path / "kept.npz").layout == document.layout
        assert window.editor.document is document
        arrive(window)
        assert links(window) == {"forearm", "upper_arm"}, "the first robot was replaced by the second one"
    else:
        qtbot.waitUntil(lambda: bool(question(window)))
        answer(window, Button.Discard)
        assert links(window) == {"forearm"}


@pytest.mark.long
def test_robot_that_arrives_while_a_file_is_chosen_waits(window, monkeypatch, tmp_path, qtbot):
    open_scene(window, "follow_path")
    document = edited(window)

    def choose(*_args):
        box = QMessageBox(window)  # as modal as a file dialog
        box.open()
        arrive(window)
        assert window.editor.document is document
        box.close()
        box.deleteLater()
        return str(tmp_path / "own.npz")

    monkeypatch.setattr(FileDialog, "save_file", choose)
    window.action("save").trigger()
    assert load_document(tmp_path / "own.npz").layout == document.layout
    qtbot.waitUntil(lambda: links(window) == {"forearm"})


def test_recording_ends_the_opening_of_a_scene(window, tmp_path):
    window.live.recording.start(tmp_path / "a.mcap")
    press_map(window, 5)
    run(window, 0.2)
    window.presenters.touch.release()
    window.live.recording.stop()
    open_scene(window, "follow_path")
    window.presenters.files.open_path(str(tmp_path / "a.mcap"))
    arrive(window)
    assert window.live.mode is Mode.REPLAYING
    window.live.replay.leave()
    assert not window.isWindowModified()


@pytest.mark.long
def test_discarded_edits_leave_no_autosave_when_a_second_question_is_cancelled(window, prepared, tmp_path):
    edited(window)
    autosave(window)
    assert list((tmp_path / "state").rglob("*.autosave"))
    open_scene(window, "follow_path")
    answer(window, Button.Discard)
    open_scene(window, "poke")
    answer(window, Button.Cancel)
    arrive(window)
    assert links(window) == {"forearm"}
    assert not list((tmp_path / "state").rglob("*.autosave"))
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
    assert not window.presenters.map_files.restorable


def test_scene_saved_before_another_leaves_no_autosave(window, saving, prepared, tmp_path):
    draw_path(window, (5, 12, 20))
    autosave(window)
    assert list((tmp_path / "state").rglob("*.autosave"))
    window.presenters.map_files.leave(lambda: window.live.show_prepared(pickle.loads(pickle.dumps(prepared))))
    answer(window, Button.Save)
    assert (tmp_path / "kept.toml").is_file()
    assert not list((tmp_path / "state").rglob("*.autosave"))


def effects_of(window):
    """Effects of the session, and the chosen ones of the scene that would be saved."""
    return window.live.runner.session.effects.friction, dict(window.presenters.scene_file.scene.overrides)


def test_effects_chosen_while_a_skin_is_prepared_are_kept(window, saving, tmp_path):
    effects = window.presenters.effects
    apply_skin(window, "wrist")
    effects.choose("friction", "on")
    arrive(window)
    assert "wrist" in links(window)
    assert effects_of(window) == (True, {"friction": "on"})
    assert have_same_skin(effects.scene, window.live.prepared.scene)
    assert "effects" in window.presenters.map_files.unsaved
    window.action("undo").trigger()
    run(window, 0.02)
    assert "wrist" not in links(window)
    assert effects_of(window) == (True, {"friction": "on"})
    assert have_same_skin(effects.scene, window.live.prepared.scene)
    window.action("save_scene").trigger()
    assert load_scene(str(tmp_path / "kept.toml")).effects.friction
    effects.choose("friction", "off")
    run(window, 0.02)
    window.action("redo").trigger()
    run(window, 0.02)
    assert effects_of(window) == (True, {"friction": "on"}), "as this skin had them"


def test_first_skin_that_is_being_prepared_is_asked_about_and_saved_once_it_is_there(window, saving, tmp_path):
    apply_skin(window, "wrist")
    assert window.isWindowModified()
    closed = []
    window.presenters.map_files.leave(lambda: closed.append(links(window)))
    assert "skin" in question(window)
    answer(window, Button.Cancel)
    assert window.live.opening
    window.presenters.map_files.leave(lambda: closed.append(links(window)))
    answer(window, Button.Save)
    assert closed == []
    arrive(window)
    assert closed == [{"upper_arm", "forearm", "hand", "wrist"}]
    assert "wrist" in load_scene(str(tmp_path / "kept.toml")).cover.links


@pytest.mark.long
def test_window_stays_if_the_skin_to_be_saved_is_cancelled(window, saving, tmp_path):
    apply_skin(window, "wrist")
    closed = []
    window.presenters.map_files.leave(lambda: closed.append(True))
    answer(window, Button.Save)
    window.live.cancel_loading()
    apply_skin(window, "elbow")
    arrive(window)
    assert closed == []
    assert not (tmp_path / "kept.toml").exists()


def test_discarded_skin_that_is_being_prepared_does_not_arrive(window):
    apply_skin(window, "wrist")
    closed = []
    window.presenters.map_files.leave(lambda: closed.append(True))
    answer(window, Button.Discard)
    assert closed == [True]
    assert not window.live.opening
    assert not window.isWindowModified()


@pytest.mark.long
def test_document_with_another_skin_is_restored_after_a_crash_as_it_was(window, prepared):
    apply_skin(window, "wrist")
    arrive(window)
    window.presenters.effects.choose("friction", "on")
    draw_path(window, (5, 12, 20))
    document = edited(window)
    run(window, 0.02)
    session = window.live.runner.session
    before = (links(window), session.settings, session.effects, window.presenters.scene_file.scene)
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    assert not window.isWindowModified()
    window.action("restore_map").trigger()
    arrive(window)
    session = window.live.runner.session
    scene = window.presenters.scene_file.scene
    assert (links(window), session.effects) == (before[0], before[2])
    assert replace(session.settings, starts=0) == replace(before[1], starts=0)
    assert scene == before[3]
    assert have_same_skin(window.presenters.effects.scene, scene)
    assert window.editor.document.layout == document.layout
    assert set(window.presenters.map_files.unsaved) >= {"map", "skin", "path", "controller", "effects"}
    window.action("poke").trigger()  # the tool of the path has its own undo
    window.action("undo").trigger()
    run(window, 0.02)
    assert "wrist" not in links(window)
