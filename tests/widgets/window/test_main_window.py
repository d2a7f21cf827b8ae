"""The whole window, real at every joint: real widgets, real events, the real simulation, time passed by hand; and its
states.
"""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QToolButton

from tactile_maps.editing.arrange import move
from tactile_maps.editing.pins import add_pin
from tactile_widgets.common.guide_window import GuideWindow
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.context.notification_bar import Message, MessageStack
from tactile_widgets.session.backends import INLINE
from tactile_widgets.tools.registry import ARRANGE
from tests.widgets.support.mouse import left_click, left_press, left_release
from tests.widgets.support.snapshots import check_picture, pixels
from tests.widgets.support.window_driver import (
    blow_up,
    cancel,
    close_window,
    open_window,
    press_map,
    record_run,
    replay_run,
    run,
    visible_skin,
)


@pytest.fixture
def window(window_again):
    """Window in its initial state; changes that cannot be undone use ``new_window``."""
    return window_again


@pytest.mark.long
def test_scripted_stroke_is_shown_after_opening(window):
    run(window, 1.5)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.scripted
    assert frame.regions, "the scripted stroke touches the skin"
    assert "1 contact" in window.column["contacts"].findChild(object, "contacts-summary").text()
    assert "× real time" in window.status_line.factor.text()


