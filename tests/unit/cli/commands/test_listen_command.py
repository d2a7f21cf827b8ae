"""``listen``: a file or a port of readings is received, told of and recorded, without a window."""

from __future__ import annotations

import io
import json
import os
import re
import signal
import socket
import threading
import time
from contextlib import redirect_stderr
from dataclasses import dataclass, field

import numpy as np
import pytest

from tactile_maps.cli.commands import listen
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.recording.player import open_recording
from tactile_maps.tactile.press import press_skin
from tactile_widgets.__main__ import main
from tests.support.touch import bar, bar_map, bar_skin

PATIENCE = 60.0


@pytest.fixture(scope="module")
def skin(tmp_path_factory):
    path = tmp_path_factory.mktemp("skin") / "bar.npz"
    save_map(bar_map(), path)
    return str(path)


@pytest.fixture
def readings(tmp_path):
    """A file of 30 readings in counts, touched in the last ten."""
    path = tmp_path / "readings.csv"
    touched = 0.01 * press_skin(bar_skin(), bar_skin().taxel_point(30), force=3.0)
    rows = [20 + (touched if number >= 20 else 0 * touched) for number in range(30)]
    lines = [",".join(map(str, [0.01 * number, number, *row])) for number, row in enumerate(rows) if number != 5]
    path.write_text("\n".join(["time,sequence," + ",".join(map(str, range(60))), *lines, "oh,30", ""]))
    return str(path)


def test_a_file_is_told_of_in_figures(readings, skin, capsys, tmp_path):
    target = str(tmp_path / "felt.mcap")
    assert main(["listen", readings, "--skin", skin, "--tare", "10", "-o", target, "--json"]) == 0
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert (found["received"], found["lost"], found["malformed"], found["shown"]) == (29, 1, 1, 29)
    assert (found["contacts"], found["unheard"], found["tared"], found["calibrated"]) == (1, 0, True, False)
    assert "1 packets could not be understood" in captured.err
    assert len(open_recording(target)) == 29
    assert main(["replay", target, "--verify", "--json"]) == 1, "nothing was compared"
    replayed = json.loads(capsys.readouterr().out)
    assert (replayed["complete"], replayed["identical"], replayed["measured"]) == (True, None, readings)


@pytest.mark.parametrize(("threshold", "contacts"), [("10", 1), ("100000", 0)])
def test_threshold_is_in_the_unit_shown_and_recorded(readings, skin, capsys, tmp_path, threshold, contacts):
    """The peak of the touch is about 5,000 counts."""
    target = str(tmp_path / "felt.mcap")
    arguments = ["listen", readings, "--skin", skin, "--tare", "10", "--threshold", threshold, "-o", target, "--json"]
    assert main(arguments) == 0
    assert json.loads(capsys.readouterr().out)["contacts"] == contacts
    assert open_recording(target).runtime_settings_at(0).reading.threshold == 1e3 * float(threshold)


@pytest.mark.parametrize("threshold", ["0", "-1", "nan", "2e8", "high"])
def test_an_impossible_threshold_is_named(readings, skin, capsys, threshold):
    assert main(["listen", readings, "--skin", skin, f"--threshold={threshold}"]) == 2
    assert "--threshold" in capsys.readouterr().err


