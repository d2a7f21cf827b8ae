"""Timeline with real key and mouse events."""

from __future__ import annotations

import re

import pytest
from PySide6.QtCore import QBuffer, QPoint, Qt
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QComboBox, QLabel, QPushButton, QVBoxLayout, QWidget

from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.plots.timeline.scrub_bar import DamagedSpan, ScrubBar
from tactile_widgets.plots.timeline.timeline import Timeline
from tests.widgets.support.mouse import left_click, left_drag, left_press, left_release
from tests.widgets.support.window_driver import activate

NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def timeline(qtbot):
    timeline = Timeline(DARK)
    qtbot.addWidget(timeline)
    timeline.resize(900, 56)
    timeline.show()
    qtbot.waitExposed(timeline)
    return timeline


@pytest.fixture
def replay(timeline):
    timeline.set_recording(10.0, [(1.0, 2.0), (4.0, 4.01)], frame_seconds=0.1)
    return timeline


@pytest.fixture
def heard(timeline):
    heard = {"scrubbed": [], "played": [], "live": 0}
    timeline.scrubbed.connect(heard["scrubbed"].append)
    timeline.play_toggled.connect(heard["played"].append)
    return heard


def key(timeline, *presses, modifier=NONE):
    bar = timeline.findChild(ScrubBar)
    for press in presses:
        QTest.keyClick(bar, press, modifier)


def words(timeline):
    return " ".join(label.text() for label in timeline.findChildren(QLabel) if label.isVisible())


def test_empty_timeline_takes_no_space(timeline):
    timeline.set_live(None)
    assert timeline.isHidden()
    timeline.set_live(1.0)
    assert timeline.isVisible()
    timeline.set_live(None)
    assert timeline.isHidden()


def test_timeline_shows_the_recorded_duration(timeline):
    timeline.set_live(64.25)
    assert "Recording" in words(timeline)
    assert "1:04.2" in words(timeline)
    timeline.set_live(None)
    assert timeline.isHidden()


