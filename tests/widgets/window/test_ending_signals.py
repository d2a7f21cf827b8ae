"""A window that the system ends stops the robot and completes the recording first."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.recording.player import open_recording
from tactile_widgets.window.ending_signals import EndingSignals
from tests.support.touch import bar, bar_map

ROOT = Path(__file__).resolve().parents[3]
TOKEN = "a token of ours"
SECONDS = 200.0
PROGRAM = """
import sys
import time
from pathlib import Path
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication
from tactile_widgets.__main__ import main
from tactile_maps.live.motion.motion_sender import MotionLimits
from tactile_maps.live.sources.open import SourceOptions
from tactile_widgets.session.live_input import LiveInputSettings
from tactile_widgets.window.application import make_application
from tactile_widgets.window.main_window import MainWindow


def begin():
    (window,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow)]
    live = window.live
    if live.prepared is None:
        QTimer.singleShot(50, begin)
        return
    options = SourceOptions(token=sys.argv[1], clock=lambda: 0.1 * time.monotonic())
    live.connection.open(LiveInputSettings("udp://127.0.0.1:0", options))
    live.recording.start(Path("felt.mcap"))
    live.live_input.use_controller("hold_force")
    port.write_text(str(live.live_input.connection.source.port))
    send()


def send():
    (window,) = [one for one in QApplication.topLevelWidgets() if isinstance(one, MainWindow)]
    live = window.live.live_input
    if live.session.facts.readings < 3:
        QTimer.singleShot(10, send)
        return
    live.send_motion(sys.argv[2], MotionLimits())


port = Path("port")
if __name__ == "__main__":
    make_application()
    QTimer.singleShot(0, begin)
    sys.exit(main(["gui", "--robot", "bar.xml", "--skin", "bar.npz"]))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT])
def test_signal_is_reported_in_the_event_loop(qtbot, number):
    signals = EndingSignals()
    try:
        with qtbot.waitSignal(signals.arrived) as arrived:
            os.kill(os.getpid(), number)
    finally:
        signals.close()
    assert arrived.args == [number]
    assert signal.getsignal(number) == signal.SIG_DFL
    signals.deleteLater()


def test_ignored_hangup_does_not_end_the_window(qtbot):
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    signals = EndingSignals()
    try:
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signals.close()
        signal.signal(signal.SIGHUP, before)
        signals.deleteLater()


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_window_that_is_ended_stops_the_robot_and_completes_the_recording(tmp_path, number):
    (tmp_path / "bar.xml").write_text(bar().mjcf)
    save_map(bar_map(), tmp_path / "bar.npz")
    (tmp_path / "program.py").write_text(PROGRAM)
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind(("127.0.0.1", 0))
        driver.settimeout(0.01)
        address = f"udp://127.0.0.1:{driver.getsockname()[1]}"
        command = [sys.executable, "program.py", TOKEN, address]
        process = subprocess.Popen(command, cwd=tmp_path, env=environment, start_new_session=True)
        try:
            packets = feed(tmp_path / "port", driver, until=lambda found: found and found[-1]["state"] == "moving")
            os.killpg(process.pid, number)
            packets += feed(tmp_path / "port", driver, until=lambda found: len(found) >= 3 and is_stop(found[-3:]))
            assert process.wait(SECONDS) == 128 + number
        finally:
            process.kill()
            process.wait()
    assert [packet["why"] for packet in packets[-3:]] == ["switched off"] * 3
    assert open_recording(tmp_path / "felt.mcap").complete


def is_stop(packets) -> bool:
    return [packet["state"] for packet in packets] == ["stopped"] * 3


def feed(port, driver, *, until):
    """Send readings to the port that a file names, and return what the driver receives, until it is enough.

    The clocks of board and program run at a tenth of the speed, so that no reading is late on a busy machine.
    """
    found = []
    deadline = time.monotonic() + SECONDS
    number = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as board:
        while not until(found):
            assert time.monotonic() < deadline, found[-3:]
            if port.exists() and port.read_text():
                reading = Reading(0.1 * time.monotonic(), np.zeros(60), Unit.PASCAL, joints={"hinge": 0.3})
                board.sendto(encode_binary(reading, token=TOKEN), ("127.0.0.1", int(port.read_text())))
                number += 1
            try:
                found.append(json.loads(driver.recv(4096)))
            except TimeoutError:
                continue
    return found
