"""Autosaves that a crash left: found with what belongs to them, claimed by one process, kept until a decision."""

from __future__ import annotations

import os

import pytest

from tactile_maps.core.files import claim_folder
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import AUTOSAVE_NAME, DocumentFile, document_to_bytes
from tactile_maps.editing.leftovers import find_leftovers
from tactile_maps.studies.testbeds.reference_bodies import flat_map


@pytest.fixture
def document():
    return MapDocument.of(flat_map(30))


def autosaved(parent, document, *, path=None, scene=""):
    """Autosave a document as a window does that then ends without closing; its folder."""
    claim = claim_folder(parent, without=AUTOSAVE_NAME)
    DocumentFile(path, None, folder=claim.folder).autosave(document, scene=scene)
    claim.release()
    return claim.folder


def test_missing_autosave_folder_gives_no_leftovers(tmp_path):
    assert find_leftovers(tmp_path / "none") == []


def test_autosave_is_found_with_its_map_file_and_scene(document, tmp_path):
    path = tmp_path / "own.npz"
    path.write_bytes(b"older")
    os.utime(path, (1.0, 1.0))
    autosaved(tmp_path, document, path=path, scene='robot = "arm"')
    (found,) = find_leftovers(tmp_path)
    assert (found.file, found.scene, found.newer_than_file) == (path, 'robot = "arm"', True)
    assert document_to_bytes(found.document) == document_to_bytes(document)
    path.unlink()
    assert not found.newer_than_file
    found.release()


def test_leftover_autosave_is_locked_by_one_process_until_released(document, tmp_path):
    autosaved(tmp_path, document)
    (found,) = find_leftovers(tmp_path)
    assert find_leftovers(tmp_path) == []
    found.release()
    (again,) = find_leftovers(tmp_path)
    again.discard()
    assert find_leftovers(tmp_path) == []


def test_new_autosave_uses_another_folder_and_leftovers_are_newest_first(document, tmp_path):
    first = autosaved(tmp_path, document)
    os.utime(first / AUTOSAVE_NAME, (1.0, 1.0))
    second = autosaved(tmp_path, move(document, [0], (0.1, 0.0)))
    assert first != second
    found = find_leftovers(tmp_path)
    assert [one.claim.folder for one in found] == [second, first]
    for one in found:
        one.release()


def test_damaged_autosave_is_not_deleted(document, tmp_path):
    folder = autosaved(tmp_path, document)
    (folder / AUTOSAVE_NAME).write_bytes(b"damaged")
    assert find_leftovers(tmp_path) == []
    assert (folder / AUTOSAVE_NAME).read_bytes() == b"damaged"
