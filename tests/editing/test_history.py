"""Undo and redo: the documents themselves come back, a gesture is one step, and memory has a bound."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import rename_patch
from tactile_maps.editing.history import History


def _steps(document, count):
    documents = [document]
    for _ in range(count):
        documents.append(move(documents[-1], [1], (0.01, 0.0)))
    return documents


@pytest.fixture
def history(document):
    return History(document)


def _done(history, count=5):
    documents = _steps(history.present, count)
    for k, later in enumerate(documents[1:]):
        history.do(f"Move {k}", later)
    return documents


def test_undoing_all_steps_returns_the_first_document_and_redoing_all_the_last(history):
    documents = _done(history)
    assert not history.can_redo
    for expected in documents[-2::-1]:
        assert history.undo() is expected
    assert not history.can_undo
    assert history.undo() is documents[0]
    for expected in documents[1:]:
        assert history.redo() is expected
    assert history.redo() is documents[-1]


def test_history_list_contains_all_steps_and_reaches_each(history):
    documents = _done(history)
    assert history.names == ("Open", *(f"Move {k}" for k in range(5)))
    assert history.go(2) is documents[2]
    assert history.position == 2
    assert len(history.names) == 6, "what could be redone is listed"
    for position in (-1, 6):
        with pytest.raises(MapError, match="unknown step"):
            history.go(position)


def test_new_edit_discards_undone_steps(history):
    documents = _done(history)
    history.go(2)
    other = rename_patch(history.present, 0, "Other")
    history.do("Rename", other)
    assert history.names == ("Open", "Move 0", "Move 1", "Rename")
    assert history.undo() is documents[2]


def test_unchanged_document_adds_no_step(history):
    history.do("Nothing", history.present)
    assert history.names == ("Open",)


def test_gesture_of_any_length_is_one_step(history):
    first = history.present
    history.begin("Move")
    for later in _steps(first, 150)[1:]:
        history.change(later)
    assert history.present is later
    history.end()
    assert history.names == ("Open", "Move")
    assert history.present is later
    assert history.undo() is first


def test_cancelled_gesture_leaves_no_step(history):
    documents = _done(history, 2)
    history.go(1)
    history.begin("Move")
    history.change(_steps(history.present, 1)[1])
    history.cancel()
    assert history.present is documents[1]
    assert history.redo() is documents[2], "and what could be redone still can"


def test_gesture_without_change_is_not_a_step(history):
    history.begin("Move")
    history.end()
    assert (history.names, history.gesture) == (("Open",), "")


def test_undo_during_a_gesture_only_cancels_the_gesture(history):
    documents = _done(history, 1)
    history.begin("Move")
    history.change(_steps(history.present, 1)[1])
    assert history.can_undo
    assert not history.can_redo
    assert history.undo() is documents[1]
    assert history.gesture == ""


def test_nested_gestures_and_other_edits_during_a_gesture_are_rejected(history):
    with pytest.raises(MapError, match="no edit is in progress"):
        history.change(history.present)
    history.begin("Move")
    for act in (lambda: history.begin("Rotate"), lambda: history.do("Name", history.present)):
        with pytest.raises(MapError, match="edit is in progress"):
            act()
    with pytest.raises(MapError, match="edit is in progress"):
        history.refine(history.present)


def test_end_and_cancel_without_gesture_have_no_effect(history):
    history.end()
    history.cancel()
    assert history.names == ("Open",)


def test_better_version_replaces_its_step(history):
    documents = _done(history, 2)
    better = rename_patch(documents[2], 0, "Better")
    history.refine(better)
    assert history.present is better
    assert history.names == ("Open", "Move 0", "Move 1")
    assert history.undo() is documents[1]
    assert history.redo() is better


def test_oldest_steps_are_forgotten_first(document):
    history = History(document, most_steps=3)
    documents = _done(history, 10)
    assert history.names == ("Move 6", "Move 7", "Move 8", "Move 9")
    assert history.go(0) is documents[7]


def test_memory_of_the_history_is_bounded_and_released(document, reflattened):
    history = History(document)
    small = history._bytes
    history.do("Move", move(document, [0], (0.1, 0.0)))
    step = history._bytes - small
    assert step < 10_000, "a layout shares every array"
    history.do("Method", reflattened)
    chart = reflattened.charts[1]
    new = sum(array.nbytes for array in (chart.faces, chart.plane, chart.vertex_of, chart.seams))
    assert history._bytes == small + 2 * step + new
    history.undo()
    history.do("Move", move(document, [0], (0.2, 0.0)))
    assert history._bytes == small + 2 * step, "what cannot be redone any more is free"
    tight = History(document, most_bytes=small)
    tight.do("Method", reflattened)
    assert tight.present is reflattened, "the present is always kept"
    assert tight.names == ("Method",)


def test_refined_step_keeps_only_the_memory_of_its_refined_version(document, reflattened):
    history = History(document)
    history.do("Method", reflattened)
    held = history._bytes
    better = move(reflattened, [0], (0.1, 0.0))
    history.refine(better)
    assert history._bytes == held, "the same arrays, the same step"
    history.refine(move(document, [0], (0.1, 0.0)))
    assert history._bytes < held, "the other chart is free"
    again = History(document)
    again.do("Move", move(document, [0], (0.2, 0.0)))
    assert history._bytes == again._bytes


def test_steps_other_than_the_current_one_keep_no_cached_values(history):
    documents = _done(history, 2)
    assert documents[2].map.taxel_points is not None
    history.undo()
    assert "taxel_points" not in vars(documents[2].map)
    assert "taxel_points" not in vars(documents[0].map)


def test_history_limit_of_zero_steps_is_rejected(document):
    with pytest.raises(MapError, match="at least one"):
        History(document, most_steps=0)