def test_tab_passes_over_the_timeline_while_a_recording_is_made(qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    column = QVBoxLayout(window)
    timeline = Timeline(DARK)
    before = QPushButton("before")
    after = QPushButton("after")
    for widget in (before, timeline, after):
        column.addWidget(widget)
    timeline.set_live(1.0)
    window.show()
    activate(window)
    before.setFocus()
    QTest.keyClick(before, Qt.Key.Key_Tab)
    assert timeline.isVisible()
    assert after.hasFocus()


def test_timeline_shows_a_recording(replay):
    assert replay.findChild(ScrubBar).isVisible()
    assert "0:00.0 / 0:10.0" in words(replay)


def test_bar_labels_only_times_of_the_recording(timeline, qapp):
    timeline.set_recording(100.0, [], frame_seconds=0.1)
    drawing = QSvgGenerator()
    drawing.setOutputDevice(buffer := QBuffer())
    timeline.findChild(ScrubBar).render(drawing)
    labels = re.findall(r">(\d:\d\d)</text>", buffer.data().toStdString())
    assert labels == ["0:00", "0:30", "1:00", "1:30"]


def test_mouse_drag_on_the_bar_scrubs(replay, heard):
    bar = replay.findChild(ScrubBar)
    left_drag(bar, QPoint(round(bar.x_of(5.0)), 20), QPoint(round(bar.x_of(7.5)), 30))
    QTest.mouseMove(bar, QPoint(round(bar.x_of(1.0)), 30))
    assert heard["scrubbed"] == pytest.approx([5.0, 7.5], abs=10.0 / bar.width())
    left_click(bar, QPoint(0, 20))
    assert replay.playhead.time == 0.0


def test_keys_step_and_jump(replay, heard):
    key(replay, Qt.Key.Key_Right, Qt.Key.Key_Right, Qt.Key.Key_Left)
    key(replay, Qt.Key.Key_Right, modifier=SHIFT)
    key(replay, Qt.Key.Key_End, Qt.Key.Key_Home)
    assert heard["scrubbed"] == pytest.approx([0.1, 0.2, 0.1, 1.1, 10.0, 0.0])


def test_space_plays_pauses_and_starts_over_at_the_end(replay, heard):
    key(replay, Qt.Key.Key_Space)
    replay.advance(2.0)
    key(replay, Qt.Key.Key_Space)
    replay.advance(2.0)
    assert replay.playhead.time == pytest.approx(2.0)
    key(replay, Qt.Key.Key_End, Qt.Key.Key_Space)
    assert heard["played"] == [True, False, True]
    assert replay.playhead.time == 0.0
    replay.advance(60.0)
    assert heard["played"][-1] is False
    assert heard["scrubbed"][-1] == 10.0


def test_button_shows_its_action(replay, heard):
    button = replay.findChild(QPushButton, "timeline-play")
    assert button.text() == "Play"
    left_click(button)
    assert button.text() == "Pause"
    assert heard["played"] == [True]


def test_selected_speed_applies_to_playback_and_is_kept(replay, heard):
    speeds = replay.findChild(QComboBox)
    assert [speeds.itemText(k) for k in range(speeds.count())] == ["0.1×", "0.25×", "0.5×", "1×", "2×", "5×"]
    QTest.keyClick(speeds, Qt.Key.Key_Down)
    assert replay.playhead.speed == 2.0
    replay.toggle_play()
    replay.advance(1.0)
    assert replay.playhead.time == pytest.approx(2.0)
    replay.set_recording(10.0, [])
    assert replay.playhead.speed == 2.0


def test_playback_waits_while_the_bar_is_held(replay):
    bar = replay.findChild(ScrubBar)
    replay.toggle_play()
    place = QPoint(round(bar.x_of(5.0)), 20)
    left_press(bar, place)
    held = replay.playhead.time
    replay.advance(1.0)
    assert replay.playhead.time == held
    left_release(bar, place)
    replay.advance(1.0)
    assert replay.playhead.time == pytest.approx(held + 1.0)


def test_setting_the_time_emits_no_signal(replay, heard):
    replay.set_time(3.21)
    assert "0:03.2" in words(replay)
    assert replay.findChild(ScrubBar).accessibleDescription() == "0:03.2 of 0:10.0"
    assert heard["scrubbed"] == []


def test_live_button_leaves_the_replay_and_hides_the_timeline(replay, heard, qtbot):
    replay.toggle_play()
    with qtbot.waitSignal(replay.live_requested):
        left_click(replay.findChild(QPushButton, "timeline-live"))
    replay.set_live(None)
    assert heard["played"] == [True, False]
    assert replay.isHidden()
    key(replay, Qt.Key.Key_Space)
    assert heard["played"] == [True, False]


def test_hover_shows_a_time_and_themes_change(replay):
    bar = replay.findChild(ScrubBar)
    before = bar.grab().toImage()
    QTest.mouseMove(bar, QPoint(400, 20))
    assert bar.grab().toImage() != before
    replay.set_theme(LIGHT)
    light = bar.grab().toImage()
    replay.set_theme(DARK)
    assert bar.grab().toImage() != light


def test_map_edit_is_marked_and_named_under_the_pointer(qtbot):
    bar = ScrubBar(DARK)
    qtbot.addWidget(bar)
    bar.resize(600, 48)
    bar.show_recording(10.0, [])
    bare = bar.grab().toImage()
    bar.show_recording(10.0, [], [(4.0, "Move")])
    marked = bar.grab().toImage()
    assert marked != bare
    QTest.mouseMove(bar, QPoint(round(bar.x_of(4.0)) + 2, 24))
    named = bar.grab().toImage()
    bar.show_recording(10.0, [])
    assert named != bar.grab().toImage(), "its name is shown next to the time"


def test_damage_is_marked_and_named_under_the_pointer(qtbot):
    bar = ScrubBar(DARK)
    qtbot.addWidget(bar)
    bar.resize(600, 48)
    bar.show_recording(10.0, [])
    whole = bar.grab().toImage()
    bar.show_recording(10.0, [], damage=[DamagedSpan(4.0, 4.01, "frames missing: 2")])
    marked = bar.grab().toImage()
    width = whole.width()
    height = whole.height()
    changed = [x for x in range(width) if any(whole.pixel(x, y) != marked.pixel(x, y) for y in range(height))]
    assert changed, "one hundredth of a second is seen"
    assert abs(sum(changed) / len(changed) - bar.x_of(4.005)) < 2
    bar.show()
    qtbot.waitExposed(bar)
    QTest.mouseMove(bar, QPoint(round(bar.x_of(4.0)), 20))
    named = bar.grab().toImage()
    bar.show_recording(10.0, [], damage=[DamagedSpan(4.0, 4.01, "inputs missing: 2")])
    assert named != bar.grab().toImage(), "the loss is shown next to the time"
