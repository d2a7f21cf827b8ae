"""Documents out and back, hostile files refused, and an autosave that outlives a crash."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.core.files import pack_arrays, unpack_arrays
from tactile_maps.editing.arrange import mirror, move, rotate, scale
from tactile_maps.editing.document import MapDocument, rename_patch, reorder_patch, show_patches
from tactile_maps.editing.document_file import (
    DocumentFile,
    document_from_bytes,
    document_to_bytes,
    load_document,
    save_document,
)
from tactile_maps.editing.history import History
from tactile_maps.editing.pins import add_pin
from tactile_maps.editing.reflatten import apply_result, chart_fingerprint, reflatten, set_lengths
from tactile_maps.editing.seams import draw_seam, paint_interest
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.formats.map_file import map_to_bytes, save_map


@pytest.fixture(scope="module")
def edited(document):
    """Everything that can be edited, edited."""
    new = scale(mirror(rotate(document, [0], 0.3), [2]), [1], 1.7)
    for edit in (
        lambda d: draw_seam(d, 1, [28, 31]),
        lambda d: paint_interest(d, 1, [1, 2, 3]),
        lambda d: set_lengths(d, [2], 0.3),
    ):
        new = apply_result(new, reflatten(edit(new)))
    new = add_pin(new, SurfacePoint(1, 4, (0.2, 0.3, 0.5)))
    return reorder_patch(show_patches(rename_patch(new, 0, "Ünterarm ✋"), [2], visible=False), 0, 2)


def _changed(document, *, header=None, patch=None, **arrays):
    """The document's bytes with parts replaced; None removes an array. Array names start with an underscore."""
    old_header, old = unpack_arrays(document_to_bytes(document), error=MapError)
    merged = old | {key.removeprefix("_"): value for key, value in arrays.items()}
    old_header["patches"][1] |= patch or {}
    return pack_arrays(old_header | (header or {}), {k: v for k, v in merged.items() if v is not None})


def test_saved_data_are_restored(edited, tmp_path):
    save_document(edited, tmp_path / "map.npz")
    back = load_document(tmp_path / "map.npz")
    assert document_to_bytes(back) == document_to_bytes(edited)
    assert [chart_fingerprint(back, k) for k in range(3)] == [chart_fingerprint(edited, k) for k in range(3)]
    assert (back.order, back.layout) == (edited.order, edited.layout)
    for mine, theirs in zip(back.patches, edited.patches, strict=True):
        assert mine.pins == theirs.pins
        assert (mine.name, mine.method, mine.lengths, mine.visible) == (
            theirs.name,
            theirs.method,
            theirs.lengths,
            theirs.visible,
        )
        np.testing.assert_array_equal(mine.seams.drawn, theirs.seams.drawn)
    np.testing.assert_array_equal(back.patches[1].seams.importance, edited.patches[1].seams.importance)
    np.testing.assert_array_equal(back.map.taxel_points, edited.map.taxel_points)
    assert [path.name for path in tmp_path.iterdir()] == ["map.npz"], "no half-written file is left"


def test_plain_map_opens_as_a_new_document(document, tmp_path):
    save_map(document.map, tmp_path / "map.npz")
    opened = load_document(tmp_path / "map.npz")
    assert document_to_bytes(opened) == document_to_bytes(document)


def test_imported_chart_is_saved_and_restored(document):
    charts = tuple(replace(chart, method="by hand") for chart in document.charts)
    other = MapDocument.of(replace(document.map, charts=charts))
    assert document_from_bytes(document_to_bytes(other)).patches[0].method == "by hand"


@pytest.mark.parametrize(
    ("header", "says"),
    [
        ({"format": "tactile-maps-skin"}, "not a map"),
        ({"version": 99}, "unknown version"),
        ({"order": [0, 1]}, "patch tree is broken"),
        ({"order": [0, 1, "2"]}, "patch tree is broken"),
        ({"order": None}, "patch tree is broken"),
        ({"patches": []}, "list of patches"),
        ({"patches": 3}, "list of patches"),
        ({"patches": [1, 2, 3]}, "patch 0, name"),
    ],
)
def test_broken_header_is_rejected(edited, header, says):
    with pytest.raises(MapError, match=says):
        document_from_bytes(_changed(edited, header=header), file="x.npz")