@pytest.mark.long
def test_press_on_body_and_map_touches_the_same_point(window):
    _, pixel = visible_skin(window)
    felt = []
    window.presenters.touch.touched.connect(lambda: felt.append(True))
    left_press(window.robot_view.display.canvas.widget, pixel)
    run(window, 0.3)
    from_body = window.live.runner.session.frame.pokes[-1].at
    left_release(window.robot_view.display.canvas.widget, pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.pokes
    map_pixel = window.map_view.pixel_of(from_body).toPoint()
    left_press(window.map_view.viewport(), map_pixel)
    run(window, 0.3)
    from_map = window.live.runner.session.frame.pokes[-1].at
    left_release(window.map_view.viewport(), map_pixel)
    skin = window.live.prepared.skin
    assert felt
    assert from_map.patch == from_body.patch
    # One pixel of the map is a good millimetre.
    assert np.linalg.norm(skin.position(from_map) - skin.position(from_body)) < 3e-3


@pytest.mark.long
def test_force_grows_while_pressed_and_ends_at_release(window):
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
    left_release(window.map_view.viewport(), pixel)
    run(window, 0.1)
    assert not window.live.runner.session.frame.regions


@pytest.mark.long
def test_drag_moves_the_finger_along_the_skin(window):
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
    left_release(window.map_view.viewport(), pixel)


@pytest.mark.long
@pytest.mark.parametrize("size", [(900, 600), (1107, 700), (1920, 1080)])
def test_hints_cover_no_view_and_need_no_row(new_window, size):
    bar = new_window.hint_bar
    new_window.resize(*size)
    QApplication.processEvents()
    assert bar.isVisible()
    assert new_window.statusBar().isAncestorOf(bar)
    assert new_window.timeline.isHidden()
    line = new_window.status_line
    assert line.rect().contains(bar.geometry())
    assert not bar.geometry().intersects(line.factor.geometry())


def test_hints_that_do_not_fit_are_omitted_instead_of_clipped(new_window):
    bar = new_window.hint_bar

    def shown():
        QApplication.processEvents()
        QApplication.processEvents()  # the bar is placed after the status line, and then its parts
        parts = bar.findChildren(QLabel) + bar.findChildren(QToolButton)
        visible = [part for part in parts if part.isVisible()]
        assert all(part.width() >= part.sizeHint().width() for part in visible)
        assert all(bar.rect().contains(part.geometry()) for part in visible)
        return {part.objectName() for part in visible}

    whole = {"hint-1", "hint-2", "hint-3", "hint-tour", "hint-dismiss"}
    assert shown() == whole
    new_window.resize(1366, 768)
    assert shown() == whole
    places = [part.x() for part in bar.findChildren(QToolButton)]
    new_window.loading_bar.show_progress("Preparing the map of the forearm", 0.4)
    assert shown() == whole
    assert [part.x() for part in bar.findChildren(QToolButton)] == places
    new_window.loading_bar.clear()
    new_window.resize(900, 600)
    assert shown() == whole
    new_window.loading_bar.show_progress("Preparing the map of the forearm", 0.4)
    assert shown() == {"hint-tour", "hint-dismiss"}
    new_window.loading_bar.clear()
    pixel = new_window.map_view.pixel_of(new_window.live.prepared.skin.taxel_point(20)).toPoint()
    QTest.mouseMove(new_window.map_view.viewport(), pixel + QPoint(2, 0))
    QTest.mouseMove(new_window.map_view.viewport(), pixel)
    assert shown() == {"hint-tour", "hint-dismiss"}
    assert "taxel 20" in new_window.readout.text()


@pytest.mark.long
def test_hints_are_hidden_by_the_first_touch_for_good(new_window):
    assert not new_window.hint_bar.isHidden()
    press_map(new_window, 70)
    assert new_window.hint_bar.isHidden()
    assert new_window.settings.hints_read


@pytest.mark.long
def test_hold_force_button_starts_the_controller(window):
    left_click(window.column["controller"]._buttons["hold_force"])
    press_map(window, 70)
    run(window, 3.0)
    frame = window.live.runner.session.frame
    assert window.live.runner.session.settings.controller == "hold_force"
    assert frame.regions[0].force == pytest.approx(window.live.runner.session.settings.force_goal, rel=0.05)
    assert np.abs(frame.posture - window.live.prepared.robot.home).max() > 0.01, "the arm must have moved"


@pytest.mark.long
def test_paused_session_advances_by_single_steps(window):
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


def test_hover_reports_the_point_of_the_skin(window):
    at, pixel = visible_skin(window)
    seen = []
    window.robot_view.interaction.hovered.connect(seen.append)
    QTest.mouseMove(window.robot_view.display.canvas.widget, pixel + QPoint(1, 0))
    QTest.mouseMove(window.robot_view.display.canvas.widget, pixel)
    assert seen
    assert seen[-1].patch == at.patch


@pytest.mark.long
def test_pressure_scale_is_shared_by_both_views(new_window):
    new_window.colour_bar.maximum_changed.emit(20.0)
    assert new_window.views.scale.maximum == 20.0
    assert new_window.map_view._scale.maximum == 20.0


@pytest.mark.long
def test_window_matches_its_snapshot(new_window):
    """Menus, bars, both views, panels and plots; the changing digits of the clock are left out."""
    new_window.hint_bar.show()
    run(new_window, 1.0)
    new_window.robot_view.display.draw_now()
    QApplication.processEvents()
    new_window.status_line.show_factor(1.0)
    new_window.column["timing"].hide()
    new_window.bottom.hide()
    QApplication.processEvents()
    new_window.robot_view.display.draw_now()
    check_picture(new_window, "window_dark", share=0.97)


@pytest.mark.long
def test_window_during_editing_matches_its_snapshot(new_window):
    """A patch moved and selected, pins in another, the stretch of areas under it all; the light theme."""
    new_window.set_theme("light")
    new_window.editor.do("Move", lambda document: move(document, [2], (0.05, -0.02)))
    new_window.editor.do("Pin", lambda document: add_pin(document, document.skin.taxel_point(10)))
    new_window.presenters.view.set_tool(ARRANGE)
    new_window.editor.select([2])
    new_window.presenters.view.set_base_layer(BaseLayer.AREA)
    new_window.hint_bar.hide()
    run(new_window, 0.1)
    new_window.status_line.show_factor(1.0)
    new_window.column["timing"].hide()
    new_window.bottom.hide()
    QApplication.processEvents()
    new_window.views.frame_all()
    QApplication.processEvents()
    new_window.robot_view.display.draw_now()
    check_picture(new_window, "window_editing_light", share=0.97)


@pytest.mark.long
def test_session_continues_while_another_robot_is_prepared(new_window, qtbot):
    new_window.live.report_progress("Placing taxels", 0.4)
    assert new_window.loading_bar.busy
    assert not new_window.robot_view.card.isVisible(), "the last good robot stays in sight"
    run(new_window, 0.1)
    press_map(new_window, 70)
    run(new_window, 0.1)
    assert new_window.live.runner.session.frame.pokes, "and can be touched"
    cancel(new_window)
    assert not new_window.loading_bar.busy


@pytest.mark.long
def test_long_progress_text_moves_no_widget(window):
    window.resize(1280, 800)
    QApplication.processEvents()
    places = {part: part.geometry() for part in (window.session_bar, window.views, window.status_line.factor)}
    window.loading_bar.show_progress("Flattening a patch with a very long name " * 3, 0.4)
    QApplication.processEvents()
    assert {part: part.geometry() for part in places} == places


@pytest.mark.long
def test_button_that_changes_its_text_moves_no_other(window):
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


@pytest.mark.long
def test_stopped_simulation_offers_reset(window):
    run(window, 0.2)
    blow_up(window.live)
    assert "diverged" in window.notification_bar.text
    assert window.live.mode is Mode.PAUSED
    button = window.notification_bar.findChild(QToolButton, "message-remedy")
    assert button.isVisible()
    assert button.text() == "Reset"
    left_click(button)
    assert window.live.mode is Mode.RUNNING
    assert not window.notification_bar.isVisible()


@pytest.mark.long
def test_readout_is_the_same_for_both_views(window):
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


def test_readout_is_shown_once(window):
    """The status line shows it; nothing along the lower edge of the map changes."""
    viewport = window.map_view.viewport()
    low = viewport.rect().adjusted(0, viewport.height() - 40, 0, 0)
    pixel = window.map_view.pixel_of(window.live.prepared.skin.taxel_point(20)).toPoint()
    QApplication.processEvents()
    before = pixels(viewport.grab(low).toImage())
    QTest.mouseMove(viewport, pixel + QPoint(2, 0))
    QTest.mouseMove(viewport, pixel)
    assert "taxel 20" in window.readout.text()
    np.testing.assert_array_equal(pixels(viewport.grab(low).toImage()), before)


@pytest.mark.long
def test_readout_follows_the_pressure(window):
    pixel = press_map(window, 70)
    run(window, 0.5)
    left_release(window.map_view.viewport(), pixel)
    QTest.mouseMove(window.map_view.viewport(), pixel)
    before = window.readout.text()
    run(window, 0.2)
    assert "0.00\u202fkPa" in window.readout.text()
    assert before != window.readout.text()


@pytest.mark.long
def test_right_arrow_steps_only_while_paused(window):
    window.robot_view.setFocus()
    tick = window.live.runner.session.frame.tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Space)
    assert window.live.mode is Mode.PAUSED
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick + 1


