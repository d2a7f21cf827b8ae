"""What is recorded stays, whatever happens to the disk or the process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.errors import RecordingError
from app.recording.player import Player
from app.recording.recorder import Recorder
from app.recording.recover import recover
from app.session.session import Session

ROOT = Path(__file__).resolve().parents[3]

ENDLESS = """
import sys
from app.recording.recorder import Recorder
from app.session.session import Session
from tests.recordings import small_arm
prepared = small_arm()
session = Session(prepared)
with Recorder(sys.argv[1], prepared) as recorder:
    while True:
        recorder.write(session.tick(), session.inputs)
        sys.stdout.write(f"{recorder.frames}\\n")
        sys.stdout.flush()
"""


def test_an_existing_file_is_never_overwritten_unasked(prepared, tmp_path):
    path = tmp_path / "kept.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(RecordingError, match="exists already"):
        Recorder(path, prepared)
    assert path.read_bytes() == b"precious"
    Recorder(path, prepared, overwrite=True).close()
    assert path.read_bytes() != b"precious"


@pytest.mark.parametrize("where", ["no/such/folder/x.mcap", "file.txt/x.mcap"])
def test_a_place_that_cannot_be_written_is_named(prepared, tmp_path, where):
    (tmp_path / "file.txt").write_text("a file, not a folder")
    with pytest.raises(RecordingError, match=r"x\.mcap.*cannot be written.*Choose a folder"):
        Recorder(tmp_path / where, prepared)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no /dev/full to stand in for a full disk")
def test_a_full_disk_is_named_at_the_start(prepared):
    with pytest.raises(RecordingError, match="/dev/full.*No space left.*Free space"):
        Recorder("/dev/full", prepared, overwrite=True)


def test_a_disk_that_fills_up_keeps_what_was_written(prepared, tmp_path):
    """A limit on the file's size stands in for the disk; in a process of its own, since it cannot be lifted."""
    path = tmp_path / "cut.mcap"
    code = (
        "import resource, signal, sys\n"
        "from app.errors import RecordingError\nfrom app.recording.recorder import Recorder\n"
        "from app.session.session import Session\nfrom tests.recordings import small_arm\n"
        "prepared = small_arm(); session = Session(prepared); recorder = Recorder(sys.argv[1], prepared)\n"
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


def test_a_killed_process_loses_less_than_one_percent(tmp_path):
    """``kill -9`` while it records, after about 1500 frames."""
    path = tmp_path / "killed.mcap"
    process = subprocess.Popen([sys.executable, "-c", ENDLESS, path], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    written, deadline = 0, time.monotonic() + 120
    while written < 1500:
        assert time.monotonic() < deadline
        written = int(process.stdout.readline())
    os.kill(process.pid, signal.SIGKILL)
    written = max([written, *(int(line) for line in process.stdout.read().splitlines() if line.isdigit())])
    assert process.wait() == -signal.SIGKILL
    process.stdout.close()
    assert not Player(path).complete, "the file must have been cut off for this test to mean anything"
    saved = recover(path, tmp_path / "fixed.mcap")
    assert saved.frames >= 0.99 * written
    assert saved.lost_frames == 0
    fixed = Player(tmp_path / "fixed.mcap")
    assert fixed.complete
    assert len(fixed) == saved.frames
    assert fixed.frame(len(fixed) - 1).tick == saved.frames


def test_closing_twice_is_harmless(prepared, tmp_path):
    recorder = Recorder(tmp_path / "a.mcap", prepared)
    recorder.write(Session(prepared).frame, [])
    recorder.close()
    recorder.close()
    assert Player(tmp_path / "a.mcap").complete
