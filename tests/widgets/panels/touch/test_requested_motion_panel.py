"""Requested motion of a measured robot: shown while visible, sent while the switch is on, with the reason of a stop."""

from __future__ import annotations

import json
import socket
from contextlib import suppress

import numpy as np
import pytest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QLineEdit, QMessageBox, QPushButton

from tactile_maps.core.errors import LiveError
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import MotionLimits
from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.recording.player import open_recording
from tactile_maps.tactile.press import press_skin
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tactile_widgets.panels.touch.requested_motion_panel import RequestedMotionPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.live.channels.test_tare import PRESSED, during, readings
from tests.support.touch import bar_skin, prepared_bar
from tests.widgets.support.mouse import left_click


@pytest.fixture
def driver():
    """A robot's driver on this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
        opened.bind(("127.0.0.1", 0))
        opened.settimeout(10)
        yield opened


@pytest.fixture(scope="module")
def prepared():
    return prepared_bar()


@pytest.fixture
def panel(window_again, tmp_path):
    """Readings of the bar, touched with 6 N from the sixth on and 20 N in the end; five have been taken.

    ``panel.connect`` replaces them by others: multiples of pressures [Pa].
    """
    panel = window_again.column.get(RequestedMotionPanel)
    panel.set_folded(False)
    clock = [0.0]

    def connect(factors, pressed, **settings):
        rows = [[0.01 * number, *(factor * pressed), 0.3] for number, factor in enumerate(factors)]
        path = tmp_path / "readings.csv"
        head = f"# unit: Pa\ntime,{','.join(map(str, range(len(pressed))))},joint:hinge\n"
        path.write_text(head + "".join(",".join(map(str, row)) + "\n" for row in rows))
        window_again.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None), **settings))
        live = window_again.live.live_input
        live._motion._make_output = lambda settings: MotionOutput(
            live.session,
            settings,
            live.connection.ages,
            clock=lambda: clock[0],  # independent of the machine's load
        )

    def read(count):
        for _ in range(count):
            clock[0] += 0.05
            window_again.live.runner.run_for(0.05)
        window_again.live.pump()
        panel.refresh()

    panel.connect = connect
    panel.read = read
    one_newton = press_skin(bar_skin(), bar_skin().taxel_point(30), force=1.0)
    panel.connect([0.0] * 6 + [6.0] * 20 + [20.0] * 4, one_newton)
    panel.read(5)
    yield panel
    window_again.live.connection.close()


def text(panel, name):
    return panel.findChild(QLabel, f"motion-{name}").text().replace("\u202f", " ")


def choose(panel, title):
    box = panel.findChild(QComboBox, "motion-controller")
    box.setCurrentIndex(box.findText(title))
    box.activated.emit(box.currentIndex())


def arm(panel):
    left_click(panel.findChild(QPushButton, "motion-arm"))


def press(panel):
    """Start sending, armed first, or stop it."""
    if not panel.findChild(QPushButton, "motion-send").isEnabled():
        arm(panel)
    left_click(panel.findChild(QPushButton, "motion-send"))


def settle():
    """Lay out labels that wrap, each level of the layout in its own pass."""
    for _ in range(4):
        QApplication.processEvents()


def test_motion_is_sent_only_once_armed_and_is_disarmed_by_each_end(panel, driver, window_again):
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    switch = panel.findChild(QPushButton, "motion-send")
    left_click(switch)
    assert not switch.isChecked()
    assert text(panel, "sent") == ""

    def resume():
        window_again.live.set_paused(paused=False)

    ends = (
        (lambda: press(panel), lambda: None),
        (lambda: choose(panel, "Hold force"), lambda: None),
        (lambda: window_again.live.set_paused(paused=True), resume),
        (window_again.live.connection.close, lambda: None),
    )
    for end, after in ends:
        arm(panel)
        assert switch.isEnabled()
        assert not switch.isChecked(), "armed, but nothing is sent"
        left_click(switch)
        panel.read(2)
        assert switch.isChecked()
        assert text(panel, "force") == "6.0 N"
        end()
        after()
        assert not switch.isChecked()
        assert not switch.isEnabled()


@pytest.fixture
def recording(window_again, panel, tmp_path):
    """A recording of the panel's readings; fewer readings are left."""
    live = window_again.live
    live.recording.start(tmp_path / "felt.mcap")
    panel.read(3)
    live.recording.stop()
    return open_recording(tmp_path / "felt.mcap")


