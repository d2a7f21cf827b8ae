"""``listen``: a file or a port of readings is received, reported and recorded, without a window."""

from __future__ import annotations

import json
import re
import shlex
import socket
import threading
import time
from contextlib import suppress

import numpy as np
import pytest

from tactile_maps.cli.commands import listen
from tactile_maps.live.readings.readings import Reading
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.recording.player import open_recording
from tactile_maps.tactile.press import press_skin
from tactile_widgets.__main__ import main
from tests.live.channels.test_tare import PRESSED
from tests.support.touch import bar, bar_map, bar_skin


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


def test_readings_of_a_file_are_summarized_in_numbers(readings, skin, capsys, tmp_path):
    target = str(tmp_path / "felt.mcap")
    assert main(["listen", readings, "--skin", skin, "--tare", "10", "-o", target, "--json"]) == 0
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert (found["received"], found["lost"], found["malformed"], found["shown"]) == (29, 1, 1, 29)
    assert (found["contacts"], found["unheard"], found["tared"], found["calibrated"]) == (1, 0, True, False)
    assert found["contacts_at_once"] == 1
    assert "1 packet not decoded" in captured.err
    assert len(open_recording(target)) == 29
    assert main(["replay", target, "--verify", "--json"]) == 1, "nothing was compared"
    replayed = json.loads(capsys.readouterr().out)
    assert (replayed["complete"], replayed["identical"], replayed["measured"]) == (True, None, readings)


@pytest.mark.parametrize(("columns", "warned"), [(44, True), (45, False)])
def test_readings_of_fewer_than_three_quarters_of_the_taxels_are_questioned(columns, warned, skin, tmp_path, capsys):
    path = tmp_path / "other.csv"
    path.write_text(f"time,{','.join(map(str, range(columns)))}\n0{',20' * columns}\n0.1{',20' * columns}\n")
    assert main(["listen", str(path), "--skin", skin]) == 0
    words = f"only {columns} of the skin's 60 taxels; they may be of another skin. Name the skin or taxel file"
    assert (words in capsys.readouterr().err) is warned


def test_two_touches_of_a_skin_with_very_different_noise_are_two_contacts_after_a_tare_of_five_readings(
    tmp_path, capsys
):
    """The noise is 54 counts in the median and 320 at the 95th percentile, as on a real skin of 300 taxels."""
    random = np.random.default_rng(4)
    places = 0.008 * np.stack(np.meshgrid(np.arange(20), np.arange(15)), axis=-1).reshape(-1, 2)
    (tmp_path / "noisy.csv").write_text("x,y,z,nx,ny,nz\n" + "".join(f"{x},{y},0,0,0,1\n" for x, y in places))
    spread = 54 * np.exp(1.08 * random.standard_normal(300))
    touched = sum(3000 * np.exp(-(((places - at) / 0.01) ** 2).sum(axis=1)) for at in ([0.03, 0.03], [0.12, 0.08]))
    rows = [1e4 + spread * random.standard_normal(300) + (touched if number >= 30 else 0) for number in range(60)]
    lines = [",".join(map(str, [0.02 * number, *row])) for number, row in enumerate(rows)]
    for name, count, contacts in (("rest", 30, 0), ("touched", 60, 2)):
        path = tmp_path / f"{name}.csv"
        path.write_text("\n".join(["time," + ",".join(map(str, range(300))), *lines[:count]]))
        words = ["listen", str(path), "--skin", str(tmp_path / "noisy.csv"), "--robot", "none", "--tare", "5", "--json"]
        assert main(words) == 0
        assert json.loads(capsys.readouterr().out)["contacts"] == contacts


@pytest.mark.parametrize(("threshold", "contacts"), [("10", 1), ("100000", 0)])
def test_threshold_is_in_the_unit_shown_and_recorded(readings, skin, capsys, tmp_path, threshold, contacts):
    """The peak of the touch is about 5,000 counts."""
    target = str(tmp_path / "felt.mcap")
    arguments = ["listen", readings, "--skin", skin, "--tare", "10", "--threshold", threshold, "-o", target, "--json"]
    assert main(arguments) == 0
    assert json.loads(capsys.readouterr().out)["contacts"] == contacts
    assert open_recording(target).runtime_settings_at(0).reading.threshold == 1e3 * float(threshold)


