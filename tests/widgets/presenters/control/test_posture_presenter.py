"""The posture in the real window: sliders, typed values and a dragged link lead the robot, live and paused."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication

from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.inputs import PosturePlaced, RestChanged
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_widgets.common.mode import Mode
from tactile_widgets.panels.control.posture_panel import PosturePanel
from tests.widgets.support.mouse import left_press, left_release
from tests.widgets.support.window_driver import run, visible_skin

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """Window without touch, with the panel unfolded."""
    panel = window_again.column.get(PosturePanel)
    if panel.folded:
        window_again.findChild(QAbstractButton, "posture-panel-heading").click()
    assert len(panel.sliders) == 7
    QApplication.processEvents()
    return window_again


def type_degrees(window, joint, degrees):
    """Type into a joint's number, as a person does."""
    field = window.column.get(PosturePanel).sliders[joint]._value
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, f"{degrees}")
    QTest.keyClick(field, Qt.Key.Key_Return)


def postures(window, kind):
    return [act for _, act in window.live.runner.session.inputs if isinstance(act, kind)]


def end_script(window):
    """A person touches, and the scene's own finger lifts."""
    window.presenters.touch.press(visible_skin(window)[0])
    window.presenters.touch.release()
    run(window, 0.2)


def pause(window):
    window.live.set_paused(paused=True)


def robot_pixel(window, link):
    """A pixel where the robot view shows this link, which no other hides."""
    view = window.robot_view
    number = window.live.prepared.robot.link_index[link]
    for y in range(40, view.height() - 40, 18):
        for x in range(40, view.width() - 40, 18):
            pixel = QPoint(x, y).toPointF()
            body = view._body_along(view.display.actors.viewpoint.ray((x, y), view.display.size))
            if body is not None and body.number == number and not view.over_control(pixel):
                return QPoint(x, y)
    raise AssertionError(f"{link} cannot be seen")


def drag(window, start, by):
    canvas = window.robot_view.display.canvas.widget
    left_press(canvas, start)
    for part in (0.25, 0.5, 0.75, 1.0):
        QTest.mouseMove(canvas, start + QPoint(round(part * by.x()), round(part * by.y())))
    return lambda: left_release(canvas, start + by)


@pytest.mark.long
def test_typed_joint_position_is_reached_and_replays_bit_for_bit(window, tmp_path):
    home = window.live.prepared.robot.home
    target = np.degrees(home[1]) + 8.0
    window.live.recording.start(tmp_path / "led.mcap")
    type_degrees(window, 1, f"{target:.1f}")
    run(window, 0.2)
    moved = window.live.shown.posture[1] - home[1]
    assert 0 < moved < np.radians(7.9), "it goes there, it does not jump"
    run(window, 1.4)
    assert abs(np.degrees(window.live.shown.posture[1]) - target) < 1.0
    window.live.recording.stop()
    assert [act.speed for act in postures(window, RestChanged)] == [0.6]
    assert verify(RecordingPlayer(tmp_path / "led.mcap")).identical


@pytest.mark.long
def test_robot_is_placed_while_paused_and_undo_restores_it(window):
    end_script(window)
    home = window.live.prepared.robot.home
    pose = window.presenters.posture
    pause(window)
    before = window.live.shown
    type_degrees(window, 2, f"{np.degrees(home[2]) + 20:.1f}")
    assert np.degrees(window.live.shown.posture[2] - home[2]) == pytest.approx(20, abs=0.2)
    assert window.live.shown.tick == before.tick + 1
    assert len(postures(window, PosturePlaced)) == 1
    window.action("undo_posture").trigger()
    assert np.abs(window.live.shown.posture - home).max() < 2e-3
    assert pose.editor.can_redo


@pytest.mark.long
def test_placing_next_to_a_finger_offers_to_move_instead(window):
    at, _ = visible_skin(window)
    window.live.submit(PokePressed(2, at, Finger(max_force=2.0)))
    run(window, 0.2)
    home = window.live.prepared.robot.home
    pause(window)
    shown = window.live.shown
    type_degrees(window, 1, f"{np.degrees(home[1]) + 5:.1f}")
    assert window.live.shown is shown
    assert "cannot be placed while a finger presses it" in window.notification_bar.text
    assert np.allclose(window.presenters.posture.editor.target, home), "a rejected target is withdrawn"
    window.action("go_there").trigger()
    run(window, 1.0)
    assert window.live.mode is Mode.RUNNING
    assert np.degrees(window.live.shown.posture[1] - home[1]) > 2.0