@pytest.mark.parametrize("mode", ["pause", "replay"])
def test_motion_can_neither_be_armed_nor_sent_during_a_pause_or_replay(panel, driver, window_again, recording, mode):
    live = window_again.live
    address = f"udp://127.0.0.1:{driver.getsockname()[1]}"
    panel.findChild(QLineEdit, "motion-address").setText(address)
    choose(panel, "Hold force")
    switch, armed = (panel.findChild(QPushButton, f"motion-{name}") for name in ("send", "arm"))
    press(panel)
    panel.read(2)
    assert text(panel, "sent").startswith("Sending: ")
    received(driver)
    if mode == "pause":
        live.set_paused(paused=True)
        why = "The readings are paused. Press Play to arm."
    else:
        live.show_player(recording)
        why = "A recording is shown. Press Back to live to arm."
    assert [packet["why"] for packet in received(driver)] == ["the readings were paused"] * 3
    stopped, reason = text(panel, "sent").split("\n")[0], text(panel, "sent").split("\n")[-1]
    assert stopped.startswith("Stopped: the readings were paused. ")
    assert reason == why
    assert armed.toolTip() == switch.toolTip() == why
    assert [message.text for message in window_again.notification_bar.messages if message.fault] == []
    left_click(armed)
    panel.arm()
    assert not armed.isChecked()
    left_click(switch)
    assert (armed.isChecked(), switch.isChecked(), armed.isEnabled(), switch.isEnabled()) == (False,) * 4
    with pytest.raises(LiveError, match="the readings are paused"):
        live.live_input.send_motion(address, MotionLimits())
    if mode == "pause":
        live.set_paused(paused=False)
    else:
        live.replay.leave()
    panel.read(3)
    assert received(driver) == [], "the robot moved without being armed again"
    assert armed.isEnabled()
    assert "arm" not in text(panel, "sent")
    assert "paused" not in armed.toolTip() + switch.toolTip()
    press(panel)
    panel.read(1)
    assert [packet["state"] for packet in received(driver)] == ["stopped", "stopped", "moving"]


@pytest.mark.long
def test_requested_motion_is_shown_without_being_sent(panel, driver):
    assert "no desired motion" in text(panel, "notes")
    choose(panel, "Hold force")
    panel.read(15)
    assert text(panel, "joints").startswith("hinge +0.0")
    assert text(panel, "force") == "6.0 N"
    assert text(panel, "sent") == ""
    driver.setblocking(False)
    with pytest.raises(BlockingIOError):
        driver.recv(4096)


def test_switch_does_not_move_when_it_is_armed(panel):
    switch, armed = (panel.findChild(QPushButton, f"motion-{name}") for name in ("send", "arm"))
    armed.setStyleSheet("min-width: 0")  # the width of the text, as in the theme
    settle()
    before = switch.geometry()
    left_click(armed)
    settle()
    assert armed.isChecked()
    assert switch.geometry() == before
    armed.setStyleSheet("")


def test_buttons_do_not_move_while_texts_come_and_go(panel, driver, window_again):
    """The page is scrolled to its end, where a text that became shorter would move it."""
    window_again.resize(1366, 768)
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    page = window_again.column.page_of(panel)
    window_again.column.reveal(panel)
    armed = panel.findChild(QPushButton, "motion-arm")
    notes = panel.findChild(QLabel, "motion-notes")
    assert "no desired motion" in notes.text()

    def place():
        settle()
        return armed.mapTo(window_again, armed.rect().topLeft())

    place()
    page.verticalScrollBar().setValue(page.verticalScrollBar().maximum())
    before = place()
    assert armed.visibleRegion().boundingRect() == armed.rect()
    choose(panel, "Hold force")
    for _ in range(8):
        panel.read(1)
        assert place() == before
    assert notes.text() == ""
    press(panel)
    assert place() == before
    panel.read(25)
    assert "Stopped: " in text(panel, "sent")
    assert place() == before


