"""Message at the start about edits that a crash left of documents that are not opened."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.scene.scene_file import scene_for
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_widgets.common.settings import Settings
from tactile_widgets.session.backends import INLINE
from tactile_widgets.window.main_window import MainWindow
from tests.widgets.support.window_driver import click_remedy

pytestmark = pytest.mark.usefixtures("scene_cache")


@pytest.fixture
def start(qapp, tmp_path, own_files):
    """Function that opens another window on a scene, as a start of the program does."""
    windows = []

    def started(prepared):
        window = MainWindow(Settings(tmp_path / f"{len(windows)}.ini"), backends=INLINE)
        windows.append(window)
        window.resize(1400, 900)
        window.show()
        window.live.show_prepared(pickle.loads(pickle.dumps(prepared)))
        return window

    yield started
    for window in windows:
        window.presenters.map_files.give_up()
        window.close()
        window.deleteLater()


@pytest.fixture
def crash():
    """Function that edits a map and ends the window's work on it, with the copy left; returns the edited document."""

    def crashed(window, edit):
        assert window.editor.do("Edit", edit)
        files = window.presenters.map_files
        files.autosave()
        files.end()
        return window.editor.document

    return crashed


def turned(document):
    return rotate(document, [0], 0.5)


def texts(window):
    """Texts of the messages about edits that were not saved."""
    return [message.text for message in window.notification_bar.messages if "not saved when" in message.text]


@pytest.fixture
def box(tmp_path):
    """Another robot: a box of few taxels."""
    mesh = box_mesh(0.1)
    lines = [f"v {x} {y} {z}" for x, y, z in mesh.vertices] + [f"f {a} {b} {c}" for a, b, c in mesh.faces + 1]
    path = tmp_path / "box.obj"
    path.write_text("\n".join(lines))
    scene = scene_for(str(path))
    return prepare_cached(replace(scene, cover=replace(scene.cover, taxels=20)))


def test_start_names_unsaved_work_of_another_document_and_opens_it(start, crash, prepared, small_arm):
    left = crash(start(small_arm), turned)
    window = start(prepared)
    (text,) = texts(window)
    assert text.startswith(f"{small_arm.scene.title} has edits")
    assert "other document" not in text
    assert window.action("open_unsaved").isEnabled()
    click_remedy(window, "Open document")
    assert window.live.prepared.scene == small_arm.scene
    assert not window.action("open_unsaved").isEnabled()
    click_remedy(window, "Restore edits")
    assert window.editor.document.layout == left.layout
    assert window.presenters.map_files.unsaved == ("map",)


@pytest.mark.long
def test_scene_file_of_the_unsaved_document_is_opened(start, crash, prepared, small_arm, tmp_path, choose_file):
    own = tmp_path / "own.toml"
    window = start(small_arm)
    choose_file("save_file", own)
    window.action("save_scene").trigger()
    crash(window, turned)
    window = start(prepared)
    (text,) = texts(window)
    assert text.startswith("own.toml has edits")
    click_remedy(window, "Open document")
    assert window.presenters.scene_file.path == own


def test_skin_in_no_file_is_opened_as_unsaved(start, crash, prepared, small_arm, box):
    window = start(prepared)
    window.presenters.files.open_scene(small_arm.scene, chosen=True)
    left = crash(window, turned)
    window = start(box)
    click_remedy(window, "Open document")
    assert window.presenters.map_files.unsaved == ("skin",)
    click_remedy(window, "Restore edits")
    assert window.editor.document.layout == left.layout


@pytest.mark.long
def test_document_that_is_opened_at_the_start_is_only_offered(start, crash, prepared):
    crash(start(prepared), turned)
    window = start(prepared)
    (text,) = texts(window)
    assert text.startswith("This map has edits")
    assert not window.action("open_unsaved").isEnabled()


@pytest.mark.long
def test_document_that_another_window_has_open_is_not_named(start, prepared, small_arm):
    other = start(small_arm)
    assert other.editor.do("Edit", turned)
    other.presenters.map_files.autosave()
    other.presenters.map_files._wait()
    window = start(prepared)
    assert not texts(window)
    assert not window.action("open_unsaved").isEnabled()


@pytest.mark.long
def test_newest_of_several_documents_is_named_first(start, crash, prepared, small_arm, box):
    coarse = replace(prepared, scene=replace(prepared.scene, title="Coarse arm"))
    crash(start(coarse), turned)
    crash(start(small_arm), lambda document: move(document, [0], (0.05, 0.0)))
    window = start(box)
    (text,) = texts(window)
    assert text.startswith(f"{small_arm.scene.title} has edits")
    assert text.endswith("1 other document with such edits can be opened after it.")
    click_remedy(window, "Open document")
    first, second = texts(window)
    assert first.startswith("This map has edits")
    assert second.startswith("Coarse arm has edits")
    assert "other document" not in second


@pytest.mark.long
def test_dismissed_message_does_not_return_when_something_else_is_opened(start, crash, prepared, small_arm, box):
    crash(start(small_arm), turned)
    window = start(prepared)
    click_remedy(window, "Dismiss")
    assert not texts(window)
    window.live.show_prepared(box)
    assert not texts(window)
    assert window.action("open_unsaved").isEnabled(), "still in the menu"


def test_damaged_copies_are_ignored(start, prepared, tmp_path):
    folder = tmp_path / "state" / "autosave"
    folder.mkdir(parents=True)
    (folder / "a file").write_text("")
    broken = folder / "broken" / "1"
    broken.mkdir(parents=True)
    (broken / "untitled.npz.autosave").write_bytes(b"damaged")
    window = start(prepared)
    assert not texts(window)
