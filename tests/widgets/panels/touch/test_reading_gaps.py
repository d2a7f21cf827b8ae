"""Readings of a real skin by UDP: gaps, doubtful tares, and arrows of unknown forces."""

from __future__ import annotations

import math
import socket

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QWidget

from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.live.sources.open import SourceOptions
from tactile_widgets.common.note_list import NoteList
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.support.simulated_clock import SimulatedClock
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import click_remedy, run


class Stream:
    """A connected sender. Each packet takes 0.1 s of the connection's clock, after which the panel is refreshed."""

    def __init__(self, window, sender):
        self.window = window
        self.clock = SimulatedClock()
        window.live.connection.open(LiveInputSettings("udp://127.0.0.1:0", SourceOptions(clock=self.clock)))
        self._address = ("127.0.0.1", window.live.live_input.connection.source.port)
        self._sender = sender
        self._number = 0
        self.panel = window.column.get(LiveInputPanel)
        self.wait(0.0)

    def send(self, values, count=1):
        for _ in range(count):
            self._number += 1
            reading = Reading(0.1 * self._number, np.asarray(values, float), Unit.COUNTS, sequence=self._number)
            self.send_packet(encode_binary(reading))

    def send_packet(self, packet):
        self._sender.sendto(packet, self._address)
        self.wait(0.1)

    def wait(self, seconds):
        self.clock.now += seconds
        run(self.window, 0.1)
        self.panel.refresh()

    @property
    def tare(self):
        return self.panel.findChild(QPushButton, "live-tare")

    @property
    def baseline(self):
        return self.panel.findChild(QLabel, "live-baseline").text()

    @property
    def state(self):
        return self.panel.findChild(QLabel, "live-state").text()

    @property
    def notes(self):
        return self.panel.findChild(NoteList, "live-notes")

    @property
    def messages(self):
        return [message.text for message in self.window.notification_bar.messages]


@pytest.fixture
def stream(window_again):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        yield Stream(window_again, sender)
    window_again.live.connection.close()
    assert not any(message.fault for message in window_again.notification_bar.messages)


@pytest.fixture
def untouched(window_again):
    return np.full(len(window_again.live.prepared.skin), 20.0)


def test_rejected_packets_are_reported_until_readings_arrive(stream, untouched):
    stream.window.resize(1366, 768)
    for number in range(10):
        stream.send_packet(f"no reading {number}".encode())
    (message,) = stream.messages
    assert message.startswith("No readings, because all packets are rejected: ")
    bar = stream.window.notification_bar
    QApplication.processEvents()
    assert bar.isVisible()
    assert bar.visibleRegion().boundingRect() == bar.rect(), "in view at this height"
    stream.send(untouched[:-7], 3)
    (message,) = stream.messages
    assert f"{len(untouched) - 7}" in message, "the current reason"
    assert f"{len(untouched) - 7}" in bar.findChild(QLabel, "message-text").text()
    bar.clear()
    stream.send_packet(b"no reading either")
    assert stream.messages == [], "reported once"
    stream.send(untouched)
    stream.wait(2.0)
    assert stream.messages == [], "silence is no failure"
    stream.send(untouched[:-7], 3)
    (message,) = stream.messages
    assert f"{len(untouched) - 7}" in message
    stream.send(untouched)
    assert stream.messages == []


@pytest.mark.parametrize("fitting", [False, True])
def test_state_reports_that_all_packets_are_rejected(stream, untouched, fitting):
    """Packets that cannot be decoded, and readings of another skin, which the connection receives."""
    stream.window.resize(1366, 768)
    stream.send(untouched, 3)
    assert stream.state == "Receiving"
    for _ in range(12):
        if fitting:
            stream.send(untouched[:-7])
        else:
            stream.send_packet(b"no reading")
    assert stream.state == "All packets are rejected"
    (note,) = [note for note in stream.notes.notes if note.fault]
    assert note.head == "Problem"
    assert stream.panel.findChild(QLabel, "live-state").toolTip() == note.text
    QApplication.processEvents()
    shown = stream.notes.viewport()
    assert shown.visibleRegion().boundingRect() == shown.rect(), "in view at this height"
    assert stream.notes.notes[0] == note
    stream.send(untouched)
    assert stream.state == "Receiving"


