"""Presses on what cannot be pressed are answered, on the map and on the body."""

from __future__ import annotations

import time

import pytest
from PySide6.QtWidgets import QApplication, QToolButton

from tactile_maps.live.sources.open import SourceOptions
from tactile_widgets.context.notification_bar import READ_SECONDS
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.window_driver import click_remedy, press_map, record_run, replay_run, run, visible_skin

TEXT = "This is a recording: it cannot be pressed."


@pytest.fixture
def window(window_again):
    """The shared window; the replay is left after each test."""
    yield window_again
    window_again.live.replay.leave()
    window_again.live.connection.close()


def press(window):
    left_release(window.map_view.viewport(), press_map(window, 70))


def messages(window):
    return [message.text for message in window.notification_bar.messages]


def replay(window, path):
    replay_run(window, path, 0.4)
    assert window.live.replay.player is not None
    window.notification_bar.clear()


def test_first_press_on_a_recording_offers_to_take_over(window, tmp_path):
    replay(window, tmp_path / "a.mcap")
    bar = window.notification_bar
    for _ in range(3):
        press(window)
    left_click(window.robot_view.display.canvas.widget, visible_skin(window)[1])
    assert messages(window) == [TEXT]
    remedy = bar.findChild(QToolButton, "message-remedy")
    assert (remedy.text(), remedy.isEnabled()) == ("Take over from here", True)
    assert sum(note.text == TEXT for note in window.column["messages"].list.notes) == 1
    left_click(bar.findChild(QToolButton, "message-dismiss"))
    window.notifier.status("")
    press(window)
    assert messages(window) == []
    assert window.statusBar().currentMessage() == TEXT
    window.live.replay.leave()
    replay(window, tmp_path / "b.mcap")
    press(window)
    assert messages(window) == [TEXT], "once for each recording"


def test_offer_to_take_over_leaves_with_the_recording(window, tmp_path, monkeypatch):
    replay(window, tmp_path / "a.mcap")
    bar = window.notification_bar
    press(window)
    late = time.monotonic() + 2 * READ_SECONDS
    monkeypatch.setattr(bar, "_clock", lambda: late)
    bar._read.timeout.emit()
    assert messages(window) == [TEXT]
    window.live.replay.leave()
    QApplication.processEvents()
    bar._read.timeout.emit()
    assert messages(window) == []


def test_press_on_a_real_skin_is_explained_as_information_like_other_refused_presses(window, tmp_path):
    (tmp_path / "readings.csv").write_text("# unit: Pa\ntime,0,1\n0.0,0,0\n0.1,0,0\n")
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv"), SourceOptions(speed=None)))
    run(window, 0.1)
    window.notification_bar.clear()
    for _ in range(2):
        press(window)
        run(window, 0.1)
        (message,) = window.notification_bar.messages
        assert message.text == "A real skin is connected: it cannot be pressed here."
        assert not message.fault
    click_remedy(window, "Disconnect")
    assert window.live.live_input is None
    press(window)
    run(window, 0.1)
    window.presenters.effects.choose("fingers", "off")
    run(window, 0.1)
    window.notification_bar.clear()
    press(window)
    (message,) = window.notification_bar.messages
    assert message.text == "No finger is simulated in this scene."
    assert not message.fault


def test_recording_of_a_real_skin_is_not_offered_to_a_simulation(window, tmp_path):
    taxels = range(len(window.live.prepared.skin))
    rows = [",".join(["time", *map(str, taxels)]), *(f"{0.01 * n}{',20' * len(taxels)}" for n in range(40))]
    (tmp_path / "readings.csv").write_text("\n".join(rows))
    window.live.connection.open(LiveInputSettings(str(tmp_path / "readings.csv"), SourceOptions(speed=None)))
    run(window, 0.5)
    record_run(window, tmp_path / "real.mcap", 1.0)
    window.live.open_recording(tmp_path / "real.mcap")
    window.notification_bar.clear()
    press(window)
    (message,) = window.notification_bar.messages
    assert message.text.startswith(TEXT)
    assert message.remedies == ()
    take_over = window.action("take_over")
    assert not take_over.isEnabled()
    assert take_over.toolTip().startswith("Not for recordings of a real skin")
    window.action("disconnect").trigger()
    replay(window, tmp_path / "a.mcap")
    assert take_over.isEnabled()
    assert take_over.toolTip().startswith("Continue the simulation")