def test_stop_is_reported_in_a_message_until_motion_is_sent_again(panel, driver, window_again):
    def messages():
        return [(message.text, message.fault) for message in window_again.notification_bar.messages]

    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    press(panel)
    panel.read(3)
    press(panel)
    assert text(panel, "sent").startswith("Stopped: switched off.")
    assert messages() == [], "stopped by the user"
    press(panel)
    panel.read(30)
    assert "passed the limit of force" in text(panel, "sent")
    ((words, fault),) = messages()
    assert words.startswith("Sending to the robot stopped: a contact passed the limit of force (")
    assert fault
    panel.refresh()
    assert len(messages()) == 1
    press(panel)
    assert messages() == []


@pytest.mark.long
def test_switch_starts_sending_and_a_strong_contact_ends_it(panel, driver):
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    switch = panel.findChild(QPushButton, "motion-send")
    place = switch.mapTo(panel, switch.rect().topLeft())
    press(panel)
    assert text(panel, "sent") == "Waiting for the first reading. Nothing is sent yet."
    assert switch.isChecked()
    panel.read(10)
    assert switch.isChecked()
    assert text(panel, "sent").startswith("Sending: ")
    assert "Sent after the reading: median" in text(panel, "sent")
    assert not panel.findChild(QLineEdit, "motion-address").isEnabled()
    panel.read(20)
    assert not switch.isChecked()
    assert "passed the limit of force" in text(panel, "sent")
    assert switch.mapTo(panel, switch.rect().topLeft()) == place
    states = []
    while states[-3:] != ["stopped"] * 3:
        packet = json.loads(driver.recv(4096))
        states.append(packet["state"])
        moved = packet["velocities"]["hinge"]
        assert np.isfinite(moved)
    assert states.count("moving") >= 5


@pytest.mark.long
def test_user_or_leaving_the_session_ends_sending(panel, driver, window_again):
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    for end in (lambda: press(panel), window_again.live.connection.close):
        press(panel)
        panel.read(2)
        end()
        found = [json.loads(driver.recv(4096)) for _ in range(4)]
        while found[-1]["state"] == "moving" or len(found) < 4:
            found.append(json.loads(driver.recv(4096)))
        while [packet["state"] for packet in found[-3:]] != ["stopped"] * 3:
            found.append(json.loads(driver.recv(4096)))
        assert found[-1]["why"] == "switched off"
    assert panel.isHidden()


def test_arming_after_a_doubtful_tare_asks_first(panel, window_again, tmp_path):
    """The skin is touched during all of a tare, then released; a second tare is clean."""

    def question():
        return next((box for box in window_again.findChildren(QMessageBox) if box.isVisible()), None)

    def press_in_question(name):
        box = question()
        left_click(next(button for button in box.buttons() if button.text().replace("&", "") == name))
        QApplication.processEvents()
        assert question() is None

    rows = readings(during(0, 60, readings=200))
    lines = [",".join(map(str, [0.01 * number, *row, 0.3])) for number, row in enumerate(rows)]
    head = f"time,{','.join(map(str, range(60)))},joint:hinge"
    (tmp_path / "touched.csv").write_text("\n".join([head, *lines, ""]))
    live = window_again.live
    live.connection.open(LiveInputSettings(str(tmp_path / "touched.csv"), SourceOptions(speed=None), tare=50))
    panel.read(55)
    assert live.live_input.session.facts.held_in_tare
    switch, armed = (panel.findChild(QPushButton, f"motion-{name}") for name in ("send", "arm"))
    arm(panel)
    assert "something seems to have touched" in question().text()
    press_in_question("Cancel")
    assert not armed.isChecked()
    assert not switch.isEnabled()
    arm(panel)
    press_in_question("Arm anyway")
    assert armed.isChecked()
    assert switch.isEnabled()
    panel.read(20)
    assert live.live_input.session.facts.falling
    left_click(switch)
    assert "fall below their baseline" in question().text()
    assert not armed.isChecked()
    assert not switch.isChecked()
    press_in_question("Tare again")
    panel.read(60)
    facts = live.live_input.session.facts
    assert (facts.taring, facts.held_in_tare, facts.falling) == (False, (), False)
    assert not armed.isChecked()
    arm(panel)
    assert question() is None
    assert armed.isChecked()


def received(driver):
    """Packets that the driver has received."""
    driver.setblocking(False)
    packets = []
    with suppress(BlockingIOError):
        while True:
            packets.append(json.loads(driver.recv(4096)))
    return packets