def test_problem_that_is_over_is_no_fault_and_states_its_age(stream, untouched):
    def faults():
        return [note.head for note in stream.notes.notes if note.fault]

    def earlier():
        return [note.head for note in stream.notes.notes if note.head.startswith("Earlier")]

    stream.send(untouched)
    stream.send_packet(b"no reading")
    stream.wait(60.0)
    assert faults() == ["Problem"], "no reading was used since"
    stream.send(untouched, 2)
    assert (faults(), earlier()) == ([], ["Earlier problem, 1\u202fmin ago"])
    stream.send_packet(b"no reading")
    stream.send(untouched)
    assert (faults(), earlier()) == (["Problem"], []), "just now"
    stream.wait(5.0)
    assert (faults(), earlier()) == ([], ["Earlier problem, less than 1\u202fmin ago"])


def test_rejected_packets_between_readings_are_not_reported(stream, untouched):
    for _ in range(5):
        stream.send(untouched)
        stream.send_packet(b"no reading")
    assert stream.messages == []


def test_recording_clock_shows_the_time_since_the_first_recorded_frame(stream, untouched, tmp_path, qtbot):
    window = stream.window
    stream.send(untouched, 5)
    window.live.recording.start(tmp_path / "skin.mcap")
    note = window.context.timeline._note
    stream.send(untouched, 12)
    recorder = window.live.recording.recorder
    qtbot.waitUntil(lambda: recorder.frames == 13)
    stream.send(untouched)
    assert note.text().endswith(("Recording &nbsp;0:01.2", "Recording &nbsp;0:01.3")), "the last frame may be queued"
    window.live.recording.stop()


def test_views_state_the_age_of_the_readings_until_others_arrive(stream, untouched):
    """At the upper left of both views, and by the edge of the map."""
    views = stream.window.views

    def shown():
        (word,) = {views.map.marks.state, views.robot.display.overlay._captions.state}
        corner = views.map.viewport().grab().toImage().pixelColor(2, 200).name()
        return word.text, corner == stream.window.theme.warning

    assert shown() == ("No readings yet", True)
    stream.send(untouched)
    assert shown() == ("", False)
    stream.wait(0.5)
    assert shown() == ("", False)
    stream.wait(2.0)
    assert shown() == ("No readings for 2\u202fs", True)
    stream.window.live.set_paused(paused=True)
    assert shown() == ("Paused", False)
    stream.window.live.set_paused(paused=False)
    stream.wait(200.0)
    assert shown() == ("No readings for 3\u202fmin", True)
    stream.wait(7200.0)
    assert shown() == ("No readings for 2\u202fh", True)
    stream.send(untouched)
    assert shown() == ("", False)
    stream.wait(2.0)
    stream.window.live.connection.close()
    assert shown() == ("", False)


def test_tare_without_readings_states_why_it_waits(stream, untouched):
    left_click(stream.tare)
    stream.wait(0.0)
    assert (stream.tare.text(), stream.tare.isEnabled()) == ("Waiting…", False)
    assert stream.baseline == "The tare waits for readings: none arrive."
    stream.send_packet(b"no reading")
    assert stream.baseline == "The tare waits for readings: all packets are rejected."
    stream.send(untouched)
    assert stream.tare.text() == "Taring…"
    assert stream.baseline == "Leave the skin untouched while its baseline is measured."
    stream.send(untouched, 49)
    assert (stream.tare.text(), stream.baseline) == ("Tare", "Tared.")


