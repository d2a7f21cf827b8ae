"""Pressing where nothing can be pressed: a scene without fingers, and a recording that is taken over."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from tactile_maps.editing.arrange import move, rotate
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.dialogs import Button
from tests.widgets.support.mouse import left_release
from tests.widgets.support.window_driver import answer, click_remedy, press_map, replay_run, run


@pytest.fixture
def window(window_again):
    return window_again


def lift(window):
    left_release(window.map_view.viewport())


def test_scene_without_fingers_offers_to_enable_them(window):
    window.presenters.effects.choose("fingers", "off")
    run(window, 0.1)
    press_map(window, 20)
    lift(window)
    run(window, 0.1)
    assert "finger" in window.notification_bar.text
    assert not window.live.runner.session.effects.fingers
    click_remedy(window, "Simulate fingers")
    run(window, 0.1)
    press_map(window, 20)
    run(window, 0.3)
    assert any(poke.id == 1 and poke.force > 0 for poke in window.live.shown.pokes)
    lift(window)


@pytest.mark.long
def test_simulation_continues_from_the_shown_frame_of_a_recording(window, tmp_path, qtbot):
    run(window, 1.0)
    window.live.recording.start(tmp_path / "a.mcap")
    window.column["controller"].choose_controller("hold_force")
    press_map(window, 20)
    run(window, 0.6)
    window.live.recording.stop()
    lift(window)
    window.live.open_recording(tmp_path / "a.mcap")
    window.live.replay.seek(0.4)
    shown = window.live.shown
    press_map(window, 60)
    lift(window)
    assert "recording" in window.notification_bar.text
    click_remedy(window, "Take over from here")
    qtbot.waitUntil(lambda: window.live.mode is Mode.RUNNING)
    session = window.live.runner.session
    assert window.statusBar().currentMessage().startswith("Taken over at 0:00.4"), "the time of the timeline"
    assert session.frame.tick == shown.tick
    assert session.frame.posture.tobytes() == shown.posture.tobytes()
    assert session.frame.pressures.tobytes() == shown.pressures.tobytes()
    assert session.settings.controller == "hold_force"
    assert [poke.id for poke in session.frame.pokes] == [poke.id for poke in shown.pokes]
    run(window, 0.2)
    assert session.frame.tick > shown.tick, "and it continues"


@pytest.fixture
def edited_recording(window, tmp_path):
    """A recording in which the map was edited at 0.2 s, the robot was moved and a path was drawn, replayed at 0.4 s.

    Its layout at that time is returned. The map behind it has another edit, which is not saved.
    """
    live = window.live
    path = tmp_path / "a.mcap"
    live.recording.start(path)
    run(window, 0.1)
    window.editor.do("Move", partial(move, numbers=[0], by=(0.05, 0.0)))
    controller = window.presenters.control_tools.settings_editor
    controller.do("draw", controller="hybrid", path=((0.1, 0.1), (0.2, 0.2)), task="follow_path")
    posture = live.prepared.robot.home + 0.1
    window.presenters.posture.editor.do("lead", posture)
    run(window, 0.5)
    live.recording.stop()
    layout = window.editor.document.layout
    live.reset()
    controller.do("choose", controller="impedance", path=())
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    live.open_recording(path)
    live.replay.seek(0.4)
    return layout


def taken_over(window, qtbot):
    """Take over the recording that is shown, and wait for it."""
    window.action("take_over").trigger()
    answer(window, Button.Discard)
    qtbot.waitUntil(lambda: window.live.mode is Mode.RUNNING)
    return window.live.runner.session


def test_continued_simulation_keeps_recorded_map_posture_and_path(window, edited_recording, qtbot):
    session = taken_over(window, qtbot)
    document = window.editor.document
    assert document.layout == edited_recording
    assert session.map is document.map
    run(window, 0.05)
    assert session.map is document.map, "nothing else was submitted"
    assert window.robot_view.display.prepared.map is document.map
    assert session.settings.controller == "hybrid"
    assert session.settings.path == ((0.1, 0.1), (0.2, 0.2))
    np.testing.assert_allclose(window.presenters.posture.editor.target, session.prepared.robot.home + 0.1)
    assert "not saved" not in window.notification_bar.text, "nothing was left by a crash"


@pytest.mark.long
def test_recorded_edits_are_one_step_that_can_be_undone_and_are_not_saved(window, edited_recording, qtbot):
    session = taken_over(window, qtbot)
    assert window.editor.history.names == ("Open", "Recorded edits")
    assert window.isWindowModified()
    recorded = window.editor.document
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    window.action("undo").trigger()
    assert window.editor.document is recorded
    window.action("undo").trigger()
    run(window, 0.05)
    assert window.editor.document.map is session.prepared.map
    assert session.map is session.prepared.map
    assert window.presenters.map_files.unsaved == ("path", "controller")
    window.action("redo").trigger()
    assert window.presenters.map_files.unsaved == ("map", "path", "controller")
    assert not window.close()
    answer(window, Button.Cancel)


def test_continuing_a_recording_first_asks_about_unsaved_edits(window, edited_recording, qtbot):
    own = window.editor.document
    window.action("take_over").trigger()
    answer(window, Button.Cancel)
    assert window.live.mode is Mode.REPLAYING
    assert window.editor.document is own
    window.live.replay.leave()
    assert window.isWindowModified()
    assert window.presenters.map_files.unsaved


@pytest.mark.long
def test_recording_without_edits_leaves_nothing_to_save(window, tmp_path, qtbot):
    replay_run(window, tmp_path / "a.mcap", 0.3)
    window.live.replay.seek(0.2)
    window.action("take_over").trigger()
    qtbot.waitUntil(lambda: window.live.mode is Mode.RUNNING)
    assert window.editor.history.names == ("Open",)
    assert not window.isWindowModified()