@pytest.mark.long
def test_right_arrow_changes_a_focused_gain_while_paused(window):
    window.action("pause").trigger()
    tick = window.live.runner.session.frame.tick
    slider = window.column["controller"].sliders.by_name["stiffness"]
    before = slider.value
    QTest.keyClick(slider._slider, Qt.Key.Key_Right)
    assert slider.value > before
    assert window.live.runner.session.frame.tick == tick


@pytest.mark.long
def test_shortcuts_trigger_their_actions(new_window):
    keys = {Qt.Key.Key_F1: "keys", Qt.Key.Key_Question: "keys", Qt.Key.Key_F3: "timing", Qt.Key.Key_Backspace: "reset"}
    triggered = []
    for name in {*keys.values()}:
        new_window.action(name).triggered.disconnect()
        new_window.action(name).triggered.connect(lambda _checked=False, name=name: triggered.append(name))
    new_window.robot_view.setFocus()
    for key in keys:
        QTest.keyClick(new_window, key)
    assert triggered == [*keys.values()]


@pytest.mark.long
def test_timing_shows_the_hidden_panels(window):
    window.action("panels").trigger()
    assert not window.panels.isVisible()
    window.action("timing").trigger()
    QApplication.processEvents()
    panel = window.column["timing"]
    page = window.column.page_of(panel).viewport()
    top = panel.mapTo(page, QPoint(0, 0)).y()
    assert window.panels.isVisible()
    assert 0 <= top <= page.height() - panel.height()


@pytest.mark.long
def test_reset_layout_shows_all_docks(new_window):
    new_window.action("panels").trigger()
    new_window.action("plots").trigger()
    new_window.views._splitter.setSizes([2000, 400])
    new_window.action("reset_layout").trigger()
    QApplication.processEvents()
    assert new_window.panels.isVisible()
    assert new_window.bottom.isVisible()
    left, right = new_window.views._splitter.sizes()
    assert abs(left - right) <= 2


@pytest.mark.long
def test_views_keep_their_share_of_the_window(window):
    for size in ((1400, 900), (1280, 800)):
        window.resize(*size)
        QApplication.processEvents()
        assert window.views.width() >= 0.7 * window.width()
        assert min(window.views._splitter.sizes()) >= 400


@pytest.mark.long
def test_message_bar_grows_with_its_text(qtbot, window):
    bar = MessageStack(window.theme, window.views)
    bar.show_message(Message("short", of="one"))
    low = bar.height()
    bar.show_message(Message("long " * 80, remedies=[QAction("Help", bar)], of="one"))
    assert bar.height() > low
    assert window.views.rect().contains(bar.geometry())
    bar.deleteLater()


@pytest.mark.long
def test_replay_differs_visibly_from_a_session(window, tmp_path):
    replay_run(window, tmp_path / "one.mcap", 0.2)
    assert window.status_line.factor.text() == "Replay"
    assert not any(button.isEnabled() for button in window.column["controller"].findChildren(QPushButton))
    for name in ("step", "reset", "record"):
        assert not window.action(name).isEnabled()
    window.column["timing"].refresh()
    assert window.column["timing"]._values["factor"].text() == "–"
    assert window.map_view.pixel_of(window.live.prepared.skin.taxel_point(70)) != QPointF()


