"""Reaction time of ``listen --send``: from a force step on the skin to the first stop at the robot's driver.

    python -m tests.benchmarks.stop_reaction                    # 100 Hz to 5 kHz, 100 to 5,000 taxels, two controllers
    python -m tests.benchmarks.stop_reaction --rates 2000 --taxels 100 --controllers qp --steps 1000

Readings are sent by a second process over the loopback interface, and the driver is a third process, so that neither
waits for the program's interpreter. Both record times of the system's monotonic clock. A light touch is held until the
program sends motion. At a random time its force then exceeds the force limit, and the program must send a stop. The
program runs on between the steps.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.live.frame_recording import FrameRecording
from tactile_maps.live.motion.command_latency import LatencyFigures
from tactile_maps.live.motion.command_loop import CommandLoop
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import VALID_SECONDS, MotionLimits
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.readings.wire_format import HEADER, encode_binary
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.live.sources.network import UdpSource
from tactile_maps.live.sources.send import sender
from tactile_maps.recording.recorder import Recorder
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene, prepare
from tactile_maps.tactile.press import press_skin

LIGHT = 2.0
STRONG = 40.0
LIMIT = 10.0
PATIENCE = 30.0
"""Time without a stop [s] after which the measurement ends."""
ROOT = Path(__file__).parents[2]


@dataclass(frozen=True, eq=False)
class Reaction:
    """Results of one case.

    Attributes:
        taxels: Number of taxels.
        rate: Requested packet rate [Hz].
        sent: Actual packet rate [Hz].
        controller: Name of the controller.
        times: (steps,) times from the first packet of a force step to the first stop at the driver [s].
        reasons: Distinct reasons of the stops.
        latency: Time from a reading's arrival to its command, as measured by the program.
    """

    taxels: int
    rate: float
    sent: float
    controller: str
    times: np.ndarray
    reasons: tuple[str, ...]
    latency: LatencyFigures | None


@contextmanager
def process(*words: str):
    """Start the process of the sender or the driver."""
    started = subprocess.Popen(
        [sys.executable, "-m", "tests.benchmarks.stop_reaction_peers", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    try:
        yield started
    finally:
        started.kill()
        started.wait()
        started.stdin.close()
        started.stdout.close()


def prepared_arm(taxels: int) -> PreparedScene:
    """Return our arm with a number of taxels."""
    scene = load_scene("arm")
    return prepare(replace(scene, cover=replace(scene.cover, taxels=taxels), stimuli=()))


def encoded(prepared: PreparedScene, force: float) -> bytes:
    """Return a packet of the arm touched in one place."""
    skin = prepared.skin
    robot = prepared.robot
    values = press_skin(skin, skin.taxel_point(len(skin) // 2), force=force)
    joints = dict(zip((joint.name for joint in robot.joints), robot.home.tolist(), strict=True))
    return encode_binary(Reading(0.0, values, Unit.PASCAL, ids=np.arange(len(skin)), joints=joints, sequence=0))


def measure(
    prepared: PreparedScene, rate: float, controller: str, steps: int, folder: Path, *, record: bool = False
) -> Reaction:
    """Measure ``steps`` force steps, recording the session if ``record`` is set."""
    random = np.random.default_rng(0)
    paths = []
    for name, force in (("light", LIGHT), ("strong", STRONG)):
        paths.append(folder / f"{name}.bin")
        paths[-1].write_bytes(encoded(prepared, force))
    connection = Connection(UdpSource("127.0.0.1", 0))
    connection.open()
    session = MeasuredSession(as_measured(prepared))
    settings = ControlSettings(controller=controller, force_goal=LIGHT)
    motion = MotionOutput(session, settings, connection.ages)
    lock = threading.Lock()
    times = []
    reasons = set()
    latencies = None
    at = HEADER.size - struct.calcsize("<IdIH")  # positions of sequence number and time in a packet
    words = ["send", str(connection.source.port), str(rate), str(at), *map(str, paths)]
    with ExitStack() as stack:
        each: Callable[[Frame], None] = lambda _: None  # noqa: E731
        if record:
            recorder = stack.enter_context(
                Recorder(session.prepared, folder / "felt.mcap", overwrite=True, measured="udp:")
            )
            recording = FrameRecording(recorder, lossless=False)
            stack.callback(recording.close)
            each = lambda frame: recording.put(frame, session.inputs)  # noqa: E731
        commands = CommandLoop(connection, session, motion, each, lock=lock)
        driver = stack.enter_context(process("drive"))
        skin = stack.enter_context(process(*words))
        put = stack.enter_context(sender(f"udp://127.0.0.1:{_line(driver)}"))
        connection.start()
        commands.start()
        try:
            for _ in range(3 * steps):
                if len(times) == steps:
                    break
                with lock:
                    motion.start_sending(put, MotionLimits(force=LIMIT))
                _until(lambda: motion.sending.sent > 5 or motion.sending.stopped)
                time.sleep(random.uniform(0.02, 0.06))
                if motion.sending.stopped is None:
                    latencies = motion.latency.figures
                    _write(skin, "step")
                    pressed = float(_line(skin))
                    at, _, why = _line(driver).partition(" ")
                    times.append(float(at) - pressed)
                    reasons.add(why)
                    _write(skin, "")
                else:
                    _line(driver)
                    reasons.add(f"before the step: {motion.sending.stopped} ({motion.sending.detail})")
                _until(lambda: not session.frame.regions or session.frame.regions[0].force < LIMIT)
            skin.stdin.close()
            sent = float(_line(skin).split()[1])
        finally:
            commands.close()
            connection.close()
    return Reaction(len(prepared.skin), rate, sent, controller, np.array(times), tuple(sorted(reasons)), latencies)


def _write(started: subprocess.Popen, line: str) -> None:
    started.stdin.write(line + "\n")
    started.stdin.flush()


def _line(started: subprocess.Popen) -> str:
    line = started.stdout.readline()
    assert line, "a process of the measurement ended"
    return line.strip()


def _until(condition) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "the program neither moves nor stops"
        time.sleep(0.002)


def row(found: Reaction) -> str:
    """Return one line of the table."""
    ms = 1e3 * found.times
    command = "" if found.latency is None else f"{1e3 * found.latency.median:8.1f}{1e3 * found.latency.p99:8.1f}"
    figures = "".join(f"{value:9.1f}" for value in (*np.percentile(ms, [50, 95, 99.9]), ms.max()))
    return (
        f"{found.controller:<12}{found.taxels:>7}{found.rate:>7.0f}{found.sent:>7.0f}{len(ms):>7}{figures}"
        f"{command:>16}  {'; '.join(found.reasons)}"
    )


HEAD = (
    f"{'controller':<12}{'taxels':>7}{'Hz':>7}{'sent':>7}{'steps':>7}{'median':>9}{'p95':>9}{'p99.9':>9}{'max':>9}"
    f"{'command':>8}{'p99':>8}  why it stopped     (times in ms)"
)


def main(argv: Sequence[str] | None = None) -> int:
    """Print the table; return 0 if every stop came within the validity of a command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rates", type=float, nargs="+", default=[100, 1000, 2000, 5000])
    parser.add_argument("--taxels", type=int, nargs="+", default=[100, 1000, 5000])
    parser.add_argument("--controllers", nargs="+", default=["hold_force", "qp"])
    parser.add_argument("--steps", type=int, default=50, help="force steps in each case")
    parser.add_argument("--record", action="store_true", help="record meanwhile")
    arguments = parser.parse_args(argv)
    sys.stdout.write(HEAD + "\n")
    every = []
    with tempfile.TemporaryDirectory() as folder:
        for taxels in arguments.taxels:
            prepared = prepared_arm(taxels)
            for controller in arguments.controllers:
                for rate in arguments.rates:
                    found = measure(prepared, rate, controller, arguments.steps, Path(folder), record=arguments.record)
                    every.append(found.times)
                    sys.stdout.write(row(found) + "\n")
                    sys.stdout.flush()
    times = np.concatenate(every)
    p999 = 1e3 * np.percentile(times, 99.9)
    sys.stdout.write(f"all {len(times)} steps: p99.9 {p999:.1f} ms, at most {1e3 * times.max():.1f} ms\n")
    return int(times.max() > VALID_SECONDS)


if __name__ == "__main__":
    sys.exit(main())
