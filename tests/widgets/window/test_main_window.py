"""The whole window, real at every joint: real widgets, real events, the real simulation, time passed by hand; and its
states.
"""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QToolButton

from tactile_maps.editing.arrange import move
from tactile_maps.editing.pins import add_pin
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.common.guide_window import GuideWindow
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.context.notification_bar import NotificationBar
from tactile_widgets.tools.registry import ARRANGE
from tests.widgets.support.snapshots import check_picture
from tests.widgets.support.window_driver import blow_up, press_map, run, visible_skin


@pytest.fixture
def window(window_again):
    """As new; what cannot be undone is done to ``new_window``."""
    return window_again


def test_it_opens_alive(window):
    run(window, 1.5)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.scripted
    assert frame.regions, "the scripted stroke must keep the map alive"
    assert "1 contact" in window.column["contacts"].findChild(object, "contacts-summary").text()
    assert "× real time" in window.status_line.factor.text()


def test_a_press_on_the_body_and_on_the_map_are_the_same_act(window):
    _, pixel = visible_skin(window)
    felt = []
    window.presenters.touch.touched.connect(lambda: felt.append(True))
    QTest.mousePress(window.robot_view.display.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
    run(window, 0.3)
    from_body = window.live.runner.session.frame.pokes[-1].at
    QTest.mouseRelease(window.robot_view.display.canvas.widget, Qt.MouseButton.LeftButton, pos=pixel)
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


def test_hints_lie_over_neither_view_and_go_when_a_recording_begins(new_window):
    bar = new_window.hint_bar
    assert bar.isVisible()
    assert new_window.timeline.isAncestorOf(bar)
    new_window.action("record").trigger()
    assert bar.isHidden()


def test_hints_go_with_the_first_touch_and_stay_away(new_window):
    assert not new_window.hint_bar.isHidden()
    press_map(new_window, 70)
    assert new_window.hint_bar.isHidden()
    assert new_window.settings.hints_read


def test_holding_force_is_a_click_away_and_works(window):
    QTest.mouseClick(window.column["controller"]._buttons["hold_force"], Qt.MouseButton.LeftButton)
    press_map(window, 70)
    run(window, 3.0)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.settings.controller == "hold_force"
    assert frame.regions[0].force == pytest.approx(window.live.runner.session.settings.force_goal, rel=0.05)
    assert np.abs(frame.posture - window.live.prepared.robot.home).max() > 0.01, "the arm must have moved"


def test_gains_are_live(window):
    slider = window.column["controller"].sliders.by_name["stiffness"]._slider
    before = window.live.runner.session.settings.stiffness
    QTest.keyClick(slider, Qt.Key.Key_Right)
    run(window, 0.05)
    assert window.live.runner.session.settings.stiffness > before


def test_pause_and_step(window):
    window.action("pause").trigger()
    assert window.live.mode is Mode.PAUSED
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
    window.robot_view.interaction.hovered.connect(seen.append)
    QTest.mouseMove(window.robot_view.display.canvas.widget, pixel + QPoint(1, 0))
    QTest.mouseMove(window.robot_view.display.canvas.widget, pixel)
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


def test_the_pressure_scale_is_shared(new_window):
    new_window.colour_bar.maximum_changed.emit(20.0)
    assert new_window.views.scale.maximum == 20.0
    assert new_window.map_view._scale.maximum == 20.0


def test_quality_is_shown(window):
    window.show_quality()
    assert window.column["quality"].findChild(object, "quality-flips").text() == "0"
    assert window.column["quality"].findChild(object, "quality-bijective").text() == "yes"


def test_the_picture_of_the_whole_window(new_window):
    """Menus, bars, both views, panels and plots; the changing digits of the clock are left out."""
    new_window.hint_bar.show()
    run(new_window, 1.0)
    new_window.robot_view.display.draw_now()
    QApplication.processEvents()
    new_window.status_line.show_factor(1.0)
    new_window.column["timing"].hide()
    new_window.plots.hide()
    QApplication.processEvents()
    new_window.robot_view.display.draw_now()
    check_picture(new_window, "window_dark", share=0.97)


def test_the_picture_of_the_window_in_which_the_map_is_edited(new_window, qtbot):
    """A patch moved and selected, pins in another, the stretch of areas under it all; the light theme."""
    new_window.set_theme("light")
    new_window.editor.do("Move", lambda document: move(document, [2], (0.05, -0.02)))
    new_window.editor.do("Pin", lambda document: add_pin(document, document.skin.taxel_point(10)))
    new_window.presenters.view.set_tool(ARRANGE)
    new_window.editor.select([2])
    new_window.presenters.view.set_ground(BaseLayer.AREA)
    new_window.hint_bar.hide()
    run(new_window, 0.1)
    new_window.status_line.show_factor(1.0)
    new_window.column["timing"].hide()
    new_window.plots.hide()
    qtbot.waitUntil(
        lambda: new_window.bottom.height() < 100
    )  # what is below gives its room to the views, in its own time
    new_window.views.frame_all()
    QApplication.processEvents()
    new_window.robot_view.display.draw_now()
    check_picture(new_window, "window_editing_light", share=0.97)


def test_another_robot_loads_beside_the_one_that_lives(new_window, qtbot):
    new_window.live.loading.emit("Placing taxels", 0.4)
    assert new_window.loading_bar.busy
    assert not new_window.robot_view.card.isVisible(), "the last good robot stays in sight"
    run(new_window, 0.1)
    press_map(new_window, 70)
    run(new_window, 0.1)
    assert new_window.live.runner.session.frame.pokes, "and can be touched"
    QTest.mouseClick(new_window.loading_bar.findChild(QToolButton, "loading-cancel"), Qt.MouseButton.LeftButton)
    assert not new_window.loading_bar.busy


def test_loading_moves_nothing_however_long_its_words(window):
    window.resize(1280, 800)
    QApplication.processEvents()
    places = {part: part.geometry() for part in (window.session_bar, window.views, window.status_line.factor)}
    window.loading_bar.show_progress("Flattening a patch with a name that nobody would want to read " * 3, 0.4)
    QApplication.processEvents()
    assert {part: part.geometry() for part in places} == places


def test_a_button_that_changes_its_word_moves_no_other(window):
    def places():
        QApplication.processEvents()
        buttons = [window.session_bar.widgetForAction(window.action(name)) for name in ("step", "reset", "record")]
        return [part.geometry() for part in (*buttons, window.session_bar.speed)]

    before = places()
    window.action("pause").trigger()
    window.action("record").trigger()
    assert places() == before
    for name in ("pause", "step", "reset", "record"):
        button = window.session_bar.widgetForAction(window.action(name))
        assert button.sizeHint().width() <= button.width(), f"{button.text()} is cut"


def test_a_halted_simulation_offers_its_reset(window):
    run(window, 0.2)
    blow_up(window.live)
    assert "diverged" in window.notification_bar.text
    assert window.live.mode is Mode.PAUSED
    button = window.notification_bar.findChild(QToolButton, "message-remedy")
    assert button.isVisible()
    assert button.text() == "Reset"
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert window.live.mode is Mode.RUNNING
    assert not window.notification_bar.isVisible()


def test_a_message_without_remedy_has_no_button_left_from_the_one_before(qtbot, window):
    window.notification_bar.say("one", remedies=[window.action("reset")])
    window.notification_bar.say("two")
    assert not window.notification_bar.findChild(QToolButton, "message-remedy").isVisible()
    assert window.action("reset").iconText() == "Reset"


def test_a_message_can_be_dismissed(window):
    window.notification_bar.say("one")
    QTest.mouseClick(window.notification_bar.findChild(QToolButton, "message-dismiss"), Qt.MouseButton.LeftButton)
    assert window.notification_bar.text == ""


def test_the_readout_speaks_for_both_views(window):
    run(window, 0.1)
    at, pixel = visible_skin(window)
    widget = window.robot_view.display.canvas.widget
    QTest.mouseMove(widget, pixel + QPoint(1, 0))
    QTest.mouseMove(widget, pixel)
    from_body = window.readout.text()
    assert from_body.startswith(window.live.prepared.skin.patches[at.patch].name)
    assert "kPa" in from_body
    QTest.mouseMove(window.map_view.viewport(), window.map_view.pixel_of(at).toPoint())
    assert window.readout.text().split("·")[:2] == from_body.split("·")[:2]
    QTest.mouseMove(window.map_view.viewport(), QPoint(2, 2))
    assert window.readout.text() == ""


def test_the_readout_follows_the_pressure(window):
    pixel = press_map(window, 70)
    run(window, 0.5)
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton, pos=pixel)
    QTest.mouseMove(window.map_view.viewport(), pixel)
    before = window.readout.text()
    run(window, 0.2)
    assert "0.00\u202fkPa" in window.readout.text()
    assert before != window.readout.text()


