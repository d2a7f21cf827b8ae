"""``listen --send`` from the packets of a board to those at a robot's driver, over real sockets on the loopback.

Each trial runs the command until it moves the robot, then something happens, and the trial ends with Ctrl-C.

Time is simulated: each reading of the board is ``STEP`` later than the one before it, and the board waits for the
command that follows from a reading before it sends the next. While the board is silent, time waits for the command
loop. A busy machine makes a trial longer, and changes nothing else.
"""

from __future__ import annotations

import io
import json
import os
import random
import select
import signal
import socket
import threading
import time
from collections.abc import Callable
from contextlib import redirect_stderr
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from tactile_maps.cli.commands import listen
from tactile_maps.core.errors import LiveError
from tactile_maps.live.motion.driver_channel import check_not_source, driver_channel
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import encode_binary
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.recording.player import open_recording
from tactile_maps.tactile.press import press_skin
from tactile_widgets.__main__ import main
from tests.support.simulated_clock import SimulatedClock
from tests.support.touch import bar, bar_map, bar_skin

TOKEN = "token-of-this-test"
PATIENCE = 60.0
"""Longest time of a trial [s]."""
STEP = 0.004
"""Simulated time between two readings [s]."""
LONGEST_WAIT = 1.0
"""For so long [s] at most the board waits for the command that follows from a reading."""
MOVING = 10
LOOPBACK = "127.0.0.1"
SILENT = "no reading came in time, the readings are too old"
"""The age of the newest reading decides between the two."""


def pressed(*forces: float) -> np.ndarray:
    """Pressures of one contact for each force [N], far apart from each other."""
    skin = bar_skin()
    return sum(press_skin(skin, skin.taxel_point(30 - 25 * place), force=force) for place, force in enumerate(forces))


@dataclass
class Trial:
    """A board with the bar's skin, the program and the driver.

    Attributes:
        folder: Of the files.
        capsys: Takes what the program prints.
        values: Pressures that the board sends [Pa].
        joints: Positions that it sends.
        silent: True while it sends nothing.
        clock: Clock of the board [s].
        program_clock: Clock of the program.
        packets: All that reached the driver.
        code: Exit code of the program.
        result: What it printed with ``--json``.
        said: What it prints on standard error.
        start: The board sends nothing until this holds.
    """

    folder: object
    capsys: object
    values: np.ndarray = field(default_factory=lambda: pressed(2.0))
    joints: dict = field(default_factory=lambda: {"hinge": 0.3})
    silent: bool = False
    clock: Callable[[], float] | None = None
    program_clock: SimulatedClock = field(default_factory=SimulatedClock)
    packets: list = field(default_factory=list)
    code: int = -1
    result: dict = field(default_factory=dict)
    stderr: io.StringIO = field(default_factory=io.StringIO)
    start: Callable[[], bool] = lambda: True

    def __post_init__(self):
        (self.folder / "bar.xml").write_text(bar().mjcf)
        save_map(bar_map(), self.folder / "bar.npz")
        self.board, self.driver = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
        self.driver.bind((LOOPBACK, 0))
        self.driver.setblocking(False)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind((LOOPBACK, 0))
            self.port = free.getsockname()[1]
        self._sequence = 0
        self._over = threading.Event()
        self.clock = self.clock or (lambda: 1e9 + self.program_clock.now)

    def close(self):
        self.board.close()
        self.driver.close()

    def run(self, *words: str, act: Callable[[Trial], None] = lambda _: None, until=None, end=signal.SIGINT) -> None:
        """Run the command with more ``words``; ``act`` once the robot moves, and ``end`` it ``until`` something."""
        until = until or (lambda trial: trial.states[-3:] == ["stopped"] * 3)
        around = threading.Thread(target=self._around, args=(act, until, end))
        around.start()
        command = ["listen", f"udp://{LOOPBACK}:{self.port}", "--robot", str(self.folder / "bar.xml")]
        command += ["--skin", str(self.folder / "bar.npz"), "--controller", "hold_force", "--token", TOKEN, "--json"]
        command += ["--send", f"udp://{LOOPBACK}:{self.driver.getsockname()[1]}", "--for", str(PATIENCE)]
        try:
            with redirect_stderr(self.stderr):
                self.code = main([*command, *words])
        finally:
            self._over.set()
            around.join()
        printed = self.capsys.readouterr().out
        self.result = json.loads(printed.splitlines()[-1]) if self.code == 0 else {}

    @property
    def errors(self) -> str:
        """Standard error so far."""
        return self.stderr.getvalue()

    @property
    def states(self) -> list[str]:
        return [packet["state"] for packet in self.packets]

    @property
    def speeds(self) -> list[float]:
        return [packet["velocities"]["hinge"] for packet in self.packets if packet["state"] == "moving"]

    @property
    def stopped(self) -> str:
        """Reason for stopping, as sent to the driver and as printed."""
        last = self.packets[-3:]
        assert [packet["state"] for packet in last] == ["stopped"] * 3
        assert {tuple(packet["velocities"].items()) for packet in last} == {(("hinge", 0.0),)}
        assert {packet["why"] for packet in last} == {self.result["motion"]["stopped"]}
        return self.result["motion"]["stopped"]

    def packet(self, values=None, *, token: str | None = TOKEN) -> bytes:
        self._sequence += 1
        values = self.values if values is None else values
        reading = Reading(self.clock(), values, Unit.PASCAL, joints=self.joints, sequence=self._sequence)
        return encode_binary(reading, token=token)

    def send(self, packet: bytes, opened: socket.socket | None = None) -> None:
        (opened or self.board).sendto(packet, (LOOPBACK, self.port))

    def _around(self, act, until, end):
        """The board and the driver."""
        acted = False
        ended = False
        deadline = time.monotonic() + PATIENCE
        while not self.start() and not self._over.wait(STEP):
            pass
        while not self._over.is_set() and time.monotonic() < deadline:
            if self.silent:
                self.program_clock.advance(STEP)
            else:
                self.program_clock.now += STEP
                self.send(self.packet())
                self._await_command()
            self._drive()
            if not acted and self.states.count("moving") >= MOVING:
                act(self)
                acted = True
            if acted and not ended and until(self):
                ended = True
                os.kill(os.getpid(), end)
        self._drive()

    def _await_command(self):
        if self.driver.fileno() < 0:
            self._over.wait(STEP)
        else:
            select.select([self.driver], [], [], LONGEST_WAIT if self.states[-1:] == ["moving"] else STEP)

    def _drive(self):
        try:
            while True:
                self.packets.append(json.loads(self.driver.recv(65536)))
        except OSError:  # nothing more, or the driver has gone
            return


