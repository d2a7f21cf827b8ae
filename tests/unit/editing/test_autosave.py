"""What is not saved is known, and outlives a crash."""

from __future__ import annotations

import os

import pytest

from app.editing.arrange import move
from app.editing.autosave import DocumentFile
from app.editing.document_file import document_to_bytes, load_document
from app.editing.history import History
from app.errors import MapError


@pytest.fixture
def kept(document, tmp_path):
    """A saved document's file."""
    file = DocumentFile(None, None)
    file.save_as(document, tmp_path / "map.npz")
    return file


def _later(path, seconds):
    """The file's time set relative to now, so that no test needs to wait."""
    now = path.stat().st_mtime
    os.utime(path, (now + seconds, now + seconds))


def test_what_was_undone_to_is_saved(document, kept):
    history = History(document)
    assert not kept.unsaved(history.present)
    history.do("Move", move(document, [0], (0.1, 0.0)))
    assert kept.unsaved(history.present)
    kept.save(history.present)
    assert not kept.unsaved(history.present)
    assert kept.unsaved(history.undo())
    assert not kept.unsaved(history.redo())


def test_a_new_document_has_no_file_yet(document):
    file = DocumentFile(None, None)
    assert file.unsaved(document)
    assert not file.autosave(document)
    assert file.recovery() is None
    with pytest.raises(MapError, match="no file yet"):
        file.save(document)


def test_an_opened_document_is_saved(document, kept):
    file, opened = DocumentFile.open(kept.path)
    assert not file.unsaved(opened)
    assert document_to_bytes(opened) == document_to_bytes(document)


def test_a_crash_leaves_a_recovery_that_is_the_last_autosave(document, kept):
    moved = move(document, [0], (0.1, 0.0))
    assert kept.autosave(moved)
    _later(kept.autosave_file, 7)
    file, opened = DocumentFile.open(kept.path)
    found = file.recovery()
    assert found.newer == pytest.approx(7, abs=2)
    back = load_document(found.file)
    assert document_to_bytes(back) == document_to_bytes(moved)
    assert file.unsaved(back)
    assert not file.unsaved(opened)
    file.save(back)
    assert file.recovery() is None
    assert not found.file.exists()


def test_an_autosave_older_than_the_file_is_no_recovery(document, kept):
    kept.autosave(move(document, [0], (0.1, 0.0)))
    _later(kept.path, 60)
    assert DocumentFile.open(kept.path)[0].recovery() is None


def test_only_what_changed_is_autosaved(document, kept):
    moved = move(document, [0], (0.1, 0.0))
    assert not kept.autosave(document)
    assert kept.autosave(moved)
    assert not kept.autosave(moved)
    assert kept.autosave(move(moved, [0], (0.1, 0.0)))
    assert not kept.autosave(document), "undone to what is saved there is nothing to recover"
    assert not kept.autosave_file.exists()


def test_a_document_without_a_file_is_autosaved_in_a_folder(document, tmp_path):
    file = DocumentFile(None, None, folder=tmp_path)
    assert file.autosave(document)
    found = DocumentFile(None, None, folder=tmp_path).recovery()
    assert found.newer == float("inf")
    file.save_as(document, tmp_path / "named.npz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["named.npz"]


def test_saving_elsewhere_moves_on_and_leaves_the_old_file(document, kept, tmp_path):
    moved, old = move(document, [0], (0.1, 0.0)), kept.path
    kept.autosave(moved)
    kept.save_as(moved, tmp_path / "other.npz")
    assert kept.path.name == "other.npz"
    assert not kept.unsaved(moved)
    assert document_to_bytes(load_document(old)) == document_to_bytes(document)
    assert not list(tmp_path.glob("*.autosave"))


def test_a_failed_save_changes_nothing(document, kept, tmp_path):
    moved = move(document, [0], (0.1, 0.0))
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(MapError, match="cannot be written"):
        kept.save_as(moved, tmp_path / "file" / "map.npz")
    assert kept.path.name == "map.npz"
    assert kept.unsaved(moved)


def test_an_autosave_that_cannot_be_removed_says_so(document, kept):
    kept.autosave_file.mkdir()
    with pytest.raises(MapError, match="cannot be removed"):
        kept.drop_autosave()
    with pytest.raises(MapError, match="cannot be written"):
        kept.autosave(move(document, [0], (0.1, 0.0)))
