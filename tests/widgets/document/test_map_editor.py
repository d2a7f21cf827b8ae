"""The editor: gestures, computed edits and history, on a real map and with edits computed at once or held back."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument, rename_patch
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.editing.seams import propose_seam
from tactile_widgets.document.map_editor import MapEditor
from tests.widgets.support.executors import HeldJobs


@pytest.fixture
def worker():
    return HeldJobs()


@pytest.fixture
def editor(worker, prepared):
    """Map editor with the small arm's map, enabled."""
    made = MapEditor(worker)
    made.open(MapDocument.of(prepared.map))
    made.set_enabled(enabled=True)
    made.heard = []
    for name in ("failed", "notified"):
        getattr(made, name).connect(lambda text, name=name: made.heard.append((name, text)))
    made.settled.connect(lambda _document, name: made.heard.append(("settled", name)))
    return made


def shift(document):
    return move(document, [0], (0.01, 0.0))


def test_edit_is_one_step_and_is_reported(editor):
    first = editor.document
    assert editor.do("Move", shift)
    assert editor.heard == [("settled", "Move")]
    assert editor.history.names == ("Open", "Move")
    editor.undo()
    assert editor.document is first
    assert editor.heard[-1] == ("settled", "Undo: Move")
    editor.redo()
    assert editor.heard[-1] == ("settled", "Redo: Move")


def test_edit_without_a_change_is_not_a_step(editor):
    assert editor.do("Nothing", lambda document: document)
    assert editor.history.names == ("Open",)
    assert editor.heard == []


def test_rejected_edit_reports_the_reason_without_changes(editor):
    first = editor.document
    assert not editor.do("Rename", lambda document: rename_patch(document, 0, ""))
    assert editor.document is first
    assert editor.heard[0][0] == "failed"
    assert not editor.gesture


def test_gesture_changes_its_start_document_and_settles_once(editor):
    shown = []
    editor.shown.connect(shown.append)
    editor.begin("Rotate")
    for angle in (0.1, 0.2, 0.3):
        editor.change(lambda document, angle=angle: rotate(document, [1], angle))
    assert editor.heard == []
    editor.end()
    assert editor.heard == [("settled", "Rotate")]
    assert len(shown) == 4
    assert editor.document.layout.placements[1].angle == pytest.approx(
        shown[0].layout.placements[1].angle + 0.2, abs=1e-12
    )


def test_cancelled_gesture_leaves_no_step(editor):
    first = editor.document
    editor.begin("Move")
    editor.change(shift)
    editor.cancel()
    assert editor.document is first
    assert editor.history.names == ("Open",)
    assert editor.heard == []


def test_undo_during_a_gesture_only_cancels_the_gesture(editor):
    editor.do("Move", shift)
    kept = editor.document
    editor.begin("Rotate")
    editor.change(lambda document: rotate(document, [1], 1.0))
    editor.undo()
    assert editor.document is kept


def test_computed_edit_is_one_step(editor, worker):
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    assert editor.busy
    worker.release()
    assert not editor.busy
    assert editor.history.names == ("Open", "Method")
    assert editor.document.charts[0].method == "lscm"


def test_undo_during_a_computation_cancels_it(editor, worker):
    editor.do("Move", shift)
    kept = editor.document
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    editor.undo()
    assert not editor.busy
    assert editor.document is kept
    assert ("notified", "Method: cancelled") in editor.heard


def test_result_for_a_patch_changed_meanwhile_is_reported_and_not_applied(editor, worker):
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    (request,) = worker.held
    editor.do("Move", shift)  # another place does not count
    worker.release()
    assert editor.document.charts[0].method == "lscm"
    kept = editor.document
    editor._pending = None
    editor.ask(lambda document: set_method(document, [0], "arap"))
    worker.executor._waiting[0].job.arguments = (request,)  # as if it had been requested before
    worker.release()
    assert editor.document is kept
    assert any(kind == "notified" and "changed meanwhile" in text for kind, text in editor.heard)