@pytest.mark.parametrize(
    ("factors", "doubt"),
    [
        ([0.0] * 20 + [0.1] * 5 + [-1.0] * 70, "fall below their baseline"),
        ([1.0] * 100, "something seems to have touched"),
    ],
    ids=["while it is sent", "while it waits for the tare"],
)
def test_doubtful_tare_stops_sending_with_a_message_that_starts_another_tare(
    panel, driver, window_again, factors, doubt
):
    panel.connect(factors, 30 * PRESSED, tare=20)
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    switch, armed = (panel.findChild(QPushButton, f"motion-{name}") for name in ("send", "arm"))
    panel.read(1)
    press(panel)
    panel.read(18)
    assert switch.isChecked()
    assert text(panel, "sent") == "Waiting for the end of the tare. Nothing is sent yet."
    panel.read(15)
    assert not switch.isChecked()
    assert not armed.isChecked()
    assert "Stopped: the tare is doubtful (" in text(panel, "sent")
    packets = received(driver)
    assert [(packet["state"], packet.get("why")) for packet in packets[-3:]] == [
        ("stopped", "the tare is doubtful")
    ] * 3
    assert ("moving" in [packet["state"] for packet in packets]) is (factors[0] == 0)
    (message,) = [message for message in window_again.notification_bar.messages if message.fault]
    assert message.text.startswith("Sending to the robot stopped: the tare is doubtful (")
    assert doubt in message.text
    assert message.text.endswith("Leave the skin untouched and tare again; then arm and send again.")
    (again,) = message.remedies
    again.trigger()
    panel.read(51)
    assert received(driver) == [], "a stop does not end by itself"
    arm(panel)
    assert armed.isChecked(), "the skin did not change during this tare"
    left_click(switch)
    panel.read(1)
    assert switch.isChecked()


def test_other_machine_is_rejected_with_a_message(panel, window_again):
    panel.findChild(QLineEdit, "motion-address").setText("udp://192.0.2.1:9900")
    choose(panel, "Hold force")
    press(panel)
    assert "not enabled" in text(panel, "notes")
    assert not panel.findChild(QPushButton, "motion-send").isChecked()
    (message,) = window_again.notification_bar.messages
    assert message.fault
    assert message.text.startswith("Sending to the robot did not start: ")
    assert "not enabled" in message.text


def test_port_of_the_readings_is_rejected_with_a_message(panel, window_again):
    window_again.live.connection.close()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        address = f"udp://127.0.0.1:{free.getsockname()[1]}"
    window_again.live.connection.open(LiveInputSettings(address, SourceOptions(token="a token of ours")))
    panel.read(1)
    panel.findChild(QLineEdit, "motion-address").setText(address)
    choose(panel, "Hold force")
    press(panel)
    assert "the readings are received at this address" in text(panel, "notes")
    assert not panel.findChild(QPushButton, "motion-send").isChecked()


@pytest.mark.long
def test_folded_panel_computes_no_motion(panel):
    panel.set_folded(True)
    choose(panel, "Hold force")
    panel.read(10)
    assert text(panel, "joints") == "–"


def test_limits_entered_in_the_panel_are_sent(panel, driver):
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    panel._speed.show_number(0.01)
    panel._most_force.show_number(50.0)
    press(panel)
    panel.read(40)  # 20 N in the end
    press(panel)
    packets = received(driver)
    assert packets[-1]["why"] == "switched off"
    assert max(abs(packet["velocities"]["hinge"]) for packet in packets) == pytest.approx(0.01)


@pytest.mark.long
def test_missing_driver_is_named(panel, driver):
    panel.findChild(QLineEdit, "motion-address").setText(f"udp://127.0.0.1:{driver.getsockname()[1]}")
    choose(panel, "Hold force")
    driver.close()
    press(panel)
    assert "No program receives at the driver's address" in text(panel, "notes")
    assert not panel.findChild(QPushButton, "motion-send").isChecked()


def test_panel_fits_the_column_for_long_joint_names(panel):
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"
    label = panel.findChild(QLabel, "motion-joints")
    line = panel._elided("left_arm_shoulder_pitch_joint_of_the_second_robot", "+0.123\u202frad/s")
    assert "…" in line
    assert line.endswith(" +0.123\u202frad/s")
    assert label.fontMetrics().horizontalAdvance(line) <= label.width()
    label.setText(line + line)
    QApplication.sendPostedEvents()  # lay out, without a refresh by the panel's timer
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8
