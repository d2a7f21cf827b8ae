"""Path, goals, controller and behaviours are part of the document: kept, asked about, and saved with the scene."""

from __future__ import annotations

import pickle
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QMessageBox, QToolButton

from tactile_maps.contacts.pipeline import reading_from
from tactile_maps.control.behaviours import Behaviour, behaviours_from
from tactile_maps.control.controller_registry import settings_from
from tactile_maps.editing.arrange import rotate
from tactile_maps.editing.document_file import load_document
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.dialogs import Button
from tests.support.touch import bar_map
from tests.widgets.presenters.files.test_grid_edits import autosave, place_grid
from tests.widgets.presenters.test_live_input_presenter import connect, draw_path
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import answer, press_map, record_run, replay_run, run

pytestmark = pytest.mark.usefixtures("scene_cache")
TAXELS = 150
COARSE = 0.01
"""Thickness of the skin [m]; its triangles are as large."""


@pytest.fixture(autouse=True)
def opened_coarse(monkeypatch):
    """Open every robot and scene in a coarse skin, which is prepared in a tenth of the time."""

    def prepare_coarse(scene, **options):
        cover = replace(scene.cover, taxels=min(scene.cover.taxels, TAXELS), thickness=COARSE)
        return prepare_cached(replace(scene, cover=cover), **options)

    monkeypatch.setattr("tactile_widgets.jobs.scene_jobs.prepare_cached", prepare_coarse)


@pytest.fixture
def window(window_again):
    yield window_again
    window_again.live.set_behaviours(())  # the lists of the panel would outlive the test
    run(window_again, 0.02)


def test_first_map_of_a_scene_without_a_file_proposes_its_name_for_the_scene(window, saving, tmp_path):
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    window.action("save").trigger()
    (saved,) = tmp_path.glob("*.npz")
    assert f"Save the scene as {saved.stem}.toml to open both together" in window.notification_bar.text
    QApplication.processEvents()
    button = window.notification_bar.findChildren(QToolButton, "message-remedy")[-1]
    left_click(button)
    assert saving == ["Save map", "Save scene"]
    assert load_scene(str(saved.with_suffix(".toml"))).robot == "arm"
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    window.action("save").trigger()
    assert "Save the scene" not in window.notification_bar.text


@pytest.fixture
def saving(monkeypatch, tmp_path):
    """Return a file of this folder from each save dialog, and record the titles of the dialogs."""
    titles = []

    def chosen(_parent, title, name, _kinds):
        titles.append(title)
        return str(tmp_path / name.rpartition("/")[2])

    monkeypatch.setattr(FileDialog, "save_file", chosen)
    return titles


def test_save_dialogs_propose_the_name_of_the_own_document(window, prepared, monkeypatch, tmp_path):
    proposed = []

    def choose(_parent, _title, name, _kinds):
        proposed.append(name.rpartition("/")[2])
        return str(tmp_path / f"mine{Path(name).suffix}")

    monkeypatch.setattr(FileDialog, "save_file", choose)
    window.action("save_scene").trigger()
    window.action("save_scene").trigger()
    window.action("save_map_as").trigger()
    window.action("save_map_as").trigger()
    assert proposed == ["arm.toml", "mine.toml", "mine.npz", "mine.npz"]
    proposed.clear()
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as *File > Scenes* does
    window.action("save_scene").trigger()
    assert proposed == ["arm.toml"], "not the file of the document before"
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
    window.action("save_map_as").trigger()
    assert proposed == ["arm.toml", "arm.npz"]


def question(window):
    """Text of the visible question, or an empty string."""
    return next((box.text() for box in window.findChildren(QMessageBox) if box.isVisible()), "")


def made(window):
    """Settings of the controller in the session that runs."""
    return replace(window.live.runner.session.settings, starts=0)


def test_drawn_path_is_asked_about_and_kept(window):
    assert not window.isWindowModified()
    draw_path(window, (5, 12, 20))
    own = made(window)
    assert own.path
    assert window.isWindowModified()
    for leave in (window.close, partial(window.presenters.files.open_robot, "arm")):
        leave()
        assert question(window).endswith("not saved: path, controller.")
        answer(window, Button.Cancel)
    window.action("reset").trigger()
    run(window, 0.05)
    assert made(window) == own
    while window.action("undo").isEnabled():
        window.action("undo").trigger()
    assert not window.isWindowModified()


@pytest.mark.parametrize("name", ["take_over", pytest.param("connect", marks=pytest.mark.long)])
def test_action_in_a_replay_asks_about_the_unsaved_path_of_the_scene(window, tmp_path, name):
    record_run(window, tmp_path / "a.mcap", 0.2)
    draw_path(window, (5, 12, 20))
    own = made(window)
    window.live.open_recording(tmp_path / "a.mcap")
    window.action(name).trigger()
    assert "path" in question(window)
    answer(window, Button.Cancel)
    window.live.replay.leave()
    assert made(window) == own