@pytest.fixture
def trial(tmp_path, capsys, monkeypatch):
    made = Trial(tmp_path, capsys)
    monkeypatch.setattr(listen, "CLOCK", made.program_clock)
    yield made
    made.close()


def moved_more(trial):
    """True once the robot was moved long enough to reach what it is limited by."""
    return trial.states.count("moving") >= 60


RECEIVED_HERE = "the readings are received at this address"


@pytest.mark.sampled(8)
@pytest.mark.parametrize(
    ("source", "words", "problem"),
    [
        *(
            (source, f"--controller hybrid --send udp://127.0.0.1:9{token}", problem)
            for token, problem in (("", "Set a token, for example "), (" --token short", "at least 8 characters"))
            for source in ("udp:", "zmq://127.0.0.1:9870", "udp://127.0.0.1:0")
        ),
        *(
            ("udp:", f"--token {TOKEN} --send {to}", to)
            for to in ("udp://127.0.0.1:0", "zmq://127.0.0.1:0", "udp://127.0.0.1:99999", "udp://[")
        ),
        ("udp://127.0.0.1:9870", f"--token {TOKEN} --send udp://localhost:9870", RECEIVED_HERE),
        ("udp:", f"--token {TOKEN} --send udp://127.0.0.1", RECEIVED_HERE),
        ("udp://0.0.0.0:9871", f"--token {TOKEN} --remote --send udp://127.0.0.1:9871", RECEIVED_HERE),
        ("zmq://192.0.2.1:9870", f"--token {TOKEN} --remote --send zmq://192.0.2.1:9870", RECEIVED_HERE),
    ],
)
def test_motion_requires_a_token_and_a_driver_apart_from_the_readings(trial, source, words, problem):
    assert main(["listen", source, "--skin", str(trial.folder / "bar.npz"), *words.split()]) == 2
    assert problem in trial.capsys.readouterr().err


@pytest.mark.parametrize("source", ["udp:", "readings.csv", "zmq://127.0.0.1:9870", "udp://127.0.0.1:0"])
def test_driver_at_another_address_or_of_another_kind_is_accepted(source):
    check_not_source("udp://127.0.0.1:9900" if source == "udp:" else "udp://127.0.0.1:9870", source)


def test_token_from_a_file_is_the_token(trial):
    file = trial.folder / "token"
    words = ["listen", "udp:", "--skin", str(trial.folder / "bar.npz"), "--send", "udp://127.0.0.1"]
    for text, code, stderr in (
        (f"{TOKEN}\n", 2, "the readings are received at this address"),
        ("short\n", 2, "at least 8 characters"),
        (None, 1, "token"),
    ):
        file.unlink(missing_ok=True)
        if text is not None:
            file.write_text(text)
        assert main([*words, "--token-file", str(file)]) == code
        assert stderr in trial.capsys.readouterr().err
    file.write_text(TOKEN)
    assert main([*words, "--token-file", str(file), "--token", TOKEN]) == 2
    assert "the token is given twice" in trial.capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full to simulate a full disk")