def test_contacts_side_by_side_are_separated_or_joined_as_requested_and_recorded(tmp_path, capsys):
    """Two fingertips 2.5 pitches apart, whose taxels are connected."""
    random = np.random.default_rng(4)
    places = 0.004 * np.stack(np.meshgrid(np.arange(20), np.arange(15)), axis=-1).reshape(-1, 2)
    skin = tmp_path / "skin.csv"
    skin.write_text("x,y,z,nx,ny,nz\n" + "".join(f"{x},{y},0,0,0,1\n" for x, y in places))
    away = [np.linalg.norm(places - at, axis=1) for at in ([0.035, 0.03], [0.045, 0.03])]
    touched = sum(4000 * np.clip(1 - (one / 0.006) ** 2, 0, None) for one in away)
    rows = [1e4 + 5 * random.standard_normal(300) + (touched if number >= 50 else 0) for number in range(60)]
    path = tmp_path / "readings.csv"
    lines = (",".join(map(str, [0.02 * number, *row])) for number, row in enumerate(rows))
    path.write_text("\n".join(["time," + ",".join(map(str, range(300))), *lines]))
    for choice, contacts in (("separate", 2), ("joined", 1)):
        target = str(tmp_path / f"{choice}.mcap")
        words = ["listen", str(path), "--skin", str(skin), "--robot", "none", "--tare", "50", "-o", target, "--json"]
        assert main([*words, "--close-contacts", choice]) == 0
        assert json.loads(capsys.readouterr().out)["contacts_at_once"] == contacts
        assert open_recording(target).runtime_settings_at(0).reading.close_contacts == choice


def test_weight_calibrates_the_skin_and_is_recorded(readings, skin, capsys, tmp_path):
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
    message = capsys.readouterr().err
    assert "is not at rest" in message
    assert f"{target} is unchanged; the new recording up to here is {new}" in message
    assert target.read_bytes() == b"precious"
    assert len(open_recording(new)) == 29
    assert main(words) == 0
    assert len(open_recording(target)) == 29


def test_packets_are_received_for_the_requested_duration(skin, capsys):
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


def test_source_without_readings_prints_its_port_and_leaves_no_recording(skin, tmp_path, capsys):
    path = tmp_path / "x.mcap"
    assert main(["listen", "udp://127.0.0.1:0", "--for", "0.05", "--skin", skin, "-o", str(path)]) == 1
    first, *rest = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"tactile-maps: listening at udp://127\.0\.0\.1:[1-9]\d*", first)
    assert "no reading arrived" in "".join(rest)
    assert "values of only" not in "".join(rest), "one message is enough"
    assert not path.exists()


def test_file_without_a_valid_row_does_not_ask_for_a_sender(skin, tmp_path, capsys):
    path = tmp_path / "readings.csv"
    path.write_text("time,3\nnow,1\n")
    assert main(["listen", str(path), "--skin", skin]) == 1
    error = capsys.readouterr().err
    assert "no reading of the file can be used" in error
    assert "sender" not in error


def test_motion_for_a_file_is_sent_within_its_limits_and_ends_with_a_stop(skin, capsys, tmp_path, monkeypatch):
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
        words = ["--robot", str(robot), "--skin", skin, "--mode", "kPa", "--controller", "hold_force", "--json"]
        words += ["--send", f"udp://127.0.0.1:{driver.getsockname()[1]}", "--max-speed", "0.01"]
        assert main(["listen", str(readings), *words]) == 0
        found = json.loads(capsys.readouterr().out)["motion"]
        packets = [json.loads(driver.recv(4096)) for _ in range(2 + found["sent"] + 3)][2:]
    assert (found["controller"], found["sent"], found["stopped"]) == ("hold_force", 30, "switched off")
    assert found["slowed"] > 10
    speeds = [packet["velocities"]["hinge"] for packet in packets]
    assert (speeds[:5], max(speeds)) == ([0.0] * 5, pytest.approx(0.01))
    assert [packet["state"] for packet in packets[-3:]] == ["stopped"] * 3


def send_after_tare(factors, skin, folder, monkeypatch, *words):
    """Send motion for multiples of a touch, tared with the first 20; return the exit code and the driver's packets."""
    monkeypatch.setattr(listen, "CLOCK", lambda: 0.01 * time.monotonic())  # no command is late on a busy machine
    (folder / "bar.xml").write_text(bar().mjcf)
    rows = [[0.01 * number, *(30 * factor * PRESSED), 0.3] for number, factor in enumerate(factors)]
    head = f"# unit: Pa\ntime,{','.join(map(str, range(60)))},joint:hinge\n"
    (folder / "touch.csv").write_text(head + "".join(",".join(map(str, row)) + "\n" for row in rows))
    packets = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind(("127.0.0.1", 0))
        driver.setblocking(False)
        command = ["listen", str(folder / "touch.csv"), "--robot", str(folder / "bar.xml"), "--skin", skin, "--json"]
        command += ["--controller", "hold_force", "--tare", "20"]
        code = main([*command, "--send", f"udp://127.0.0.1:{driver.getsockname()[1]}", *words])
        with suppress(BlockingIOError):
            while True:
                packets.append(json.loads(driver.recv(4096)))
    assert [packet["state"] for packet in packets[-3:]] == ["stopped"] * 3
    return code, packets


def test_motion_is_not_sent_after_a_doubtful_tare_without_an_option(skin, capsys, tmp_path, monkeypatch):
    factors = [1.0] * 30
    code, packets = send_after_tare(factors, skin, tmp_path, monkeypatch)
    assert code == 1
    assert {packet["state"] for packet in packets} == {"stopped"}
    assert packets[-1]["why"] == "the tare is doubtful"
    captured = capsys.readouterr()
    assert "--send: no motion is sent: the tare is doubtful (found: During the tare something seems" in captured.err
    assert "--send-anyway" in captured.err
    code, packets = send_after_tare(factors, skin, tmp_path, monkeypatch, "--send-anyway")
    assert code == 0
    assert [packet["state"] for packet in packets].count("moving") == 11, "also with the reading that ends the tare"
    assert packets[-1]["why"] == "switched off"