def test_saved_scene_contains_path_controller_and_behaviours(new_window, saving, tmp_path):
    window = new_window
    draw_path(window, (5, 12, 20))
    window.column["controller"].choose_controller("parallel")
    window.live.set_behaviours((Behaviour("tap", times=2, then={"task": "retreat"}),))
    run(window, 0.05)
    assert window.presenters.map_files.unsaved == ("path", "controller", "behaviours")
    window.action("save_scene").trigger()
    assert window.presenters.map_files.unsaved == ()
    scene = load_scene(str(next(tmp_path.glob("*.toml"))))
    assert settings_from(scene.control) == made(window)
    assert behaviours_from(scene.behaviours) == window.live.run.settings.behaviours
    connect(window, tmp_path)
    window.action("disconnect").trigger()
    assert window.presenters.map_files.unsaved == (), "the same scene continues"
    assert window.windowTitle().startswith("arm.toml[*] – arm – running")


def test_contact_threshold_and_effects_are_saved_and_restored_after_a_crash(window, prepared, saving, tmp_path):
    before = window.live.run.settings
    assert window.presenters.map_files.unsaved == ()
    reading = replace(before.reading, threshold=2500.0)
    window.live.set_reading(reading)
    window.presenters.effects.choose("friction", "on")
    run(window, 0.05)
    effects = window.live.run.settings.effects
    assert effects != before.effects
    assert window.presenters.map_files.unsaved == ("contact detection", "effects")
    assert window.isWindowModified()
    window.presenters.files.open_robot("arm")
    assert question(window).endswith("not saved: contact detection, effects.")
    answer(window, Button.Cancel)
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    assert window.live.run.settings.reading != reading
    window.action("restore_map").trigger()
    run(window, 0.02)
    assert window.live.run.settings.reading == reading
    assert window.live.run.settings.effects == effects
    window.action("undo").trigger()  # the map of the copy, which was not edited
    window.action("save_scene").trigger()
    assert window.presenters.map_files.unsaved == ()
    scene = load_scene(str(next(tmp_path.glob("*.toml"))))
    assert (reading_from(scene.reading), scene.effects) == (reading, effects)
    window.presenters.effects.choose("friction", "auto")
    run(window, 0.02)
    assert window.presenters.map_files.unsaved == ("effects",)
    window.presenters.effects.choose("friction", "on")
    run(window, 0.02)
    assert window.presenters.map_files.unsaved == ()


def test_saved_scene_has_the_effects_that_ran_although_its_controller_would_need_others(
    window, prepared, saving, tmp_path
):
    """The effects of a running session do not change with its controller; those that a scene file decides do."""
    without_touch = replace(prepared.scene, task="view", outputs=("posture",))
    window.live.show_prepared(replace(prepared, scene=without_touch))
    before = window.live.run.settings.effects
    assert before.skin == "off"
    window.column["controller"].choose_controller("parallel")
    run(window, 0.02)
    assert window.live.run.settings.effects == before
    window.action("save_scene").trigger()
    scene = load_scene(str(next(tmp_path.glob("*.toml"))))
    assert settings_from(scene.control) == made(window)
    assert scene.effects == before


def test_saving_before_another_robot_saves_skin_path_and_map(window, saving, tmp_path, qtbot):
    place_grid(window)
    draw_path(window, (5, 12, 20))
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    run(window, 0.05)
    own = made(window)
    document = window.editor.document
    window.presenters.files.open_robot("arm")
    assert question(window).endswith("not saved: map, skin, path, controller.")
    answer(window, Button.Save)
    qtbot.waitUntil(lambda: window.live.prepared.scene.grids == (), timeout=60_000)
    assert saving == ["Save scene"], "the map is saved next to it"
    assert window.presenters.map_files.unsaved == ()
    scene = load_scene(str(next(tmp_path.glob("*.toml"))))
    assert len(scene.grids) == 1
    assert settings_from(scene.control) == own
    assert load_document(next(tmp_path.glob("*.npz"))).layout == document.layout


def on_body(window):
    """Places on the body of the path's points."""
    return [window.editor.document.map.to_body(np.array(point)) for point in made(window).path]


def test_edit_of_a_patch_without_the_path_does_not_change_the_scene(window, saving):
    draw_path(window, (5, 12, 20))
    assert {place.patch for place in on_body(window)} == {0}
    window.action("save").trigger()
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    run(window, 0.05)
    assert window.presenters.map_files.unsaved == ("map",)
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    run(window, 0.05)
    assert window.presenters.map_files.unsaved == ("map", "path")