def test_failed_recording_is_the_reported_reason_for_the_stop(trial):
    def fill(trial):
        (opened,) = (
            file
            for file in Path("/proc/self/fd").iterdir()
            if trial.folder.name in str(file.resolve()) and file.resolve().suffix == ".mcap"
        )
        with Path("/dev/full").open("wb") as full:
            os.dup2(full.fileno(), int(opened.name))

    trial.run("-o", str(trial.folder / "felt.mcap"), act=fill, until=lambda _: False)
    assert trial.code == 1
    assert "No space left" in trial.errors
    assert [(packet["state"], packet["why"]) for packet in trial.packets[-3:]] == [
        ("stopped", "the recording failed")
    ] * 3


def test_missing_driver_is_named_before_any_motion(trial):
    trial.driver.close()
    words = ["--robot", str(trial.folder / "bar.xml"), "--skin", str(trial.folder / "bar.npz"), "--token", TOKEN]
    words += ["--controller", "hold_force", "--send", f"udp://{LOOPBACK}:{trial.port}", "--for", "1"]
    assert main(["listen", "udp://127.0.0.1:0", *words]) == 1
    message = trial.capsys.readouterr().err
    assert "no program receives at the driver's address" in message
    assert "Start the robot's driver first" in message


@pytest.mark.long
def test_lost_driver_stops_motion_and_is_named(trial):
    trial.run(act=lambda trial: trial.driver.close(), until=lambda trial: "sending stopped" in trial.errors)
    motion = trial.result["motion"]
    assert motion["stopped"] == "no program receives at the driver's address"
    assert "the stop was not sent" in motion["detail"]
    assert motion["sent"] < trial.result["received"]


def test_readings_of_a_second_sender_never_reach_the_controller(trial):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
        second.bind((LOOPBACK, 0))
        name = f"{LOOPBACK}:{second.getsockname()[1]}"

        strong = pressed(60.0)

        def intrude(trial):
            for _ in range(50):
                trial.send(trial.packet(strong), second)

        trial.run(act=intrude, until=moved_more)
    assert trial.stopped == "switched off"
    assert trial.result["max_force_N"] < 5
    assert trial.result["refused_senders"] == {name: 50}
    assert f"packets of a second sender were rejected: 50 of {name}" in trial.errors


def test_packets_without_the_token_do_not_count_as_readings(trial):
    def fall_silent(trial):
        trial.silent = True
        for _ in range(20):
            trial.send(trial.packet(token="a guess of theirs"))

    trial.run(act=fall_silent)
    assert trial.stopped in SILENT
    assert trial.result["malformed"] == 20


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("number", "code"), [(signal.SIGHUP, 129), (signal.SIGQUIT, 131), (signal.SIGTERM, 143)])
def test_ending_signal_stops_the_robot_and_completes_the_recording(trial, number, code):
    file = trial.folder / "felt.mcap"
    trial.run("-o", str(file), until=moved_more, end=number)
    assert trial.code == code
    assert [packet["why"] for packet in trial.packets[-3:]] == ["switched off"] * 3
    assert open_recording(file).complete


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("forces", "stops"), [((14.0,), False), ((16.0,), True), ((2.0, 16.0), True)])
def test_force_limit_of_the_command_line_stops_at_the_strongest_contact(trial, forces, stops):
    def press(trial):
        trial.values = pressed(*forces)

    trial.run("--max-force", "15", act=press, until=None if stops else moved_more)
    assert trial.stopped == ("a contact passed the limit of force" if stops else "switched off")
    assert ("15 N allowed" in trial.result["motion"]["detail"]) is stops


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("force", "sign"), [(6.0, 1.0), (0.7, -1.0)])
def test_speed_limit_of_the_command_line_applies_in_both_directions(trial, force, sign):
    def press(trial):
        trial.values = pressed(force)

    trial.run("--max-speed", "0.002", act=press, until=moved_more)
    assert max(np.abs(trial.speeds)) == pytest.approx(0.002)
    assert np.sign(trial.speeds[-1]) == sign
    assert trial.result["motion"]["slowed"] > 5


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"silent": True}, SILENT),
        ({"joints": {}}, "a part of the robot is not heard any more"),
        ({"joints": {"hinge": 1e300}}, "a reading is impossible"),
        ({"values": np.full(60, 1e30)}, "a reading is impossible"),
        ({"clock": lambda: time.time() - 1e6}, "the clock of the readings was set"),
        ({"clock": time.monotonic}, "the clock of the readings was set"),
    ],
    ids=["silent", "joint", "far joint", "huge values", "clock", "restart"],
)
def test_invalid_readings_stop_motion_with_the_reason(trial, change, reason):
    def go_wrong(trial):
        for name, value in change.items():
            setattr(trial, name, value)

    trial.run(act=go_wrong)
    assert trial.stopped in reason
    sent = trial.result["motion"]["sent"]
    assert trial.states.count("moving") == sent