@pytest.mark.sampled(7)
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("name", 3),
        ("method", None),
        ("lengths", 1.5),
        ("lengths", float("nan")),
        ("lengths", 1),
        ("visible", 1),
        ("extra", -1),
        ("extra", 1.0),
        ("extra", 10**9),
        ("extra", True),
        ("pins", None),
        ("pins", [[1]]),
        ("pins", [[10**6, 1.0, 0.0, 0.0, 0.0, 0.0]]),
        ("pins", [[0, 1.0, 1.0, 0.0, 0.0, 0.0]]),
        ("pins", [[0, 2.0, -1.0, 0.0, 0.0, 0.0]]),
        ("pins", [[0, 1.0, 0.0, 0.0, float("inf"), 0.0]]),
        ("pins", [[True, 1.0, 0.0, 0.0, 0.0, 0.0]]),
    ],
)
def test_broken_patch_is_rejected_by_name(edited, key, value):
    with pytest.raises(MapError, match=f"x.npz, patch patch 1, {key}"):
        document_from_bytes(_changed(edited, patch={key: value}), file="x.npz")


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("drawn", None),
        ("drawn", np.zeros((2, 3), int)),
        ("drawn", np.zeros((2, 2))),
        ("drawn", np.array(3)),
        ("drawn", np.array([[0, 60]])),
        ("drawn", np.array([[-1, 0]])),
        ("drawn", np.array([[2**63, 1]], np.uint64)),
        ("importance", np.ones(3)),
        ("importance", np.ones(63, int)),
        ("importance", np.full(63, np.nan)),
        ("importance", -np.ones(63)),
    ],
)
def test_broken_array_is_rejected_by_name(edited, name, values):
    assert len(edited.skin.patches[1].surface.vertices) == 63
    with pytest.raises(MapError, match=f"x.npz, patch patch 1, {name}"):
        document_from_bytes(_changed(edited, **{f"_1_{name}": values}), file="x.npz")


def test_document_without_a_map_is_rejected(edited):
    for values in (None, np.zeros(3)):
        with pytest.raises(MapError, match="no map"):
            document_from_bytes(_changed(edited, _map=values))
    with pytest.raises(MapError):
        document_from_bytes(_changed(edited, _map=np.zeros(30, np.uint8)))
    for data in (b"", b"PK nonsense", map_to_bytes(edited.map)[:-40]):
        with pytest.raises(MapError, match="damaged"):
            document_from_bytes(data)


def test_unreadable_and_unwritable_files_are_errors(edited, tmp_path):
    with pytest.raises(MapError, match="cannot be read"):
        load_document(tmp_path / "nothing.npz")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(MapError, match="cannot be written"):
        save_document(edited, tmp_path / "file" / "map.npz")


def test_implausibly_large_file_is_not_read(tmp_path):
    with (tmp_path / "huge.npz").open("wb") as file:
        file.truncate(2**31)
    with pytest.raises(MapError, match="too large"):
        load_document(tmp_path / "huge.npz")


@pytest.fixture
def kept(document, tmp_path):
    """A saved document's file."""
    file = DocumentFile(None, None)
    file.save_as(document, tmp_path / "map.npz")
    return file


def test_document_undone_to_its_saved_state_has_no_unsaved_changes(document, kept):
    history = History(document)
    assert not kept.unsaved(history.present)
    history.do("Move", move(document, [0], (0.1, 0.0)))
    assert kept.unsaved(history.present)
    kept.save_as(history.present, kept.path)
    assert not kept.unsaved(history.present)
    assert kept.unsaved(history.undo())
    assert not kept.unsaved(history.redo())


def test_new_document_has_no_file_yet(document):
    file = DocumentFile(None, None)
    assert file.unsaved(document)
    assert not file.autosave(document)


def test_opened_document_is_saved(document, kept):
    opened = load_document(kept.path)
    assert not DocumentFile(kept.path, opened).unsaved(opened)
    assert document_to_bytes(opened) == document_to_bytes(document)


def test_only_changed_documents_are_autosaved(document, kept):
    moved = move(document, [0], (0.1, 0.0))
    assert not kept.autosave(document)
    assert kept.autosave(moved)
    assert not kept.autosave(moved)
    assert kept.autosave(move(moved, [0], (0.1, 0.0)))
    assert not kept.autosave(document), "undone to what is saved there is nothing to recover"
    assert not kept.autosave_file.exists()


def test_document_without_a_file_is_autosaved_in_a_folder(document, tmp_path):
    file = DocumentFile(None, None, folder=tmp_path)
    assert file.autosave(document)
    assert document_to_bytes(load_document(file.autosave_file)) == document_to_bytes(document)
    file.save_as(document, tmp_path / "named.npz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["named.npz"]


def test_saving_under_another_name_keeps_the_old_file_and_uses_the_new_one(document, kept, tmp_path):
    moved = move(document, [0], (0.1, 0.0))
    old = kept.path
    kept.autosave(moved)
    kept.save_as(moved, tmp_path / "other.npz")
    assert kept.path.name == "other.npz"
    assert not kept.unsaved(moved)
    assert document_to_bytes(load_document(old)) == document_to_bytes(document)
    assert not list(tmp_path.glob("*.autosave"))


def test_failed_save_changes_neither_file_nor_document(document, kept, tmp_path):
    moved = move(document, [0], (0.1, 0.0))
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(MapError, match="cannot be written"):
        kept.save_as(moved, tmp_path / "file" / "map.npz")
    assert kept.path.name == "map.npz"
    assert kept.unsaved(moved)


def test_autosave_that_cannot_be_removed_is_an_error(document, kept):
    kept.autosave_file.mkdir()
    with pytest.raises(MapError, match="cannot be removed"):
        kept.drop_autosave()
    with pytest.raises(MapError, match="there is a folder of this name"):
        kept.autosave(move(document, [0], (0.1, 0.0)))