def test_scene_and_map_are_saved_and_opened_as_one_document(window, saving, tmp_path):
    draw_path(window, (5, 12, 20))
    first = on_body(window)
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    run(window, 0.05)
    own = made(window)
    places = on_body(window)
    for place, before in zip(places, first, strict=True):
        assert (place.patch, place.face) == (before.patch, before.face)
        np.testing.assert_allclose(place.weights, before.weights, atol=1e-9)
    layout = window.editor.document.layout
    window.action("save").trigger()
    assert saving == ["Save scene"]
    (scene,) = tmp_path.glob("*.toml")
    saved = [one.text for one in window.notification_bar.messages if one.text.startswith("Saved")]
    assert saved == [f"Saved {scene.with_suffix('.npz')} and {scene.name}"]
    assert window.windowTitle().startswith(f"{scene.name}[*]")
    assert window.presenters.map_files.unsaved == ()
    window.presenters.files.open_robot("arm")
    assert window.editor.document.layout != layout
    window.presenters.files.open_path(str(scene))
    assert window.presenters.map_files.unsaved == ()
    assert (window.editor.document.layout, made(window)) == (layout, own)
    assert on_body(window) == places
    assert window.map_view._task.path
    assert window.presenters.map_files.path == scene.with_suffix(".npz")
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    window.action("save").trigger()
    assert saving == ["Save scene"], "the file of the map is known"
    window.presenters.effects.choose("friction", "on")
    run(window, 0.02)
    window.action("save").trigger()
    assert saving == ["Save scene"], "so is that of the scene"
    assert window.presenters.map_files.unsaved == ()
    scene.write_text("# mine\n" + scene.read_text())
    window.presenters.effects.choose("friction", "auto")
    run(window, 0.02)
    window.action("save").trigger()
    assert saving == ["Save scene", "Save scene"], "a comment would be lost"


@pytest.mark.long
def test_map_of_another_skin_next_to_a_scene_is_reported_and_not_opened(window, saving, tmp_path):
    draw_path(window, (5, 12, 20))
    window.action("save").trigger()
    (scene,) = tmp_path.glob("*.toml")
    save_map(bar_map(), scene.with_suffix(".npz"))
    window.presenters.files.open_path(str(scene))
    assert "The map next to the scene is not opened" in window.notification_bar.text
    assert window.presenters.map_files.unsaved == ()
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    window.action("save").trigger()
    assert saving == ["Save scene", "Save map"], "the other map is not replaced without a question"


def test_cancelled_save_of_the_scene_keeps_everything(window, monkeypatch):
    draw_path(window, (5, 12, 20))
    own = made(window)
    monkeypatch.setattr(FileDialog, "save_file", lambda *_asked: "")
    window.presenters.files.open_robot("arm")
    answer(window, Button.Save)
    run(window, 0.05)
    assert made(window) == own


@pytest.mark.long
def test_path_and_behaviours_are_restored_after_a_crash(window, prepared):
    draw_path(window, (5, 12, 20))
    behaviours = (Behaviour("tap", times=2, then={"task": "retreat"}),)
    window.live.set_behaviours(behaviours)
    run(window, 0.05)
    own = made(window)
    autosave(window)
    window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))  # as another start of the program does
    assert made(window) != own
    window.action("restore_map").trigger()
    run(window, 0.02)
    assert made(window) == own
    assert window.live.run.settings.behaviours == behaviours
    assert window.presenters.map_files.unsaved[-3:] == ("path", "controller", "behaviours")


@pytest.mark.long
def test_recording_with_the_same_path_is_taken_over_without_a_question(window, tmp_path, qtbot):
    draw_path(window, (5, 12, 20))
    own = made(window)
    replay_run(window, tmp_path / "a.mcap", 0.2)
    window.action("take_over").trigger()
    assert question(window) == ""
    qtbot.waitUntil(lambda: window.live.mode is Mode.RUNNING)
    assert made(window) == own


def test_change_by_a_behaviour_is_not_work_of_the_user(window):
    window.live.set_behaviours((Behaviour("touch", then={"controller": "hold_force"}),))
    pixel = press_map(window, 20)
    run(window, 0.5)
    left_release(window.map_view.viewport(), pixel)
    assert made(window).controller == "hold_force"
    assert window.presenters.map_files.unsaved == ("behaviours",)


@pytest.mark.long
def test_repeated_touches_keep_behaviours_and_contact_detection(window, tmp_path):
    window.live.recording.start(tmp_path / "a.mcap")
    pixel = press_map(window, 20)
    run(window, 0.2)
    left_release(window.map_view.viewport(), pixel)
    run(window, 0.1)
    window.live.recording.stop()
    behaviours = (Behaviour("tap", times=2, then={"task": "retreat"}),)
    window.live.set_behaviours(behaviours)
    reading = replace(window.live.run.settings.reading, threshold=2500.0)
    window.live.set_reading(reading)
    run(window, 0.05)
    window.live.open_recording(tmp_path / "a.mcap")
    window.action("repeat_touches").trigger()
    assert window.live.mode is Mode.RUNNING
    assert window.live.run.settings.behaviours == behaviours
    assert window.live.run.settings.reading == reading


def test_title_shows_document_robot_and_mode(new_window, tmp_path):
    window = new_window
    assert window.windowTitle().endswith("[*] – arm – running – Tactile Maps")
    window.action("pause").trigger()
    assert window.windowTitle().endswith("[*] – arm – paused – Tactile Maps")
    window.action("pause").trigger()
    connect(window, tmp_path)
    assert window.windowTitle().endswith("[*] – arm – live – Tactile Maps")
    window.action("disconnect").trigger()