def test_a_weight_calibrates_and_is_kept(readings, skin, capsys, tmp_path):
    kept = str(tmp_path / "gains.csv")
    weigh = ["--tare", "10", "--weight", "0.30591", "--save-calibration", kept]
    assert main(["listen", readings, "--skin", skin, *weigh]) == 1
    assert "is not at rest" in capsys.readouterr().err
    weigh += ["--weight-seconds", "0.08"]
    assert main(["listen", readings, "--skin", skin, *weigh]) == 0
    assert "forces unknown" in capsys.readouterr().out
    assert main(["listen", readings, "--skin", skin, "--tare", "10", "--calibration", kept, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["calibrated"]
    assert abs(found["max_force_N"] - 3.0) < 0.05


def test_failed_weighing_does_not_replace_a_recording(readings, skin, capsys, tmp_path):
    target = tmp_path / "felt.mcap"
    new = tmp_path / "felt.new.mcap"
    target.write_bytes(b"precious")
    words = ["listen", readings, "--skin", skin, "--tare", "10", "-o", str(target), "--overwrite"]
    assert main([*words, "--weight", "0.30591"]) == 1
    said = capsys.readouterr().err
    assert "is not at rest" in said
    assert f"{target} is unchanged; the new recording up to here is {new}" in said
    assert target.read_bytes() == b"precious"
    assert len(open_recording(new)) == 29
    assert main(words) == 0
    assert len(open_recording(target)) == 29


def test_packets_of_a_port_are_received_for_so_long(skin, capsys):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    stop = threading.Event()

    def send():
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            number = 0
            while not stop.wait(0.01):
                values = np.zeros(61)
                packet = encode_binary(Reading(0.01 * number, values, ids=np.arange(61), sequence=number))
                sender.sendto(packet, ("127.0.0.1", port))
                number += 1

    thread = threading.Thread(target=send)
    thread.start()
    try:
        assert main(["listen", f"udp://127.0.0.1:{port}", "--skin", skin, "--for", "0.5", "--json"]) == 0
    finally:
        stop.set()
        thread.join()
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert found["listened_s"] >= 0.5
    assert found["shown"] > 1
    assert found["unknown"] == ["60"]
    assert "taxels that the skin does not have: 60" in captured.err


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["nothing://here"], 2, "unknown kind of source"),
        (["udp://0.0.0.0:9870"], 2, "set a token"),
        (["udp://0.0.0.0:9870", "--token", "long enough"], 2, "--remote"),
        (["none.csv"], 1, "none.csv"),
        (["udp://127.0.0.1:0", "--for", "0.05"], 1, "no reading came"),
        (["udp:", "--save-calibration", "x.csv"], 2, "--weight"),
        (["udp:", "--send", "udp://127.0.0.1:9"], 2, "Add --controller hold_force, hybrid or another that gives veloc"),
        (["udp:", "--send", "udp://127.0.0.1:9"], 2, "and --token, which the sender must put into every packet"),
        (["udp://239.1.1.1:9870"], 2, "readings cannot be received at a multicast or broadcast address"),
        (["udp://127.0.0.1:99999"], 2, "invalid port number (found: 99999). Give a whole number from 1 to"),
    ],
)
def test_what_cannot_be_is_one_message(words, code, said, skin, capsys):
    assert main(["listen", *words, "--skin", skin]) == code
    message = capsys.readouterr().err
    assert said in message
    assert "Traceback" not in message


def test_the_port_that_is_chosen_for_port_0_is_printed(skin, capsys):
    assert main(["listen", "udp://127.0.0.1:0", "--for", "0.05", "--skin", skin]) == 1
    first, *_ = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"tactile-maps: listening at udp://127\.0\.0\.1:[1-9]\d*", first)


def test_a_source_without_readings_leaves_no_recording(skin, tmp_path, capsys):
    path = tmp_path / "x.mcap"
    assert main(["listen", "udp://127.0.0.1:0", "--for", "0.05", "--skin", skin, "-o", str(path)]) == 1
    assert "no reading came" in capsys.readouterr().err
    assert not path.exists()