def test_right_steps_while_paused_and_only_then(window):
    window.robot_view.setFocus()
    tick = window.live.runner.session.frame.tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Space)
    assert window.live.mode is Mode.PAUSED
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick + 1


def test_right_still_turns_a_gain_while_paused(window):
    window.action("pause").trigger()
    tick = window.live.runner.session.frame.tick
    slider = window.column["controller"].sliders.by_name["stiffness"]
    before = slider.value
    QTest.keyClick(slider._slider, Qt.Key.Key_Right)
    assert slider.value > before
    assert window.live.runner.session.frame.tick == tick


@pytest.mark.parametrize(
    ("key", "name"),
    [
        (Qt.Key.Key_F1, "keys"),
        (Qt.Key.Key_Question, "keys"),
        (Qt.Key.Key_F3, "timing"),
        (Qt.Key.Key_Backspace, "reset"),
    ],
)
def test_keys_do_what_the_table_says(new_window, key, name):
    done = []
    new_window.action(name).triggered.connect(lambda: done.append(name))
    new_window.action("keys").triggered.disconnect()
    new_window.action("keys").triggered.connect(lambda: done.append("keys"))
    new_window.robot_view.setFocus()
    QTest.keyClick(new_window, key)
    assert name in done


def test_timing_comes_into_sight_even_when_hidden(window):
    window.action("panels").trigger()
    assert not window.panels.isVisible()
    window.action("timing").trigger()
    QApplication.processEvents()
    panel = window.column["timing"]
    top = panel.mapTo(window.column.viewport(), QPoint(0, 0)).y()
    assert window.panels.isVisible()
    assert 0 <= top <= window.column.viewport().height() - panel.height()


