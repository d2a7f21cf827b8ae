"""Target posture: each gesture is an undo step, joint limits hold, and a new session clears it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.session.session import Session
from tactile_widgets.document.posture_editor import PostureEditor
from tests.support.touch import prepared_bar


@pytest.fixture
def editor():
    made = PostureEditor()
    made.show_prepared(prepared_bar())
    made.set_mode(enabled=True, placing=False)
    made.heard = {"requested": [], "previewed": []}
    made.requested.connect(lambda posture: made.heard["requested"].append(posture.tolist()))
    made.previewed.connect(
        lambda posture: made.heard["previewed"].append(None if posture is None else posture.tolist())
    )
    return made


def lead(editor, *values):
    editor.begin("lead")
    for value in values:
        editor.change(np.array([value]))
    editor.end()


def test_running_session_receives_each_move_as_one_undo_step(editor):
    lead(editor, 0.1, 0.2)
    assert editor.heard == {"requested": [[0.1], [0.2]], "previewed": []}
    editor.undo()
    assert editor.target.tolist() == [0.0]
    assert editor.heard["requested"][-1] == [0.0]
    editor.redo()
    assert editor.target.tolist() == [0.2]
    assert not editor.can_redo


def test_paused_session_previews_moves_and_receives_the_last(editor):
    editor.set_mode(enabled=True, placing=True)
    lead(editor, 0.1, 0.2)
    assert editor.heard == {"requested": [[0.2]], "previewed": [[0.1], [0.2]]}


def test_rejected_target_leaves_the_steps_and_the_target_before_it(editor):
    editor.set_mode(enabled=True, placing=True)
    lead(editor, 0.1)
    editor.do("lead", np.array([0.2]), continues=True)
    editor.requested.connect(lambda _posture: editor.reject())
    messages = []
    editor.notified.connect(messages.append)
    editor.do("lead", np.array([0.3]), continues=True)
    assert editor.target.tolist() == [0.2]
    assert editor.heard["previewed"][-1] is None
    editor.undo()
    assert editor.target.tolist() == [0.2]
    assert (editor.can_undo, editor.can_redo) == (True, False)
    editor.requested.disconnect()
    editor.undo()
    assert editor.target.tolist() == [0.0]
    assert messages == ["Undone: lead"]
    editor.requested.connect(lambda _posture: editor.reject())
    editor.redo()
    assert editor.target.tolist() == [0.0]
    assert (editor.can_undo, editor.redo_step.name) == (False, "lead")
    assert messages == ["Undone: lead"]


def test_cancelled_posture_gesture_leaves_no_step(editor):
    editor.begin("lead")
    editor.change(np.array([0.3]))
    assert editor.cancel()
    assert editor.target.tolist() == [0.0]
    assert editor.heard["requested"] == [[0.3], [0.0]]
    assert not editor.can_undo


def test_limits_apply_and_a_disabled_robot_receives_no_target(editor):
    lead(editor, 99.0)
    assert editor.target.tolist() == [1.5]
    editor.set_mode(enabled=False, placing=False)
    editor.do("lead", np.array([0.1]))
    assert editor.target.tolist() == [1.5]
    assert not editor.can_undo


def test_reset_session_clears_the_target_and_is_reported(editor):
    lead(editor, 0.1)
    frame = Session(prepared_bar()).frame
    editor.show_frame(replace(frame, tick=9))
    changes = []
    editor.changed.connect(lambda: changes.append(editor.target.tolist()))
    editor.show_frame(replace(frame, tick=10))
    assert editor.can_undo
    editor.show_frame(replace(frame, tick=0))
    assert not editor.can_undo
    assert changes == [[0.0]]
