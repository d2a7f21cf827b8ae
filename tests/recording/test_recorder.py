"""Written frames survive a crash; a failure of a session is repeated by its replay."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import RecordingError, SimulationError
from tactile_maps.recording.file.damage import DamageKind
from tactile_maps.recording.player import RecordingPlayer, open_recording
from tactile_maps.recording.recorder import Recorder, record, save_failure_report
from tactile_maps.recording.recover import recover
from tactile_maps.recording.verify import verify
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.touch import prepared_bar

ROOT = Path(__file__).resolve().parents[2]

ENDLESS = """
import sys
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tests.support.touch import prepared_bar
prepared = prepared_bar()
session = Session(prepared)
with Recorder(prepared, sys.argv[1]) as recorder:
    while True:
        recorder.write(session.tick(), session.inputs)
        sys.stdout.write(f"{recorder.frames}\\n")
        sys.stdout.flush()
"""


def test_existing_file_is_not_overwritten_without_request(prepared, tmp_path):
    path = tmp_path / "kept.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(RecordingError, match="already exists"):
        Recorder(prepared, path)
    assert path.read_bytes() == b"precious"


@pytest.mark.parametrize("where", ["no/such/folder/x.mcap", "file.txt/x.mcap"])
def test_unwritable_path_is_named(prepared, tmp_path, where):
    (tmp_path / "file.txt").write_text("a file, not a folder")
    with pytest.raises(RecordingError, match=r"x\.mcap.*cannot be written.*folder"):
        Recorder(prepared, tmp_path / where)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full to simulate a full disk")
def test_full_disk_is_reported_at_the_start(prepared, tmp_path):
    recorder = Recorder(prepared, tmp_path / "full.mcap")
    with Path("/dev/full").open("wb") as full:
        os.dup2(full.fileno(), recorder._stream.fileno())
    with pytest.raises(RecordingError, match=r"full\.mcap.*No space left.*Free space"):
        recorder.write(Session(prepared).frame, ())
    recorder.close()  # says nothing more
    recorder.abandon()


@pytest.mark.long
def test_full_disk_keeps_the_written_part(tmp_path):
    """A file size limit replaces the full disk, in a separate process since the limit cannot be lifted."""
    path = tmp_path / "cut.mcap"
    code = (
        "import resource, signal, sys\n"
        "from tactile_maps.core.errors import RecordingError\nfrom tactile_maps.recording.recorder import Recorder\n"
        "from tactile_maps.session.session import Session\nfrom tests.support.touch import prepared_bar\n"
        "prepared = prepared_bar(); session = Session(prepared); recorder = Recorder(prepared, sys.argv[1])\n"
        "recorder.write(session.tick(), session.inputs)\n"
        "import os; size = os.path.getsize(sys.argv[1]) + 200_000\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))\n"
        "try:\n"
        "    while True: recorder.write(session.tick(), session.inputs)\n"
        "except RecordingError as error:\n"
        "    sys.stdout.write(f'{recorder.frames} {error}')\n"
    )
    done = subprocess.run([sys.executable, "-c", code, path], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    frames, _, message = done.stdout.partition(" ")
    assert "cannot be written further" in message
    saved = recover(path, tmp_path / "fixed.mcap")
    assert int(frames) > 50
    assert saved.frames >= 0.9 * int(frames)


@pytest.mark.long
def test_killed_process_loses_less_than_one_percent(tmp_path):
    """``kill -9`` while it records, after about 1500 frames."""
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen([sys.executable, "-c", ENDLESS, path], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    written = 0
    deadline = time.monotonic() + 120
    while written < 1500:
        assert time.monotonic() < deadline
        written = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    written = max([written, *(int(line) for line in process.stdout.read().splitlines() if line.isdigit())])
    assert process.wait() == -signal.SIGKILL
    process.stdout.close()
    assert not RecordingPlayer(path).complete, "the file must have been cut off for this test to mean anything"
    saved = recover(path, tmp_path / "fixed.mcap")
    assert saved.frames >= 0.99 * written
    assert saved.lost_frames == 0
    fixed = RecordingPlayer(tmp_path / "fixed.mcap")
    assert [damage.kind for damage in fixed.damage] == [DamageKind.CUT_OFF]
    assert len(fixed) == saved.frames
    assert fixed.frame(len(fixed) - 1).tick == saved.frames


def test_interrupt_at_any_moment_loses_no_frame(tmp_path):
    prepared = prepared_bar()
    path = tmp_path / "x.mcap"
    times = 40
    frame = Session(prepared).tick()
    before = signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    interrupted = 0
    gc.disable()  # an exception raised in a callback of the garbage collector, as Hypothesis installs one, is lost
    try:
        with Recorder(prepared, path) as recorder:
            for number in range(times):
                try:
                    signal.setitimer(signal.ITIMER_REAL, 1e-3 + 1e-4 * number)
                    for _ in range(100_000):
                        recorder.write(replace(frame, tick=recorder.frames + 1), ())
                except KeyboardInterrupt:
                    interrupted += 1
    finally:
        gc.enable()
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    player = open_recording(path)
    assert interrupted == times
    assert (player.damage, len(player)) == ((), recorder.frames)


@pytest.mark.long
def test_closing_twice_is_harmless(prepared, tmp_path):
    recorder = Recorder(prepared, tmp_path / "a.mcap")
    recorder.write(Session(prepared).frame, [])
    recorder.close()
    recorder.close()
    assert RecordingPlayer(tmp_path / "a.mcap").complete


UNSTEADY = prepared_bar(tick=0.2, overrides={"integrator": "euler", "timestep": 0.02})
"""It diverges within one control tick, before a monitor of the speed can stop it."""
STIFF = ControlSettings(stiffness=40.0, damping_ratio=3.0)


def stopped(*, path=None) -> Session:
    """Return a session that ran until it diverged, recorded from its first tick if there is a path."""
    session = Session(UNSTEADY, settings=STIFF)
    recorder = Recorder(UNSTEADY, path) if path else None
    for _ in range(5):
        frame = session.tick()
        if recorder:
            recorder.write(frame, session.inputs)
    session.submit(PokePressed(1, UNSTEADY.skin.taxel_point(30), Finger(stiffness=10.0)))
    with pytest.raises(SimulationError, match="diverged"):
        until_it_stops(session, recorder)
    if recorder:
        recorder.fail(session.failure)
        recorder.close()
    return session


def until_it_stops(session, recorder) -> None:
    while session.frame.tick < 400:
        frame = session.tick()
        if recorder:
            recorder.write(frame, session.inputs)


@pytest.mark.long
def test_replayed_report_fails_at_the_same_tick_with_the_same_message(tmp_path):
    session = stopped()
    path = save_failure_report(session, tmp_path / "report.mcap")
    player = RecordingPlayer(path)
    tick, error = player.failure
    assert (tick, str(error)) == (session.failure.tick, session.failure.problem)
    outcome = verify(player)
    assert outcome.identical
    assert outcome.frames == 1
    assert outcome.stopped == session.failure.problem


@pytest.mark.long
def test_recording_of_the_whole_run_ends_with_the_failure(tmp_path):
    session = stopped(path=tmp_path / "run.mcap")
    outcome = verify(RecordingPlayer(tmp_path / "run.mcap"))
    assert (outcome.identical, outcome.frames) == (True, session.frame.tick)
    assert outcome.stopped == session.failure.problem


@pytest.mark.long
def test_recovered_report_fails_again(tmp_path):
    save_failure_report(stopped(), tmp_path / "report.mcap")
    recover(tmp_path / "report.mcap", tmp_path / "again.mcap")
    assert verify(RecordingPlayer(tmp_path / "again.mcap")).stopped


@pytest.mark.parametrize("later", [-1, 1])
def test_failure_at_another_tick_is_detected(tmp_path, later):
    save_failure_report(stopped(), tmp_path / "report.mcap")
    player = RecordingPlayer(tmp_path / "report.mcap")
    tick, error = player.failure
    player.failure = (tick + later, error)
    outcome = verify(player)
    assert not outcome.identical
    assert outcome.stopped is None
    assert outcome.first_difference == tick + min(later, 0)


@pytest.mark.long
def test_failure_with_another_message_counts_as_the_same(tmp_path):
    session = stopped(path=tmp_path / "run.mcap")
    player = RecordingPlayer(tmp_path / "run.mcap")
    tick, error = player.failure
    player.failure = (tick, SimulationError("it broke down", place=error.place, value=error.value, remedy="Wait"))
    outcome = verify(player)
    assert (outcome.identical, outcome.stopped) == (True, session.failure.problem)


@pytest.mark.long
@pytest.mark.parametrize("other", [{"place": "joint elbow"}, {"value": "position 3"}, {"value": None}])
def test_different_failure_is_detected(tmp_path, other):
    session = stopped(path=tmp_path / "run.mcap")
    player = RecordingPlayer(tmp_path / "run.mcap")
    tick, error = player.failure
    same = {"place": error.place, "value": error.value, "remedy": error.remedy}
    player.failure = (tick, SimulationError(error.problem, **same | other))
    outcome = verify(player)
    assert (outcome.identical, outcome.stopped) == (False, None)
    assert outcome.first_difference == tick == session.failure.tick


def test_unrecorded_failure_is_detected(tmp_path):
    stopped(path=tmp_path / "run.mcap")
    player = RecordingPlayer(tmp_path / "run.mcap")
    player.inputs = [item for item in player.inputs if item[0] == 0]
    player.failure = None
    assert not verify(player).identical, "without the finger it does not move as recorded"


def test_running_session_has_no_failure(tmp_path):
    with pytest.raises(RecordingError, match="nothing to report"):
        save_failure_report(Session(UNSTEADY), tmp_path / "report.mcap")
    assert not (tmp_path / "report.mcap").exists()


@pytest.mark.long
def test_block_of_ticks_is_recorded_and_replays_bit_for_bit(prepared, tmp_path):
    session = Session(prepared, scripted=False)
    path = tmp_path / "block.mcap"
    session.run_for(0.02)
    session.press(prepared.skin.taxel_point(0), force=1.0)
    with record(session, path) as recorder:
        session.run_for(0.1)
    session.tick()
    player = open_recording(path)
    assert recorder.frames == len(player) == 21
    assert [frame.tick for frame in player] == list(range(4, 25))
    assert verify(player).identical


def test_failure_within_a_block_of_ticks_is_reported(prepared, tmp_path):
    session = Session(prepared, scripted=False)
    path = tmp_path / "stopped.mcap"
    session.submit(PokePressed(1, prepared.skin.taxel_point(0), Finger(speed=1e9, max_force=1e12, stiffness=100.0)))
    with pytest.raises(SimulationError), record(session, path):
        session.run_for(5.0)
    assert session.failure is not None
    assert open_recording(path).failure[0] == session.failure.tick
