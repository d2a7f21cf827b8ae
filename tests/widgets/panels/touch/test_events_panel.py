"""The log of contact events: what it lists, and that it follows frames in any order."""

from __future__ import annotations

from dataclasses import replace

import pytest
from PySide6.QtCore import Qt

from tactile_maps.contacts.events import ContactEvent
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.panels.touch.events_panel import EventsPanel, event_lines
from tests.widgets.support.samples import leaf_map, touched

AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))


def event(tick, kind, phase, *contacts):
    links = ("left_hand", "right_forearm") if kind == "self-touch" else ("forearm",)
    return ContactEvent(tick, 0.01 * tick, kind, phase, contacts or (1,), links, AT, force=4.2, duration=0.8)


PRESSING = (event(28, "press", "began"), event(3, "touch", "began"))
RELEASED = (event(90, "release", "ended"), event(90, "press", "ended"), *PRESSING)


@pytest.fixture
def panel(qtbot):
    made = EventsPanel()
    qtbot.addWidget(made)
    made.resize(300, 300)
    made.show()
    return made


def frame(recent):
    return replace(touched(leaf_map()), recent=recent)


def words(panel):
    rows = panel.events.rowCount()
    return [panel.events.index(row).data().replace("\u202f", " ") for row in range(rows)]


def test_ongoing_event_is_listed_and_marked():
    first, second = event_lines(PRESSING)
    assert first.ongoing
    assert not second.ongoing
    assert (first.time, first.text) == ("0.3\u202fs", "Press on forearm, 4.2\u202fN")


def test_ended_event_is_listed_once():
    assert [line.text.replace("\u202f", " ") for line in event_lines(RELEASED)] == [
        "Release on forearm, 4.2 N, 0.8 s",
        "Press on forearm, 4.2 N, 0.8 s",
        "Touch on forearm",
    ]


def test_next_press_of_the_same_contact_is_a_new_event():
    again = (event(120, "press", "began"), *RELEASED)
    assert [line.ongoing for line in event_lines(again)] == [True, False, False, False]


def test_end_without_a_stored_beginning_is_listed():
    assert len(event_lines((event(90, "stroke", "ended"),))) == 1


def test_empty_panel_shows_an_explanation(panel):
    assert panel._note.isVisible()
    assert not panel.list.isVisible()
    panel.show_frame(frame(PRESSING))
    assert not panel._note.isVisible()
    assert panel.list.isVisible()


def test_list_follows_frames_in_both_directions_and_is_cleared(panel):
    panel.show_frame(frame(RELEASED))
    assert len(words(panel)) == 3
    panel.show_frame(frame(PRESSING))
    assert words(panel) == ["Press on forearm, 4.2 N", "Touch on forearm"], "a replay may go back"
    panel.show_frame(frame(()))
    assert words(panel) == [], "a session that was reset has no past"
    panel.show_frame(frame(PRESSING))
    panel.clear()
    assert words(panel) == []


def test_list_is_not_updated_without_new_events(qtbot, panel):
    panel.show_frame(frame(PRESSING))
    with qtbot.assertNotEmitted(panel.events.modelReset):
        panel.show_frame(frame(tuple(PRESSING)))


def test_scrolled_list_is_not_moved_by_new_lines(qtbot, panel):
    many = tuple(event(tick, "touch", "began", tick) for tick in range(60, 0, -1))
    panel.show_frame(frame(many))
    bar = panel.list.verticalScrollBar()
    qtbot.waitUntil(lambda: bar.maximum() > 0)
    assert bar.value() == 0
    panel.show_frame(frame((event(61, "touch", "began", 61), *many)))
    assert bar.value() == 0, "the newest is in sight"
    bar.setValue(20)
    panel.show_frame(frame((event(62, "touch", "began", 62), *many)))
    assert bar.value() > 0


def test_lines_are_drawn_and_read_aloud(panel):
    panel.show_frame(frame(PRESSING))
    blank = panel.list.grab().toImage()
    panel.show_frame(frame(RELEASED))
    drawn = panel.list.grab().toImage()
    assert blank != drawn
    index = panel.events.index(0)
    assert index.data(Qt.ItemDataRole.AccessibleTextRole).replace("\u202f", " ").endswith("at 0.9 s")
    assert panel.events.data(panel.events.index(-1)) is None
    assert panel.events.rowCount(index) == 0, "lines have no lines of their own"


@pytest.mark.long
def test_every_event_is_logged_live_and_in_replay_even_if_few_frames_are_shown(window, tmp_path):
    """A tap between two pictures is not missed; the same lines come back from a file; a reset clears them."""
    live = window.live
    log = window.column["events"]
    live.recording.start(tmp_path / "tap.mcap")
    window.presenters.touch.press(live.prepared.skin.taxel_point(70))
    live.runner.run_for(0.2)
    window.presenters.touch.release()
    live.runner.run_for(0.2)
    live.pump()
    lines = words(log)
    assert [line.split(" ")[0] for line in lines] == ["Release", "Tap", "Touch"]
    live.recording.stop()
    live.open_recording(tmp_path / "tap.mcap")
    live.replay.seek(0.195)
    assert words(log) == lines[2:]
    live.replay.seek(0.4)
    assert words(log) == lines
    live.replay.leave()
    window.action("reset").trigger()
    live.pump()
    assert words(log) == []