def test_reset_layout_brings_everything_back(new_window):
    new_window.action("panels").trigger()
    new_window.action("plots").trigger()
    new_window.views._splitter.setSizes([2000, 400])
    new_window.action("reset_layout").trigger()
    QApplication.processEvents()
    assert new_window.panels.isVisible()
    assert new_window.bottom.isVisible()
    left, right = new_window.views._splitter.sizes()
    assert abs(left - right) <= 2


@pytest.mark.parametrize("size", [(1400, 900), (1280, 800)])
def test_views_keep_their_share(new_window, size):
    new_window.resize(*size)
    QApplication.processEvents()
    assert new_window.views.width() >= 0.7 * new_window.width()
    assert min(new_window.views._splitter.sizes()) >= 400


def test_a_message_bar_grows_with_its_words(qtbot, window):
    bar = NotificationBar(window.theme, window.views)
    bar.say("short")
    low = bar.height()
    bar.say("long " * 80, remedies=[QAction("Help", bar)])
    assert bar.height() > low
    assert window.views.rect().contains(bar.geometry())


def test_the_eye_sees_a_replay_is_no_live_session(window, tmp_path):
    window.live.recording.start(tmp_path / "one.mcap")
    run(window, 0.2)
    window.live.recording.stop()
    window.live.open_recording(tmp_path / "one.mcap")
    assert window.status_line.factor.text() == "Replay"
    assert not window.column["controller"].isEnabled()
    for name in ("step", "reset", "record"):
        assert not window.action(name).isEnabled()
    window.column["timing"].refresh()
    assert window.column["timing"]._values["factor"].text() == "–"
    assert window.map_view.pixel_of(window.live.prepared.skin.taxel_point(70)) != QPointF()


def test_the_guide_opens_once_beside_the_window(new_window):
    new_window.action("guide").trigger()
    new_window.action("guide").trigger()
    (guide,) = new_window.findChildren(GuideWindow)
    assert guide.isVisible()
    assert guide.isWindow()
    assert guide.toPlainText().startswith("The guide")
    guide.close()


def test_the_views_stay_where_they_are_whatever_is_read_out(window, prepared):
    before = window.views.geometry()
    for taxel in (70, 71, 72):  # Qt lays out what has grown some events later
        words = window.map_view.words_for(prepared.skin.taxel_point(taxel))
        window.map_view.readout_changed.emit(words)
        QApplication.processEvents()
        assert window.readout.text() == words != ""
    assert window.views.geometry() == before