def run_until_the_finger(window, *, presses):
    """Run until the finger of the scene's script presses the robot, or no longer does; then pause."""
    window.live.set_paused(paused=False)
    for _ in range(200):
        if bool(window.live.shown.pokes) == presses:
            break
        run(window, 0.05)
    else:
        raise AssertionError("the finger of the scene does not move")
    pause(window)


def offered(window):
    """Edits that the actions revert and repeat; empty for a grey action."""
    return tuple(action.isEnabled() and action.iconText() for action in (window.action("undo"), window.action("redo")))


@pytest.mark.long
def test_undo_and_redo_that_a_finger_prevents_leave_the_steps(window):
    """The finger of the scene's script presses the robot of a paused scene, which cannot be placed then."""
    editor = window.presenters.posture.editor
    home = editor.target
    status = window.statusBar()
    for name in ("nod", "turn"):
        editor.do(name, editor.target + 0.01)
    moved = editor.target

    def try_to(action, expected, target):
        run_until_the_finger(window, presses=True)
        status.clearMessage()
        window.notification_bar.clear()
        window.action(action).trigger()
        assert offered(window) == expected
        assert np.array_equal(editor.target, target)
        assert "cannot be placed while a finger presses it" in window.notification_bar.text
        assert not status.currentMessage()

    try_to("undo", ("Undo turn", False), moved)
    run_until_the_finger(window, presses=False)
    for name in ("turn", "nod"):
        window.action("undo").trigger()
        assert status.currentMessage() == f"Undone: {name}"
    try_to("redo", (False, "Redo nod"), home)


@pytest.mark.long
def test_dragged_link_moves_the_robot_and_escape_cancels(window):
    window.action("posture").trigger()
    robot = window.live.prepared.robot
    start = robot_pixel(window, "hand")
    release = drag(window, start, QPoint(30, -24))
    target = window.presenters.posture.editor.target
    assert np.abs(target - robot.home).max() > 0.02
    release()
    configuration = Configuration(robot)
    places = []
    for posture in (robot.home, target):
        configuration.update(posture)
        places.append(configuration.pose("hand").translation.copy())
    right, up, _ = window.robot_view.display.actors.viewpoint.axes
    step = places[1] - places[0]
    assert step @ right > 0
    assert step @ up > 0
    run(window, 1.0)
    assert np.abs(window.live.shown.posture - target).max() < 0.06
    QTest.keyClick(window.robot_view, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert np.allclose(window.presenters.posture.editor.target, robot.home)
    drag(window, robot_pixel(window, "hand"), QPoint(20, 20))
    QTest.keyClick(window.robot_view, Qt.Key.Key_Escape)
    assert np.allclose(window.presenters.posture.editor.target, robot.home)


def test_link_dragged_out_of_reach_is_reported(window):
    end_script(window)
    pause(window)
    window.action("posture").trigger()
    ticks = window.live.shown.tick
    release = drag(window, robot_pixel(window, "hand"), QPoint(3000, -1500))
    assert "short" in window.presenters.tools.view_tool.words
    assert window.live.shown.tick == ticks
    release()
    assert window.live.shown.tick == ticks + 1
    assert np.allclose(window.live.shown.posture, window.presenters.posture.editor.target, atol=2e-3)


def test_posture_is_copied_and_pasted_and_errors_are_shown(window):
    home = window.live.prepared.robot.home
    window.action("copy_posture").trigger()
    text = QGuiApplication.clipboard().text()
    first = window.live.prepared.robot.joints[0].name
    QGuiApplication.clipboard().setText(text.replace(f"{first} = {float(home[0])!r}", f"{first} = 0.125"))
    window.action("paste_posture").trigger()
    assert window.presenters.posture.editor.target[0] == 0.125
    assert np.allclose(window.presenters.posture.editor.target[1:], home[1:])
    QGuiApplication.clipboard().setText(f"{first} = 99")
    window.action("paste_posture").trigger()
    assert "invalid joint position" in window.notification_bar.text
    window.action("scene_posture").trigger()
    assert np.allclose(window.presenters.posture.editor.target, home)
