"""Moments marked while recording and in a replay, the range, the loop and episodes, by keys, mouse and menu."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QContextMenuEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.recording.encoding.annotations import (
    MOST_TEXT,
    LabelledEpisode,
    Mark,
    Outcome,
    annotations_file,
    load_annotations,
)
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.episode_dialog import EpisodeDialog
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tactile_widgets.presenters.session.notes_presenter import slips_of
from tests.widgets.support.window_driver import run

CONTROL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture(scope="module")
def content(prepared, tmp_path_factory) -> bytes:
    """A second of a session, marked at 0.4 s."""
    path = tmp_path_factory.mktemp("notes") / "one.mcap"
    session = Session(prepared)
    with Recorder(prepared, path, viewers=False) as recorder:
        recorder.write(session.frame, session.inputs)
        for _ in range(200):
            recorder.write(session.tick(), session.inputs)
        recorder.mark(Mark(80, "Mark 1"))
    return path.read_bytes()


@pytest.fixture
def recorded(window_again, content, tmp_path):
    """The window that replays it, and the file."""
    window = window_again
    path = tmp_path / "one.mcap"
    path.write_bytes(content)
    window.live.open_recording(path)
    yield window, path
    window.live.replay.leave()


def answer(window, text):
    """Type into the question that is open, and accept."""
    box = window.findChild(QInputDialog)
    box.setTextValue(text)
    box.accept()


def names(window):
    return [mark.name for mark in window.context.notes.value.marks]


@pytest.mark.long
def test_mark_set_while_recording_is_reached_by_keys_in_the_replay(window_again, tmp_path):
    window = window_again
    path = tmp_path / "live.mcap"
    window.live.reset()
    window.live.recording.start(path)
    run(window, 0.2)
    QTest.keyClick(window, Qt.Key.Key_B, CONTROL)
    run(window, 0.2)
    assert "1 mark" in window.timeline._note.text()
    window.live.recording.stop()
    window.live.open_recording(path)
    assert window.context.notes.value.marks == (Mark(40, "Mark 1"),)
    assert not annotations_file(path).exists(), "nothing was said since"
    for _ in range(2):  # the second time, no later note exists
        QTest.keyClick(window, Qt.Key.Key_Right, Qt.KeyboardModifier.AltModifier)
        assert window.live.shown.tick == 40
    assert window.timeline.playhead.time == pytest.approx(0.2)
    window.live.replay.leave()


def test_timeline_menu_marks_the_recording_being_made(window_again, tmp_path):
    window = window_again
    timeline = window_again.timeline
    window.live.recording.start(tmp_path / "live.mcap")
    at = timeline.rect().center()
    QApplication.sendEvent(timeline, QContextMenuEvent(QContextMenuEvent.Reason.Mouse, at, timeline.mapToGlobal(at)))
    menu = window.presenters.notes.menu
    assert {window.action("mark"), window.action("name_mark")} <= set(menu.actions())
    assert window.action("mark").isEnabled()
    menu.close()
    window.live.recording.mark("long " * MOST_TEXT)
    assert "the text is too long" in window.notification_bar.text
    assert window.live.recording.marks == 0
    window.live.recording.stop()


def test_marks_of_a_replay_are_stored_and_undone(recorded):
    window, path = recorded
    before = path.read_bytes()
    window.timeline.go_to(0.7)
    QTest.keyClick(window, Qt.Key.Key_B, CONTROL)
    window.timeline.go_to(0.9)
    window.action("name_mark").trigger()
    answer(window, "lift")
    assert names(window) == ["Mark 1", "Mark 2", "lift"]
    assert load_annotations(path).marks[-1] == Mark(180, "lift")
    window.action("delete_mark").trigger()
    assert names(window) == ["Mark 1", "Mark 2"]
    assert "delete mark" in window.action("undo").text().replace("&", "")
    QTest.keyClick(window, Qt.Key.Key_Z, CONTROL)
    assert names(window) == ["Mark 1", "Mark 2", "lift"]
    QTest.keyClick(window, Qt.Key.Key_Z, CONTROL | SHIFT)
    assert names(window) == ["Mark 1", "Mark 2"]
    assert load_annotations(path).marks == window.context.notes.value.marks
    assert path.read_bytes() == before
    window.live.open_recording(path)
    assert names(window) == ["Mark 1", "Mark 2"]
    bar = window.timeline.findChild(ScrubBar)
    assert bar._notes.marks == ((pytest.approx(0.4), "Mark 1"), (pytest.approx(0.7), "Mark 2"))
    place = QPoint(round(bar.x_of(0.4)), 20)
    bar.menu_requested.emit(bar.time_at(place.x()), bar.mapToGlobal(place))
    menu = window.presenters.notes.menu
    words = [action.text().replace("&", "") for action in menu.actions()]
    assert "Delete Mark 1" in words
    menu.actions()[words.index("Delete Mark 1")].trigger()
    menu.close()
    assert names(window) == ["Mark 2"]


def test_range_is_dragged_looped_and_cleared(recorded):
    window, _ = recorded
    bar = window.timeline.findChild(ScrubBar)
    timeline = window.timeline
    start, end = (QPoint(round(bar.x_of(t)), 20) for t in (0.2, 0.6))
    QTest.mousePress(bar, LEFT, SHIFT, start)
    QTest.mouseMove(bar, end)
    QTest.mouseRelease(bar, LEFT, SHIFT, end)
    assert timeline.range.start == pytest.approx(0.2, abs=0.01)
    assert timeline.range.end == pytest.approx(0.6, abs=0.01)
    assert timeline.playhead.time == 0, "a range is no scrub"
    window.action("loop").trigger()
    assert window.action("loop").isChecked()
    for _ in range(20):
        timeline.advance(0.1)
        assert timeline.range.start <= timeline.playhead.time < timeline.range.end
    assert timeline.playhead.playing
    window.action("loop").trigger()
    assert not window.action("loop").isChecked()
    timeline.advance(10.0)
    assert timeline.playhead.time == timeline.playhead.duration
    window.action("clear_range").trigger()
    assert timeline.range is None
    assert not window.action("loop").isEnabled()


@pytest.mark.long
def test_episodes_are_made_from_a_range_and_from_marks(recorded):
    window, path = recorded
    window.timeline.go_to(0.5)
    QTest.keyClick(window, Qt.Key.Key_BracketLeft, CONTROL)
    assert window.timeline.range == Span(0.5, pytest.approx(1.0))
    window.timeline.go_to(0.75)
    QTest.keyClick(window, Qt.Key.Key_BracketRight, CONTROL)
    assert window.timeline.range == Span(0.5, 0.75)
    QTest.keyClick(window, Qt.Key.Key_E, CONTROL | SHIFT)
    dialog = window.findChild(EpisodeDialog)
    dialog.label.setText("press")
    dialog.instruction.setPlainText("press the arm gently")
    dialog.outcome.setCurrentText("Success")
    dialog._on_accepted()
    QApplication.processEvents()
    expected = LabelledEpisode(100, 150, "press", "press the arm gently", Outcome.SUCCESS)
    assert load_annotations(path).episodes == (expected,)
    window.action("delete_episode").trigger()
    assert load_annotations(path).episodes == ()
    window.action("split_episodes").trigger()
    parts = [(one.first, one.last, one.label) for one in load_annotations(path).episodes]
    assert parts == [(0, 79, "Start"), (80, 200, "Mark 1")]


@pytest.mark.long
def test_damaged_file_of_notes_is_reported_and_kept(recorded):
    window, path = recorded
    annotations_file(path).write_text("no json")
    window.live.open_recording(path)
    assert "one.notes.json" in window.notification_bar.text
    assert not window.action("mark").isEnabled()
    assert annotations_file(path).read_text() == "no json"
    assert window.live.mode is Mode.REPLAYING


def test_slips_are_spans_on_the_timeline_with_an_instant_where_slip_begins(content, tmp_path):
    (tmp_path / "one.mcap").write_bytes(content)
    player = RecordingPlayer(tmp_path / "one.mcap")
    place = player.prepared.skin.taxel_point(3)
    kinds = [("touch", "began", 0.1, 0.0), ("incipient-slip", "began", 0.2, 0.0), ("slip", "began", 0.3, 0.0)]
    kinds += [("slip", "ended", 0.5, 0.2), ("slip", "began", 0.8, 0.0)]
    player.events = tuple(
        ContactEvent(round(time / 0.005), time, kind, phase, (1,), ("forearm",), place, duration=duration)
        for kind, phase, time, duration in kinds
    )
    spans = [(round(start, 6), round(end, 6), text) for start, end, text in slips_of(player)]
    assert spans == [
        (0.2, 0.2, "Slip begins at the border"),
        (0.3, 0.5, "Slips"),
        (0.8, round(player.duration, 6), "Slips"),
    ]
