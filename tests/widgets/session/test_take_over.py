"""Pressing where nothing can be pressed: a scene without fingers, and a recording that is taken over."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests.widgets.support.window_driver import press_map, run


@pytest.fixture
def window(window_again):
    return window_again


def click_remedy(window, text):
    (button,) = [button for button in window.notification_bar._remedies if button.text() == text]
    assert button.isVisible()
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def lift(window):
    QTest.mouseRelease(window.map_view.viewport(), Qt.MouseButton.LeftButton)


def test_a_scene_without_fingers_offers_them(window):
    window.presenters.effects.wish("fingers", "off")
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


def test_a_recording_is_taken_over_from_the_instant_that_is_shown(window, tmp_path, qtbot):
    window.live.start_recording(tmp_path / "a.mcap")
    window.column["controller"].choose_controller("hold_force")
    press_map(window, 20)
    run(window, 0.6)
    window.live.stop_recording()
    lift(window)
    window.live.open_recording(tmp_path / "a.mcap")
    window.live.show_time(0.4)
    shown = window.live.shown
    press_map(window, 60)
    lift(window)
    assert "recording" in window.notification_bar.text
    click_remedy(window, "Take over from here")
    qtbot.waitUntil(lambda: window.live.mode == "live")
    session = window.live.runner.session
    assert session.frame.tick == shown.tick
    assert session.frame.posture.tobytes() == shown.posture.tobytes()
    assert session.frame.pressures.tobytes() == shown.pressures.tobytes()
    assert session.settings.controller == "hold_force"
    assert [poke.id for poke in session.frame.pokes] == [poke.id for poke in shown.pokes]
    run(window, 0.2)
    assert session.frame.tick > shown.tick, "and it goes on"
