"""Leading the arm in the real window: tools and keys in, settings to the session, path and target in both views."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.arrange import move
from tactile_widgets.tools.registry import PATH
from tests.widgets.support.map_view_driver import LEFT, NONE
from tests.widgets.support.robot_view_driver import skin_pixel
from tests.widgets.support.samples import middle_taxel
from tests.widgets.support.window_driver import press_map, replay_run, run


@pytest.fixture
def window(window_again):
    """Window with the initial control settings."""
    return window_again


def pixels(window, patch=0, *, away=((-0.03, 0.0), (0.0, 0.03), (0.03, 0.0))):
    """Map points around the middle of a patch, and their pixels of the map view."""
    points = window.live.prepared.map.boxes[patch].mean(axis=0) + np.array(away)
    return points, [QPoint(*one) for one in window.map_view.map_to_pixels(points).round().astype(int).tolist()]


def click(view, pixel):
    QTest.mouseMove(view, pixel)
    QTest.mouseClick(view, LEFT, NONE, pixel)


def draw(window, *, kind="polyline"):
    """Take the tool by its key, draw through three places of the upper arm's map."""
    window.map_view.setFocus()
    QTest.keyClick(window.map_view, Qt.Key.Key_D)
    assert window.views.tool is PATH
    window.action(f"path_{kind}").trigger()
    points, where = pixels(window)
    for pixel in where:
        click(window.map_view.viewport(), pixel)
    QTest.keyClick(window.map_view, Qt.Key.Key_Return)
    return points


def settings(window):
    run(window, 0.02)
    return window.live.runner.session.settings


@pytest.mark.long
def test_path_drawn_on_the_map_is_followed(window):
    points = draw(window)
    led = settings(window)
    assert (led.controller, led.task, led.path_kind) == ("hybrid", "follow_path", "polyline")
    np.testing.assert_allclose(led.path, points, atol=3e-3)
    assert window.column["controller"].settings == led
    shown = window.map_view._task
    assert shown is window.robot_view.display._task
    np.testing.assert_allclose(shown.path.lines[0].on_map[0], led.path[0], atol=1e-5)
    window.robot_view.display.draw_now()
    ribbons = window.robot_view.display.actors._task_marks._kinds["path"]
    assert [bool(ribbon.actor.visibility) for ribbon in ribbons] == [True, False, False]


@pytest.mark.long
def test_path_without_a_fixed_object_offers_another_scene_once(window, monkeypatch):
    opened = []
    monkeypatch.setattr(window.presenters.files, "open_scene", lambda scene: opened.append(scene.name))
    draw(window)
    assert "a fixed knob" in window.notification_bar.text
    window.action("open_path_scene").trigger()
    assert opened == ["follow_path"]
    window.notification_bar.clear()
    window.action("path_spline").trigger()
    assert not window.notification_bar.text


def test_target_on_the_body_is_the_same_on_the_map(window, prepared):
    window.action("set_target").trigger()
    view = window.robot_view
    pixel = skin_pixel(window.robot_view, prepared)
    at = view.point_at(pixel.toPointF())
    click(view.display.canvas.widget, pixel)
    led = settings(window)
    assert (led.controller, led.task) == ("hybrid", "hold_point")
    np.testing.assert_allclose(led.path, [prepared.map.to_map(at)], atol=1e-9)
    assert window.map_view._task.target.patch == at.patch


def test_path_is_drawn_on_the_body(window, prepared):
    window.action("draw_path").trigger()
    window.action("path_polyline").trigger()
    view = window.robot_view
    pixel = skin_pixel(window.robot_view, prepared)
    view.setFocus()
    places = [pixel, pixel + QPoint(12, 0), pixel + QPoint(12, 12)]
    ats = [view.point_at(place.toPointF()) for place in places]
    assert all(at is not None for at in ats)
    for place in places:
        click(view.display.canvas.widget, place)
    assert len(view.display._marks.spots) == 3
    assert view.display._marks.strokes
    QTest.keyClick(view, Qt.Key.Key_Return)
    np.testing.assert_allclose(settings(window).path, [prepared.map.to_map(at) for at in ats], atol=1e-9)


def test_backspace_removes_a_corner_without_a_reset(window):
    run(window, 0.2)
    window.map_view.setFocus()
    window.action("draw_path").trigger()
    window.action("path_polyline").trigger()
    _, where = pixels(window)
    for pixel in where[:2]:
        click(window.map_view.viewport(), pixel)
    QTest.keyClick(window.map_view, Qt.Key.Key_Backspace)
    assert window.live.runner.session.frame.time > 0.1
    QTest.keyClick(window.map_view, Qt.Key.Key_Backspace)
    assert window.action("undo").iconText() == "Undo choose the path's shape"
    QTest.keyClick(window.map_view, Qt.Key.Key_Backspace)  # nothing is drawn: it is the window's again
    assert window.live.runner.session.frame.time < 0.1


def shift(window, name, metres):
    assert window.editor.do(name, lambda document: move(document, [2], (metres, 0.0)))