def test_wanted_motion_is_sent_within_its_limits_and_ends_with_a_stop(skin, capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(listen, "CLOCK", lambda: 0.01 * time.monotonic())  # no command is late on a busy machine
    robot = tmp_path / "bar.xml"
    readings = tmp_path / "posture.csv"
    robot.write_text(bar().mjcf)
    pressed = press_skin(bar_skin(), bar_skin().taxel_point(30), force=6.0)
    rows = [[0.01 * number, *(pressed if number > 5 else 0 * pressed), 0.3] for number in range(30)]
    head = f"# unit: Pa\ntime,{','.join(map(str, range(60)))},joint:hinge\n"
    readings.write_text(head + "".join(",".join(map(str, row)) + "\n" for row in rows))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind(("127.0.0.1", 0))
        driver.settimeout(10)
        to = f"udp://127.0.0.1:{driver.getsockname()[1]}"
        words = ["--robot", str(robot), "--skin", skin, "--mode", "kPa", "--controller", "hold_force"]
        words += ["--send", to, "--max-speed", "0.01", "--json"]
        assert main(["listen", str(readings), *words]) == 0
        found = json.loads(capsys.readouterr().out)["motion"]
        packets = [json.loads(driver.recv(4096)) for _ in range(2 + found["sent"] + 3)][2:]
    assert (found["controller"], found["sent"], found["stopped"]) == ("hold_force", 30, "switched off")
    assert found["slowed"] > 10
    speeds = [packet["velocities"]["hinge"] for packet in packets]
    assert max(speeds) == pytest.approx(0.01)
    assert [packet["state"] for packet in packets[-3:]] == ["stopped"] * 3
    assert speeds[:5] == [0.0] * 5


class Said(io.StringIO):
    """Standard error; ``waits`` is set once the program says that it waits for readings."""

    def __init__(self):
        super().__init__()
        self.waits = threading.Event()

    def write(self, text):
        if "waiting for the first reading" in text:
            self.waits.set()
        return super().write(text)


TOKEN = "a token of ours"


@dataclass
class BarSender:
    """A board with the touched bar. Time is simulated: it goes on by 10 ms with each reading.

    Attributes:
        packets: Those for the robot; once there are some, each reading waits for one more, for a second at most.
        now: Simulated time [s].
    """

    packets: list = field(default_factory=list)
    now: float = 1000.0

    def run(self, port, begin, end):
        """Send readings to ``port``, from ``begin`` until ``end``."""
        values = press_skin(bar_skin(), bar_skin().taxel_point(30), force=2.0)
        number = 0
        assert begin.wait(PATIENCE)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as opened:
            while not end.wait(0.01):
                self.now += 0.01
                reading = Reading(self.now, values, Unit.PASCAL, joints={"hinge": 0.3}, sequence=number)
                before = len(self.packets)
                opened.sendto(encode_binary(reading, token=TOKEN), ("127.0.0.1", port))
                number += 1
                deadline = time.monotonic() + 1.0
                while before and len(self.packets) == before and time.monotonic() < deadline and not end.wait(0.001):
                    pass


def drive(driver, packets):
    """Receive packets for the robot, and press Ctrl-C after the fifth."""
    assert [json.loads(driver.recv(4096))["why"] for _ in range(2)] == ["nothing is sent yet"] * 2
    while not packets or packets[-1]["state"] != "stopped":
        packets.append(json.loads(driver.recv(4096)))
        if len(packets) == 5:
            os.kill(os.getpid(), signal.SIGINT)


def test_sending_waits_for_a_sender_that_starts_later_and_records_meanwhile(skin, capsys, tmp_path, monkeypatch):
    robot = tmp_path / "bar.xml"
    recorded = tmp_path / "felt.mcap"
    said = Said()
    end = threading.Event()
    board = BarSender()
    packets = board.packets
    monkeypatch.setattr(listen, "CLOCK", lambda: board.now)
    robot.write_text(bar().mjcf)
    recorded.write_bytes(b"replaced")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver, redirect_stderr(said):
        driver.bind(("127.0.0.1", 0))
        driver.settimeout(PATIENCE)
        words = ["--robot", str(robot), "--skin", skin, "--controller", "hold_force", "--for", str(PATIENCE)]
        words += [
            "--send",
            f"udp://127.0.0.1:{driver.getsockname()[1]}",
            "--json",
            "-o",
            str(recorded),
            "--overwrite",
            "--token",
            TOKEN,
        ]
        threads = [
            threading.Thread(target=board.run, args=(port, said.waits, end)),
            threading.Thread(target=drive, args=(driver, packets)),
        ]
        for thread in threads:
            thread.start()
        try:
            assert main(["listen", f"udp://127.0.0.1:{port}", *words]) == 0
        finally:
            end.set()
            for thread in threads:
                thread.join()
    found = json.loads(capsys.readouterr().out)
    motion = found["motion"]
    assert (motion["stopped"], motion["detail"]) == ("switched off", "")
    assert motion["sent"] == len(packets) - 1 >= 5
    assert {packet["state"] for packet in packets[:-1]} == {"moving"}
    assert motion["latency_ms"]["median"] <= motion["latency_ms"]["p99"] <= motion["latency_ms"]["largest"]
    assert motion["deadline_ms"] == pytest.approx(50)
    lines = [line for line in said.getvalue().splitlines() if "motion" in line]
    assert lines[0] == "tactile-maps: no motion is sent yet: waiting for the first reading"
    assert lines[-1] == "tactile-maps: motion is sent, at most 0.2 rad/s (m/s for slides) in each joint"
    assert found["left_out"] == 0
    assert len(open_recording(recorded)) >= motion["sent"]
    assert not (tmp_path / "felt.new.mcap").exists(), "Ctrl-C is the normal end of listening"


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--send", "udp://192.0.2.1:9"], 2, "--remote"),
        (["--send", "carrier-pigeon://127.0.0.1"], 2, "udp://HOST:PORT"),
        (["--send", "http://127.0.0.1"], 2, "motion cannot be sent to such an address (found: http://127.0.0.1)"),
        (["--send", "udp://224.0.0.1:9", "--remote"], 2, "motion can only be sent to one driver (found: 224.0.0.1)"),
        (["--send", "udp://255.255.255.255:9", "--remote"], 2, "motion can only be sent to one driver"),
        (["--send", "udp://[ff02::1]:9", "--remote"], 2, "motion can only be sent to one driver"),
        (["--send", "udp://127.0.0.1:9?key=1"], 2, "the address has an unknown parameter (found: key)"),
        (["--send", "udp://no.such.host.invalid:9", "--remote", "--controller", "hybrid"], 1, "cannot be used"),
        (["--send", "udp://127.0.0.1:9"], 2, "this controller gives no motion to send (found: impedance)"),
        (["--send", "udp://127.0.0.1:9", "--controller", "hybrid", "--mode", "raw"], 2, "calibrated readings"),
        (["--send", "udp://127.0.0.1:9", "--controller", "hybrid", "--mode", "baseline"], 2, "calibrated readings"),
        (
            ["--send", "udp://127.0.0.1:9", "--max-speed", "50"],
            2,
            "--max-speed: the speed limit is out of range (found: 50 rad/s). Choose 0.001 to 1 rad/s",
        ),
        (["--send", "udp://127.0.0.1:9", "--max-speed", "0"], 2, "(found: 0 rad/s). Choose 0.001 to 1 rad/s"),
        (
            ["--send", "udp://127.0.0.1:9", "--max-force", "nan"],
            2,
            "--max-force: the force limit is out of range (found: nan N). Choose 1 to 200 N",
        ),
        (["--controller", "none"], 2, "--controller: unknown controller (found: none). Choose one of: impedance"),
        (["--max-speed", "0.1"], 2, "--max-speed: this option has no effect without --send"),
        (["--max-force", "5"], 2, "--max-force: this option has no effect without --send"),
        (["--weight-seconds", "1"], 2, "--weight-seconds: this option has no effect without --weight"),
        (["--weight-seconds", "100", "--weight", "1"], 2, "--weight-seconds: the time is out of range"),
        (["--weight", "2000"], 2, "--weight: the weight is out of range"),
        (["--tare", "0"], 2, "--tare: the number of readings is out of range"),
    ],
)
def test_motion_that_cannot_be_sent_is_one_message(words, code, said, readings, skin, capsys):
    assert main(["listen", readings, "--skin", skin, *words]) == code
    message = capsys.readouterr().err
    assert said in message
    assert "Traceback" not in message


def test_recording_to_a_file_without_a_name_is_refused(readings, skin, capsys):
    assert main(["listen", readings, "--skin", skin, "-o", ""]) == 2
    assert "argument -o/--output: the name of the file is empty" in capsys.readouterr().err
