"""The whole window, real at every joint: real widgets, real events, the real simulation, time passed by hand."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.editing.arrange import move
from app.editing.pins import add_pin
from tests.widgets.pictures import check_picture
from tests.widgets.window_acts import press_map, run, visible_skin
from widgets.colours import DARK, LIGHT
from widgets.overlays import Ground
from widgets.tools import Tool


def test_it_opens_alive(window):
    run(window, 1.5)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.scripted
    assert frame.regions, "the scripted stroke must keep the map alive"
    assert "1 contact" in window.column.contacts.findChild(object, "contacts-summary").text()
    assert "× real time" in window.session_bar.factor.text()


def test_a_press_on_the_body_and_on_the_map_are_the_same_act(window):
    _, pixel = visible_skin(window)
    felt = []
    window.live.touched.connect(lambda: felt.append(True))
    QTest.mousePress(window.robot_view.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.3)
    from_body = window.live.runner.session.frame.pokes[-1].at
    QTest.mouseRelease(window.robot_view.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.pokes
    map_pixel = window.map_view.pixel_of(from_body).toPoint()
    QTest.mousePress(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=map_pixel)
    run(window, 0.3)
    from_map = window.live.runner.session.frame.pokes[-1].at
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=map_pixel)
    skin = window.live.prepared.skin
    assert felt
    assert from_map.patch == from_body.patch
    # One pixel of the map is a good millimetre.
    assert np.linalg.norm(skin.position(from_map) - skin.position(from_body)) < 3e-3


def test_force_grows_while_held_and_ends_with_the_release(window):
    pixel = press_map(window, 70)
    forces = []
    for _ in range(6):
        run(window, 0.1)
        forces.append(window.live.runner.session.frame.pokes[-1].force)
    assert forces[0] > 0
    assert forces == sorted(forces)
    assert forces[-1] > 2 * forces[0]
    (region,) = window.live.runner.session.frame.regions
    assert region.force == pytest.approx(forces[-1], rel=1e-6)
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.regions


def test_a_drag_strokes(window):
    skin = window.live.prepared.skin
    first, last = skin.neighbours[len(skin.neighbours) // 2]
    press_map(window, int(first))
    run(window, 0.4)
    before = window.live.runner.session.frame
    pixel = window.map_view.pixel_of(skin.taxel_point(int(last))).toPoint()
    QTest.mouseMove(window.map_view.viewport(), pixel)
    run(window, 0.05)
    after = window.live.runner.session.frame
    assert after.pokes[-1].at != before.pokes[-1].at
    assert after.pokes[-1].force > 0.5 * before.pokes[-1].force, "a stroke keeps its depth"
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)


def test_hints_go_with_the_first_touch_and_stay_away(window):
    assert not window.hint_bar.isHidden()
    press_map(window, 70)
    assert window.hint_bar.isHidden()
    assert window.settings.hints_read


def test_holding_force_is_a_click_away_and_works(window):
    QTest.mouseClick(window.column.controller._buttons["hold_force"], Qt.MouseButton.LeftButton)
    press_map(window, 70)
    run(window, 3.0)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.settings.law == "hold_force"
    assert frame.regions[0].force == pytest.approx(window.live.runner.session.settings.force_goal, rel=0.05)
    assert np.abs(frame.posture - window.live.prepared.robot.home).max() > 0.01, "the arm must have moved"


def test_gains_are_live(window):
    slider = window.column.controller.sliders.by_name["stiffness"]._slider
    before = window.live.runner.session.settings.stiffness
    QTest.keyClick(slider, Qt.Key.Key_Right)
    run(window, 0.05)
    assert window.live.runner.session.settings.stiffness > before


def test_pause_and_step(window):
    window.action("pause").trigger()
    assert window.live.mode == "paused"
    tick = window.live.runner.session.frame.tick
    run(window, 0.2)
    assert window.live.runner.session.frame.tick == tick
    window.action("step").trigger()
    assert window.live.runner.session.frame.tick == tick + 1
    window.action("pause").trigger()
    run(window, 0.05)
    assert window.live.runner.session.frame.tick > tick + 1


def test_hover_is_shared(window):
    at, pixel = visible_skin(window)
    seen = []
    window.robot_view.hovered.connect(seen.append)
    QTest.mouseMove(window.robot_view.canvas.widget, pixel + QPoint(1, 0))
    QTest.mouseMove(window.robot_view.canvas.widget, pixel)
    assert seen
    assert seen[-1].patch == at.patch


def test_both_themes(window):
    window.action("theme").trigger()
    assert window.theme == LIGHT
    run(window, 0.05)
    light = window.grab().toImage().pixelColor(window.width() // 2, 12).lightness()
    window.action("theme").trigger()
    run(window, 0.05)
    assert window.theme == DARK
    assert light > 200 > window.grab().toImage().pixelColor(window.width() // 2, 12).lightness()


def test_the_pressure_scale_is_shared(window):
    window.colour_bar.maximum_changed.emit(20.0)
    assert window.views.scale.maximum == 20.0
    assert window.map_view._scale.maximum == 20.0


def test_quality_is_shown(window):
    window.show_quality()
    assert window.column.quality.findChild(object, "quality-flips").text() == "0"
    assert window.column.quality.findChild(object, "quality-bijective").text() == "yes"


def test_the_picture_of_the_whole_window(window):
    """Menus, bars, both views, panels and plots; the changing digits of the clock are left out."""
    window.hint_bar.show()
    run(window, 1.0)
    window.robot_view.draw_now()
    QApplication.processEvents()
    window.session_bar.show_factor(1.0)
    window.column.timing.hide()
    window.plots.hide()
    QApplication.processEvents()
    window.robot_view.draw_now()
    check_picture(window, "window_dark", share=0.97)


def test_the_picture_of_the_window_in_which_the_map_is_edited(window, qtbot):
    """A patch moved and selected, pins in another, the stretch of areas under it all; the light theme."""
    window.set_theme("light")
    window.editor.do("Move", lambda document: move(document, [2], (0.05, -0.02)))
    window.editor.do("Pin", lambda document: add_pin(document, document.skin.taxel_point(10)))
    window.seeing.set_tool(Tool.ARRANGE)
    window.editor.select([2])
    window.seeing.set_ground(Ground.AREA)
    window.hint_bar.hide()
    run(window, 0.1)
    window.session_bar.show_factor(1.0)
    window.column.timing.hide()
    window.plots.hide()
    qtbot.waitUntil(lambda: window.bottom.height() < 100)  # what is below gives its room to the views, in its own time
    window.views.frame_all()
    QApplication.processEvents()
    window.robot_view.draw_now()
    check_picture(window, "window_editing_light", share=0.97)