def test_undo_reverts_edits_in_their_order_whatever_tool_is_active(window):
    undo = window.action("undo")
    redo = window.action("redo")
    shift(window, "Move", 0.01)
    draw(window)
    shift(window, "Move again", 0.02)
    turned = window.live.prepared.robot.home + 0.05
    window.presenters.posture.editor.do("turn", turned)
    window.action("poke").trigger()
    assert undo.iconText() == "Undo turn"
    undo.trigger()
    assert np.allclose(window.presenters.posture.editor.target, window.live.prepared.robot.home)
    assert undo.iconText() == "Undo move again"
    undo.trigger()
    assert window.editor.history.position == 1
    assert undo.iconText() == "Undo draw a path"
    QTest.keyClick(window.map_view, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert settings(window).path == ()
    assert window.statusBar().currentMessage() == "Undone: draw a path"
    assert undo.iconText() == "Undo choose the path's shape"
    undo.trigger()
    assert undo.iconText() == "Undo move"
    undo.trigger()
    assert window.editor.history.position == 0
    assert not undo.isEnabled()
    for name in ("move", "choose the path's shape", "draw a path", "move again", "turn"):
        assert redo.iconText() == f"Redo {name}"
        redo.trigger()
    assert not redo.isEnabled()
    assert window.editor.history.position == 2
    assert len(settings(window).path) == 3
    assert np.allclose(window.presenters.posture.editor.target, turned)


def test_new_edit_makes_undone_edits_of_other_tools_impossible_to_redo(window):
    undo = window.action("undo")
    redo = window.action("redo")
    draw(window)
    undo.trigger()
    assert redo.isEnabled()
    shift(window, "Move", 0.01)
    assert not redo.isEnabled()
    undo.trigger()
    assert redo.iconText() == "Redo move"
    redo.trigger()
    assert settings(window).path == ()


def test_path_that_was_drawn_before_a_replay_can_be_undone(window, tmp_path):
    draw(window)
    replay_run(window, tmp_path / "a.mcap", 0.1)
    assert not window.action("undo").isEnabled()
    window.live.replay.leave()
    assert window.action("undo").iconText() == "Undo draw a path"
    window.action("undo").trigger()
    assert settings(window).path == ()


def test_undo_does_not_restore_the_path_of_a_previous_session(window):
    draw(window)
    prepared = window.live.prepared
    window.live.show_prepared(prepared)
    assert window.views.tool is PATH
    assert settings(window).path == ()
    assert window.live.prepared.skin is prepared.skin
    assert window.presenters.control_tools.settings_editor.steps.undo_step.name == ""
    assert "draw a path" not in window.action("undo").iconText()


@pytest.mark.long
def test_undo_while_drawing_removes_the_last_corner(new_window):
    window = new_window
    window.action("draw_path").trigger()
    _, where = pixels(window)
    click(window.map_view.viewport(), where[0])
    assert window.action("undo").isEnabled()
    window.action("undo").trigger()
    assert not window.action("undo").isEnabled()


@pytest.mark.long
def test_undo_of_a_path_keeps_the_gains(window):
    draw(window)
    window.live.set_settings(replace(settings(window), force_gain=0.03))
    window.action("undo").trigger()
    led = settings(window)
    assert led.path == ()
    assert led.force_gain == 0.03


@pytest.mark.long
def test_menu_clears_the_path_and_changes_the_force(window):
    assert not window.action("clear_path").isEnabled()
    draw(window)
    window.action("more_force").trigger()
    assert settings(window).force_goal == 3.5
    window.action("less_force").trigger()
    assert settings(window).force_goal == 3.0
    window.action("clear_path").trigger()
    led = settings(window)
    assert led.path == ()
    assert led.controller == "hybrid"
    assert not window.action("clear_path").isEnabled()


@pytest.mark.long
def test_path_shape_of_the_menu_is_shown_in_the_panel(window):
    window.action("path_raster").trigger()
    assert settings(window).path_kind == "raster"
    assert settings(window).controller == "impedance"
    window.live.set_settings(replace(settings(window), path_kind="spline"))
    assert window.action("path_spline").isChecked()


@pytest.mark.long
def test_press_with_the_path_tool_does_not_poke(window):
    draw(window)
    run(window, 0.1)
    assert not window.live.touches()


def test_target_and_force_are_shown_while_paused(window):
    window.live.set_paused(paused=True)
    window.action("set_target").trigger()
    points, (pixel, *_) = pixels(window)
    click(window.map_view.viewport(), pixel)
    task = window.map_view._task
    np.testing.assert_allclose(window.live.prepared.map.to_map(task.target), points[0], atol=3e-3)


@pytest.mark.long
def test_desired_and_actual_path_are_shown_in_session_and_replay(window, tmp_path):
    taxel = middle_taxel(window.live.prepared.map, 0)
    window.live.set_settings(replace(settings(window), controller="hybrid", task="follow_path", path_speed=0.03))
    window.live.recording.start(tmp_path / "led.mcap")
    pixel = press_map(window, taxel)
    run(window, 1.6)
    live = window.map_view._task
    assert live.path
    assert live.target is not None
    assert live.goal == 3.0
    words = [mark.text for mark in window.map_view.marks.contacts]
    assert any("of 3.0\u202fN" in text for text in words)
    QTest.mouseRelease(window.map_view.viewport(), LEFT, NONE, pixel)
    window.live.recording.stop()
    window.live.open_recording(tmp_path / "led.mcap")
    assert not window.action("draw_path").isEnabled()
    for second in np.arange(0.1, 1.6, 0.1):
        window.live.replay.seek(second)
    replayed = window.map_view._task
    np.testing.assert_allclose(replayed.path.lines[0].on_map, live.path.lines[0].on_map, atol=1e-9)
    assert replayed.target is not None
    assert replayed.goal == 3.0
    window.live.replay.leave()
    QApplication.processEvents()
    assert window.action("draw_path").isEnabled()


@pytest.mark.parametrize("name", ["draw_path", "set_target"])
def test_tools_are_disabled_without_an_arm(qtbot, window, name):
    assert window.action(name).isEnabled()
    window.presenters.tools.control.set_enabled(enabled=False)
    assert not window.action(name).isEnabled()