def test_weight_dialog_states_that_no_readings_arrive(stream, untouched):
    left_click(stream.panel.findChild(QPushButton, "live-weight"))
    dialog = stream.panel.weight

    def state():
        return dialog.findChild(QLabel, "weight-state").text()

    left_click(stream.tare)
    stream.wait(0.0)
    assert state() == "The tare waits for readings: none arrive."
    stream.send(untouched)
    assert state() == "Taring…"
    stream.send(untouched, 49)
    left_click(dialog.measure)
    assert state().startswith("Measuring, 2.0")
    stream.wait(2.0)
    assert state() == "The measurement waits for readings: none arrive."
    stream.send(untouched)
    assert state().startswith("Measuring, ")
    stream.panel.weight = None
    dialog.deleteLater()


def test_tare_of_a_touched_skin_is_questioned_until_one_follows_without_a_touch(stream):
    window = stream.window
    skin = window.live.prepared.skin
    points = window.live.prepared.map.taxel_points
    apart = np.linalg.norm(points - points[30], axis=1)
    random = np.random.default_rng(0)
    touch = np.round(4000 * np.exp(-((apart / 0.03) ** 2)))

    def tare(*pressed):
        for pressure in pressed:
            stream.send(2000 + random.normal(0, 1.5, len(skin)).round() + pressure * touch)
        stream.wait(0.0)

    left_click(stream.tare)
    tare(*[1.0] * 50)
    (message,) = window.notification_bar.messages
    assert (message.warning, message.fault, message.seconds) == (True, False, math.inf)
    assert skin.taxel_text(30) in message.text
    assert "taxels seemed touched during the tare: tare again." in stream.baseline
    label = stream.panel.findChild(QLabel, "live-baseline")
    assert skin.taxel_text(30) in label.toolTip()
    assert label.heightForWidth(label.width()) <= label.height()
    assert message.text.endswith("contacts there are hidden. Leave the skin untouched and tare again.")
    toast = window.notification_bar.findChild(QWidget, "message-bar")
    assert toast.grab().toImage().pixelColor(1, toast.height() // 2).name() == window.theme.warning
    click_remedy(window, "Tare again")
    assert stream.tare.text() == "Taring…"
    tare(*[0.0] * 20, *[1.0] * 20, *[0.0] * 10)
    (message,) = window.notification_bar.messages
    assert "A part of the tare was left out for " in message.text
    assert stream.baseline.endswith("touched during a part of the tare.")
    left_click(stream.tare)
    tare(*[0.0] * 49)
    assert window.notification_bar.messages == (message,), "until the tare is complete"
    tare(0.0)
    assert window.notification_bar.messages == ()
    assert stream.baseline == "Tared."


@pytest.mark.long
def test_arrows_of_unknown_forces_are_relative_to_the_strongest_and_fit(stream, untouched):
    """Contacts of up to 3,000 counts, whose sums over areas are tens of thousands."""
    window = stream.window
    window.resize(1366, 768)
    left_click(stream.tare)
    random = np.random.default_rng(0)
    count = len(untouched)
    stream.send(untouched, 50)
    touch = np.zeros(count)
    touch[random.choice(count, 60, replace=False)] = random.integers(300, 3000, 60)
    stream.send(untouched + touch, 3)
    display = window.robot_view.display
    display.draw_now()
    captions = display.overlay._captions
    assert captions.legend == "Arrow: relative to the strongest"
    assert captions.contacts > 5 >= len(captions.forces)
    arrows = display.actors.forces
    lengths = [np.linalg.norm(arrow[0] - arrow[1]) for arrow, _ in arrows]
    strengths = [region.force for _, region in arrows]
    assert strengths[0] == max(strengths) > 10_000
    np.testing.assert_allclose(lengths, max(lengths) * np.array(strengths) / max(strengths), rtol=1e-6)
    tails = [display.actors.viewpoint.pixels(arrow, display.size)[0] for arrow, _ in arrows]
    room = display.overlay.rect()
    assert all(room.contains(*np.round(tail).astype(int).tolist()) for tail in tails)
