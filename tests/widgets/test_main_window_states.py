"""The window's states: loading beside a living scene, halted, replaying; its keys, readout and messages."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QToolButton

from tests.widgets.window_acts import blow_up, press_map, run, visible_skin
from widgets.actions import ACTIONS
from widgets.message_bar import MessageBar


def test_another_robot_loads_beside_the_one_that_lives(window, qtbot):
    window.live.loading.emit("Placing taxels", 0.4)
    assert window.loading_bar.busy
    assert not window.robot_view._card.isVisible(), "the last good robot stays in sight"
    run(window, 0.1)
    press_map(window, 70)
    run(window, 0.1)
    assert window.live.runner.session.frame.pokes, "and can be touched"
    QTest.mouseClick(window.loading_bar.findChild(QToolButton, "loading-cancel"), Qt.MouseButton.LeftButton)
    assert not window.loading_bar.busy


def test_loading_moves_nothing_however_long_its_words(window):
    window.resize(1280, 800)
    QApplication.processEvents()
    places = {part: part.geometry() for part in (window.session_bar, window.views, window.session_bar.factor)}
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
    assert "diverged" in window.message_bar.text
    assert window.live.mode == "paused"
    button = window.message_bar.findChild(QToolButton, "message-remedy")
    assert button.isVisible()
    assert button.text() == "Reset"
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert window.live.mode == "live"
    assert not window.message_bar.isVisible()


def test_a_message_without_remedy_has_no_button_left_from_the_one_before(qtbot, window):
    window.message_bar.say("one", remedies=[window.action("reset")])
    window.message_bar.say("two")
    assert not window.message_bar.findChild(QToolButton, "message-remedy").isVisible()
    assert window.action("reset").text() == "Reset"


def test_a_message_can_be_dismissed(window):
    window.message_bar.say("one")
    QTest.mouseClick(window.message_bar.findChild(QToolButton, "message-dismiss"), Qt.MouseButton.LeftButton)
    assert window.message_bar.text == ""


def test_the_readout_speaks_for_both_views(window):
    run(window, 0.1)
    at, pixel = visible_skin(window)
    widget = window.robot_view.canvas.widget
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
    assert "0.00\u2009kPa" in window.readout.text()
    assert before != window.readout.text()


def test_right_steps_while_paused_and_only_then(window):
    window.robot_view.setFocus()
    tick = window.live.runner.session.frame.tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick
    QTest.keyClick(window.robot_view, Qt.Key.Key_Space)
    assert window.live.mode == "paused"
    QTest.keyClick(window.robot_view, Qt.Key.Key_Right)
    assert window.live.runner.session.frame.tick == tick + 1


def test_right_still_turns_a_gain_while_paused(window):
    window.action("pause").trigger()
    tick = window.live.runner.session.frame.tick
    slider = window.column.controller.sliders.by_name["stiffness"]
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
def test_keys_do_what_the_table_says(window, key, name):
    done = []
    window.action(name).triggered.connect(lambda: done.append(name))
    window.action("keys").triggered.disconnect()
    window.action("keys").triggered.connect(lambda: done.append("keys"))
    window.robot_view.setFocus()
    QTest.keyClick(window, key)
    assert name in done


def test_no_key_means_two_things():
    keys = [key for spec in ACTIONS for key in spec.keys]
    assert len(keys) == len(set(keys))


def test_timing_comes_into_sight_even_when_hidden(window):
    window.action("panels").trigger()
    assert not window.panels.isVisible()
    window.action("timing").trigger()
    QApplication.processEvents()
    panel = window.column.timing
    top = panel.mapTo(window.column.viewport(), QPoint(0, 0)).y()
    assert window.panels.isVisible()
    assert 0 <= top <= window.column.viewport().height() - panel.height()


def test_reset_layout_brings_everything_back(window):
    window.action("panels").trigger()
    window.action("plots").trigger()
    window.views._splitter.setSizes([2000, 400])
    window.action("reset_layout").trigger()
    QApplication.processEvents()
    assert window.panels.isVisible()
    assert window.bottom.isVisible()
    left, right = window.views._splitter.sizes()
    assert abs(left - right) <= 2


@pytest.mark.parametrize("size", [(1400, 900), (1280, 800)])
def test_views_keep_their_share(window, size):
    window.resize(*size)
    QApplication.processEvents()
    assert window.views.width() >= 0.7 * window.width()
    assert min(window.views._splitter.sizes()) >= 400


def test_a_message_bar_grows_with_its_words(qtbot, window):
    bar = MessageBar(window.theme, window.views)
    bar.say("short")
    low = bar.height()
    bar.say("long " * 80, remedies=[QAction("Help", bar)])
    assert bar.height() > low
    assert window.views.rect().contains(bar.geometry())


def test_the_eye_sees_a_replay_is_no_live_session(window, tmp_path):
    window.live.start_recording(tmp_path / "one.mcap")
    run(window, 0.2)
    window.live.stop_recording()
    window.live.open_recording(tmp_path / "one.mcap")
    assert window.session_bar.factor.text() == "Replay"
    assert not window.column.controller.isEnabled()
    for name in ("step", "reset", "record"):
        assert not window.action(name).isEnabled()
    window.column.timing.refresh()
    assert window.column.timing._values["factor"].text() == "–"
    assert window.map_view.pixel_of(window.live.prepared.skin.taxel_point(70)) != QPointF()