@pytest.mark.long
def test_guide_opens_once(new_window):
    new_window.action("guide").trigger()
    new_window.action("guide").trigger()
    (guide,) = new_window.findChildren(GuideWindow)
    assert guide.isVisible()
    assert guide.isWindow()
    assert guide.toPlainText().startswith("The guide")
    guide.close()


@pytest.mark.long
def test_long_readout_does_not_move_the_views(window, prepared):
    before = window.views.geometry()
    for taxel in (70, 71, 72):  # Qt lays out what has grown some events later
        words = window.map_view.words_for(prepared.skin.taxel_point(taxel))
        window.map_view.readout_changed.emit(words)
        QApplication.processEvents()
        assert window.readout.text() == words != ""
    assert window.views.geometry() == before


@pytest.mark.long
def test_space_below_the_views_returns_to_its_height(new_window, tmp_path):
    window = new_window
    usual = window.bottom.height()
    window.live.recording.start(tmp_path / "a.mcap")
    run(window, 0.3)
    assert window.bottom.height() > usual, "the recording is shown above the plots"
    window.live.recording.stop()
    for _ in range(3):  # the height returns after the layout
        QApplication.processEvents()
    assert window.bottom.height() == usual
    window.resizeDocks([window.bottom], [usual + 60], Qt.Orientation.Vertical)
    QApplication.processEvents()
    assert window.plots.geometry().bottom() > window.plots.parentWidget().height() - 16, "the plots fill it"
    window.live.open_recording(tmp_path / "a.mcap")
    QApplication.processEvents()
    window.resizeDocks([window.bottom], [usual + 200], Qt.Orientation.Vertical)  # as lanes that are added do
    QApplication.processEvents()
    assert window.bottom.height() == usual + 200
    window.live.replay.leave()
    QApplication.processEvents()
    assert window.bottom.height() == usual + 60
    window.action("reset_layout").trigger()
    QApplication.processEvents()
    assert window.bottom.height() == usual


@pytest.mark.parametrize(
    "stopped", [pytest.param(True, marks=pytest.mark.long), False], ids=["at once after recording", "while recording"]
)
def test_space_below_the_views_returns_to_its_height_after_recording_and_replay(new_window, tmp_path, stopped):
    window = new_window
    usual = window.bottom.height()
    record_run(window, tmp_path / "a.mcap", 0.2)
    QApplication.processEvents()
    window.live.recording.start(tmp_path / "b.mcap")
    run(window, 0.2)
    if stopped:
        window.live.recording.stop()
    window.live.open_recording(tmp_path / "a.mcap")
    QApplication.processEvents()
    assert window.bottom.height() > usual
    window.live.replay.leave()
    for _ in range(3):  # the height returns after the layout
        QApplication.processEvents()
    assert window.bottom.height() == usual


@pytest.mark.long
@pytest.mark.parametrize("replaying", [True, False], ids=["replay", "recording"])
def test_space_below_the_views_does_not_grow_by_closing_the_window(new_window, tmp_path, prepared, replaying):
    window = new_window
    usual = window.bottom.height()
    record_run(window, tmp_path / "a.mcap", 0.2)
    if replaying:
        window.live.open_recording(tmp_path / "a.mcap")
    else:
        window.live.recording.start(tmp_path / "b.mcap")
        run(window, 0.1)
    for _ in range(4):
        QApplication.processEvents()
    assert window.bottom.height() > usual
    window.presenters.map_files.give_up()
    window.close()
    again = open_window(tmp_path, INLINE)
    again.live.show_prepared(prepared)
    for _ in range(4):
        QApplication.processEvents()
    assert again.bottom.height() == usual
    close_window(again)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("width", [1107, 1400])
def test_timeline_and_curves_share_one_time_axis(new_window, tmp_path, width):
    window = new_window
    record_run(window, tmp_path / "a.mcap", 0.4)
    window.resize(width, 900)
    window.live.open_recording(tmp_path / "a.mcap")
    QApplication.processEvents()
    bar = window.timeline._bar
    plots = window.recording_plots
    for time in (0.0, 0.2, window.live.replay.player.duration):
        on_bar = bar.mapTo(window, QPoint(0, 0)).x() + bar.x_of(time)
        on_plots = plots.mapTo(window, QPoint(0, 0)).x() + plots.x_of(time)
        assert on_bar == pytest.approx(on_plots, abs=2.0)