def test_result_during_a_gesture_waits_for_its_end(editor, worker):
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    editor.begin("Rotate")
    editor.change(lambda document: rotate(document, [1], 0.5))
    worker.release()
    assert editor.gesture
    assert editor.history.names == ("Open",)
    editor.end()
    assert editor.history.names == ("Open", "Rotate", "Method")
    assert editor.document.charts[0].method == "lscm"


def test_refinement_replaces_its_step(editor, worker):
    editor.do("Move", shift)
    editor.ask(lambda document: set_method(document, [0], "lscm"), refine=True)
    worker.release()
    assert editor.history.names == ("Open", "Move")
    assert editor.document.charts[0].method == "lscm"


@pytest.mark.long
def test_proposal_waits_and_is_accepted_unchanged(editor, worker):
    first = editor.document
    changed = []
    editor.proposal_changed.connect(lambda: changed.append(editor.proposal))
    editor.ask(lambda document: propose_seam(document, 0), propose=True)
    worker.release()
    assert editor.document is first
    assert 0 < editor.proposal.gain < 1
    shown = editor.proposal.result.charts[0]
    editor.accept()
    assert editor.proposal is None
    assert [proposal is None for proposal in changed] == [False, True]
    assert np.array_equal(editor.document.charts[0].plane, shown.plane)
    assert editor.history.names[-1] == "Accept a seam"


@pytest.mark.long
def test_undo_declines_a_proposal(editor, worker):
    first = editor.document
    editor.ask(lambda document: propose_seam(document, 0), propose=True)
    worker.release()
    editor.undo()
    assert editor.proposal is None
    assert editor.document is first


def test_invalid_request_is_reported_and_not_computed(editor):
    editor.ask(lambda document: set_lengths(document, [0], 7.0))
    assert not editor.busy
    assert editor.heard[0][0] == "failed"


def test_edits_are_disabled_during_a_replay(editor):
    first = editor.document
    editor.begin("Move")
    editor.change(shift)
    editor.set_enabled(enabled=False)
    assert editor.document is first
    assert not editor.do("Move", shift)
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    assert not editor.busy


@pytest.mark.long
@pytest.mark.parametrize("propose", [False, True])
def test_result_during_a_replay_waits_until_edits_are_enabled(editor, worker, propose):
    shown = []
    edit = propose_seam if propose else (lambda document, number: set_method(document, [number], "lscm"))
    editor.ask(lambda document: edit(document, 0), propose=propose)
    editor.set_enabled(enabled=False)
    for signal in (editor.shown, editor.proposal_changed):
        signal.connect(lambda *arguments: shown.append(arguments))
    worker.release()
    assert not editor.busy
    assert shown == []
    assert editor.heard == []
    editor.set_enabled(enabled=True)
    assert len(shown) == 1
    assert editor.history.names == (("Open",) if propose else ("Open", "Method"))


def test_waiting_result_is_not_applied_to_another_document(editor, worker, prepared):
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    editor.set_enabled(enabled=False)
    worker.release()
    editor.open(MapDocument.of(prepared.map))
    editor.set_enabled(enabled=True)
    assert editor.history.names == ("Open",)


def test_opening_another_document_resets_everything(editor, worker, prepared):
    editor.select([0, 1])
    editor.do("Move", shift)
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    editor.open(MapDocument.of(prepared.map))
    assert editor.history.names == ("Open",)
    assert editor.selected == ()
    assert not editor.busy


def test_patches_that_do_not_exist_are_not_selected(editor):
    editor.select([2, 0, 0, 99, -1])
    assert editor.selected == (0, 2)


def test_result_for_a_previous_document_is_dropped(editor, worker):
    first = editor.document
    editor.ask(lambda document: set_method(document, [0], "lscm"))
    editor.open(MapDocument.of(first.map))
    editor.ask(lambda document: set_method(document, [1], "lscm"))
    worker.release()
    assert not editor.busy
    assert editor.history.position == 1
    assert editor.document.charts[0] is first.charts[0]
    assert editor.document.charts[1].method == "lscm"