def test_falling_readings_stop_motion_but_not_listening(skin, capsys, tmp_path, monkeypatch):
    code, packets = send_after_tare([0.0] * 20 + [0.1] * 5 + [-1.0] * 20, skin, tmp_path, monkeypatch)
    assert code == 0
    assert packets[-1]["why"] == "the tare is doubtful"
    captured = capsys.readouterr()
    found = json.loads(captured.out)
    assert found["readings"] == 45
    assert found["motion"]["stopped"] == "the tare is doubtful"
    assert "fall below their baseline" in found["motion"]["detail"]
    assert 5 <= found["motion"]["sent"] < 15


DRIVER = "FILE --send udp://127.0.0.1:9"


@pytest.mark.parametrize(
    ("words", "code", "problem"),
    [
        ("nothing://here", 2, "unknown kind of source"),
        ("udp://0.0.0.0:9870", 2, "set a token"),
        ("udp://0.0.0.0:9870 --token long-enough", 2, "--remote"),
        ("none.csv", 1, "none.csv"),
        ("udp: --save-calibration x.csv", 2, "--weight"),
        ("udp: --send udp://127.0.0.1:9", 2, "hold_force, hybrid or another that outputs veloc"),
        ("udp: --send udp://127.0.0.1:9", 2, "and --token, which the sender must include in every packet"),
        ("udp://239.1.1.1:9870", 2, "readings cannot be received at a multicast or broadcast address"),
        ("udp://127.0.0.1:99999", 2, "invalid port number (found: 99999). Give a whole number from 1 to"),
        ("FILE --send udp://192.0.2.1:9", 2, "--remote"),
        ("FILE --send carrier-pigeon://127.0.0.1", 2, "udp://HOST:PORT"),
        ("FILE --send http://127.0.0.1", 2, "motion cannot be sent to such an address (found: http://127.0.0.1)"),
        ("FILE --send udp://224.0.0.1:9 --remote", 2, "motion can only be sent to one driver (found: 224.0.0.1)"),
        ("FILE --send udp://255.255.255.255:9 --remote", 2, "motion can only be sent to one driver"),
        ("FILE --send udp://[ff02::1]:9 --remote", 2, "motion can only be sent to one driver"),
        ("FILE --send udp://127.0.0.1:9?key=1", 2, "the address has an unknown parameter (found: key)"),
        ("FILE --send udp://no.such.host.invalid:9 --remote --controller hybrid", 1, "unknown host"),
        ("FILE --send udp://no.such.host.invalid:9 --controller hybrid", 1, "unknown host"),
        ("udp://no.such.host.invalid:9", 1, "unknown host"),
        (DRIVER, 2, "this controller outputs no motion to send (found: impedance)"),
        (f"{DRIVER} --controller hybrid --mode raw", 2, "calibrated readings"),
        (f"{DRIVER} --controller hybrid --mode baseline", 2, "calibrated readings"),
        (
            f"{DRIVER} --max-speed 50",
            2,
            "--max-speed: the speed limit is out of range (found: 50 rad/s). Choose 0.001 to 1 rad/s",
        ),
        (f"{DRIVER} --max-speed 0", 2, "(found: 0 rad/s). Choose 0.001 to 1 rad/s"),
        (
            f"{DRIVER} --max-force nan",
            2,
            "--max-force: the force limit is out of range (found: nan N). Choose 1 to 200 N",
        ),
        ("FILE --controller none", 2, "--controller: unknown controller (found: none). Choose one of: impedance"),
        ("FILE --max-speed 0.1", 2, "--max-speed: this option has no effect without --send"),
        ("FILE --max-force 5", 2, "--max-force: this option has no effect without --send"),
        ("FILE --send-anyway", 2, "--send-anyway: this option has no effect without --send"),
        ("FILE --weight-seconds 1", 2, "--weight-seconds: this option has no effect without --weight"),
        ("FILE --weight-seconds 100 --weight 1", 2, "--weight-seconds: the time is out of range"),
        ("FILE --weight 2000", 2, "--weight: the weight is out of range"),
        ("FILE --tare 4", 2, "--tare: the number of readings is out of range (found: 4). Choose 5 to 100,000"),
        ("FILE -o ''", 2, "argument -o/--output: the name of the file is empty"),
        *((f"FILE --threshold={value}", 2, "--threshold") for value in ("0", "-1", "nan", "2e8", "high")),
    ],
)
def test_conflicting_options_give_one_message(words, code, problem, readings, skin, capsys):
    source, *options = shlex.split(words)
    assert main(["listen", readings if source == "FILE" else source, *options, "--skin", skin]) == code
    message = capsys.readouterr().err
    assert problem in message
    assert "Traceback" not in message