def test_motion_starts_only_after_all_readings_have_arrived(trial):
    trial.joints = {}
    steady = trial.clock

    def clock():
        if not trial.joints and "waiting for joint hinge" in trial.errors:
            assert trial.states == ["stopped"] * 2
            trial.joints = {"hinge": 0.3}
        return steady()

    trial.clock = clock
    trial.run(until=moved_more)
    assert trial.states[:2] == ["stopped"] * 2
    assert "motion is not sent yet: waiting for joint hinge" in trial.errors
    assert [packet["seq"] for packet in trial.packets] == list(range(len(trial.packets)))
    assert {packet["token"] for packet in trial.packets} == {TOKEN}


@pytest.mark.long
def test_sending_waits_for_a_sender_that_starts_later_and_records_meanwhile(trial):
    recorded = trial.folder / "felt.mcap"
    recorded.write_bytes(b"replaced")
    trial.start = lambda: "waiting for the first reading" in trial.errors
    trial.run("-o", str(recorded), "--overwrite", until=moved_more)
    motion = trial.result["motion"]
    assert (trial.code, trial.stopped, motion["detail"]) == (0, "switched off", "")
    assert motion["sent"] == trial.states.count("moving")
    assert motion["latency_ms"]["median"] <= motion["latency_ms"]["p99"] <= motion["latency_ms"]["largest"]
    assert motion["deadline_ms"] == pytest.approx(50)
    lines = [line for line in trial.errors.splitlines() if "motion" in line]
    assert lines[0] == "tactile-maps: motion is not sent yet: waiting for the first reading"
    assert lines[-1] == "tactile-maps: motion is sent, at most 0.2 rad/s (m/s for slides) in each joint"
    assert trial.result["left_out"] == 0
    assert len(open_recording(recorded)) >= motion["sent"]
    assert not (trial.folder / "felt.new.mcap").exists(), "Ctrl-C is the normal end of listening"


def test_second_program_cannot_move_the_same_robot():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind((LOOPBACK, 0))
        driver.settimeout(5)
        address = f"udp://localhost:{driver.getsockname()[1]}"
        taken = pytest.raises(LiveError, match="another program on this computer")
        with driver_channel(address), taken, driver_channel(address):
            pass
        with driver_channel(address) as put:
            put(b"again")
        assert driver.recv(16) == b"again"


def test_host_name_with_an_ipv6_and_an_ipv4_address_means_the_ipv4_address(monkeypatch):
    def both(*_, **__):
        kind = socket.SOCK_DGRAM, socket.IPPROTO_UDP, ""
        return [(socket.AF_INET6, *kind, ("::1", port, 0, 0)), (socket.AF_INET, *kind, (LOOPBACK, port))]

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind((LOOPBACK, 0))
        driver.settimeout(5)
        port = driver.getsockname()[1]
        monkeypatch.setattr(socket, "getaddrinfo", both)
        with driver_channel(f"udp://localhost:{port}") as put:
            put(b"here")
        assert driver.recv(16) == b"here"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(5))
def test_random_packets_and_senders_neither_move_nor_break_anything(trial, seed):
    dice = random.Random(seed)
    others = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(3)]
    strong = pressed(60.0)
    storms = iter(range(500))

    def storm(trial):
        for _ in range(dice.randrange(1, 40)):
            opened = dice.choice([*others, trial.board])
            packet = trial.packet(strong, token=dice.choice([None, "a guess of theirs", TOKEN]))
            if opened is trial.board:  # the owner of the stream sends nothing valid but its own readings
                packet = trial.packet(strong, token="a guess of theirs")
            kind = dice.randrange(4)
            if kind == 0:
                packet = dice.randbytes(dice.randrange(0, 2000))
            elif kind == 1:
                packet = packet[: dice.randrange(len(packet))] + dice.randbytes(8) if opened is not trial.board else b""
            trial.send(packet, opened)
        return next(storms, None) is None

    try:
        trial.run(until=storm)
    finally:
        for opened in others:
            opened.close()
    assert trial.code == 0
    assert trial.stopped == "switched off"
    assert trial.result["max_force_N"] < 5
    assert trial.result["refused_senders"]
    assert "Traceback" not in trial.errors
