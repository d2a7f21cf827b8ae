"""A file has a single recorder and is replaced only by a complete recording; empty files are removed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import is_locked, lock_file, open_atomically
from tactile_maps.recording.file.recording_file import RecordingFile
from tactile_maps.recording.player import open_recording
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.session.session import Session
from tests.support.special_files import is_special, make_special_file, special_kinds

ROOT = Path(__file__).resolve().parents[2]
ENDLESS = """
import sys
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tests.support.touch import prepared_bar
prepared = prepared_bar()
session = Session(prepared)
with Recorder(prepared, sys.argv[1], overwrite=sys.argv[2] == "overwrite") as recorder:
    while True:
        recorder.write(session.tick(), session.inputs)
        print(recorder.frames, flush=True)
"""


BEFORE = 30
"""Frames that a process has recorded when its test continues."""


def record_elsewhere(path: Path, *, overwrite: bool) -> subprocess.Popen[str]:
    """A process that records, after its first frames."""
    words = [sys.executable, "-c", ENDLESS, str(path), "overwrite" if overwrite else "new"]
    process = subprocess.Popen(words, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    deadline = time.monotonic() + 120
    while int(process.stdout.readline()) < BEFORE:
        assert time.monotonic() < deadline
    return process


def kill(process: subprocess.Popen[str]) -> int:
    """Kill it; the number of the last frame that it reported."""
    os.kill(process.pid, signal.SIGKILL)
    assert process.stdout is not None
    last = max([BEFORE, *(int(line) for line in process.stdout.read().splitlines() if line.isdigit())])
    assert process.wait() == -signal.SIGKILL
    process.stdout.close()
    return last


def make_recording(prepared, path, *, ticks: int = 5, overwrite: bool = False) -> bytes:
    session = Session(prepared)
    with Recorder(prepared, path, overwrite=overwrite) as recorder:
        for _ in range(ticks):
            recorder.write(session.tick(), session.inputs)
    return Path(path).read_bytes()


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.long
def test_second_recorder_is_rejected_until_the_first_is_killed(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    first = record_elsewhere(path, overwrite=False)
    try:
        with pytest.raises(RecordingError, match=r"touch\.mcap: another program is writing this file.*another name"):
            Recorder(prepared, path, overwrite=True)
        with pytest.raises(RecordingError, match="already exists"):
            Recorder(prepared, path)
        with (
            pytest.raises(RecordingError, match="another program is writing"),
            open_atomically(path, error=RecordingError),
        ):
            raise AssertionError("refused before anything is written")
    finally:
        last = kill(first)
    assert names(tmp_path) == ["touch.mcap"]
    assert recover(path, tmp_path / "fixed.mcap").frames >= last - 6, "written in place: nothing is lost"
    make_recording(prepared, path, overwrite=True)
    assert open_recording(path).complete


def test_second_recorder_of_the_same_process_is_rejected(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    session = Session(prepared)
    make_recording(prepared, path)
    with Recorder(prepared, path, overwrite=True) as first:
        first.write(session.tick(), session.inputs)
        with pytest.raises(RecordingError, match="another program is writing this file"):
            Recorder(prepared, path, overwrite=True)
    assert len(open_recording(path)) == 1
    assert names(tmp_path) == ["touch.mcap"]


def test_new_recording_is_locked_while_it_is_written(tmp_path):
    path = tmp_path / "touch.mcap"
    recording = RecordingFile(path, overwrite=False)
    with path.open("rb") as reader:
        locked = is_locked(reader.fileno())
    recording.discard()
    assert locked


def test_partial_file_of_a_killed_recorder_is_kept(tmp_path):
    path = tmp_path / "touch.mcap"
    part = tmp_path / "touch.new.mcap"
    path.write_bytes(b"complete")
    part.write_bytes(b"cut off")
    file = RecordingFile(path, overwrite=True)
    assert file.written == tmp_path / "touch.new-2.mcap"
    file.discard()
    assert part.read_bytes() == b"cut off"


def test_checking_a_lock_does_not_hold_it(tmp_path):
    path = tmp_path / "touch.mcap"
    path.touch()
    with path.open("rb") as reader, path.open("r+b") as writer:
        assert not is_locked(reader.fileno())
        assert lock_file(writer.fileno())
        assert is_locked(reader.fileno())


@pytest.mark.long
def test_killed_recorder_keeps_the_old_and_the_new_recording(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    old = make_recording(prepared, path)
    last = kill(record_elsewhere(path, overwrite=True))
    assert path.read_bytes() == old
    assert names(tmp_path) == ["touch.mcap", "touch.new.mcap"]
    partial = (tmp_path / "touch.new.mcap").read_bytes()
    assert recover(tmp_path / "touch.new.mcap", tmp_path / "fixed.mcap").frames >= last - 6
    with Recorder(prepared, path, overwrite=True) as again:
        assert again.written == tmp_path / "touch.new-2.mcap"
        again.write(Session(prepared).frame, ())
        assert path.read_bytes() == old, "the old one stays until the new one is complete"
    assert len(open_recording(path)) == 1
    assert (tmp_path / "touch.new.mcap").read_bytes() == partial


def record_until(stop, recorder: Recorder, session: Session) -> None:
    with recorder:
        recorder.write(session.tick(), session.inputs)
        raise stop


@pytest.mark.sampled(1)
@pytest.mark.parametrize("stop", [ValueError, KeyboardInterrupt])
def test_error_keeps_the_old_recording_and_the_new_part_and_names_both(prepared, tmp_path, stop):
    path = tmp_path / "touch.mcap"
    session = Session(prepared)
    old = make_recording(prepared, path)
    with pytest.raises(stop) as raised:
        record_until(stop, Recorder(prepared, path, overwrite=True), session)
    assert path.read_bytes() == old
    assert names(tmp_path) == ["touch.mcap", "touch.new.mcap"]
    assert open_recording(tmp_path / "touch.new.mcap").complete
    (note,) = raised.value.__notes__
    assert f"{path} is unchanged" in note
    assert note.endswith(str(tmp_path / "touch.new.mcap"))
    make_recording(prepared, path, overwrite=True)  # the lock is released


@pytest.mark.long
def test_error_before_the_first_frame_or_of_a_new_recording_adds_no_note(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    session = Session(prepared)
    with pytest.raises(ValueError, match="stop") as raised:
        record_until(ValueError("stop"), Recorder(prepared, path, overwrite=True), session)
    assert not hasattr(raised.value, "__notes__")
    with pytest.raises(ValueError, match="stop") as raised, Recorder(prepared, path, overwrite=True):
        raise ValueError("stop")
    assert not hasattr(raised.value, "__notes__")
    assert names(tmp_path) == ["touch.mcap"]


@pytest.mark.parametrize("exists", [True, False])
@pytest.mark.parametrize("stop", [ValueError, KeyboardInterrupt])
def test_recording_without_a_frame_is_removed(prepared, tmp_path, stop, exists):
    path = tmp_path / "touch.mcap"
    old = make_recording(prepared, path) if exists else None
    with pytest.raises(stop), Recorder(prepared, path, overwrite=True):
        raise stop
    assert names(tmp_path) == (["touch.mcap"] if exists else [])
    assert old is None or path.read_bytes() == old


def record_for_ever(recorder: Recorder, session: Session) -> None:
    while True:
        recorder.write(session.tick(), session.inputs)


@pytest.mark.long
def test_full_disk_keeps_the_old_recording(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    session = Session(prepared)
    old = make_recording(prepared, path)
    recorder = Recorder(prepared, path, overwrite=True)
    for _ in range(20):
        recorder.write(session.tick(), session.inputs)
    with Path("/dev/full").open("wb") as full:
        os.dup2(full.fileno(), recorder._stream.fileno())
    with (
        pytest.raises(RecordingError, match=r"touch\.new\.mcap") as raised,
        recorder,
        pytest.raises(RecordingError, match=r"touch\.new\.mcap.*No space left.*recover"),
    ):
        record_for_ever(recorder, session)
    assert f"{path} is unchanged" in raised.value.__notes__[0]
    assert path.read_bytes() == old
    assert recover(tmp_path / "touch.new.mcap", tmp_path / "fixed.mcap").frames >= 12
    make_recording(prepared, path, overwrite=True)  # the lock is released


@pytest.mark.parametrize("kind", special_kinds())
def test_special_file_is_rejected(prepared, tmp_path, kind):
    path = make_special_file(kind, tmp_path / "touch.mcap")
    with pytest.raises(RecordingError, match=f"not a regular file .found: a {kind}."):
        Recorder(prepared, path, overwrite=True)
    assert is_special(path)


@pytest.mark.long
@pytest.mark.parametrize("exists", [True, False])
def test_symbolic_link_is_not_replaced(prepared, tmp_path, exists):
    (tmp_path / "files").mkdir()
    target = tmp_path / "files" / "a.mcap"
    link = tmp_path / "link.mcap"
    if exists:
        target.write_bytes(b"old")
        target.chmod(0o640)
    link.symlink_to(target)
    make_recording(prepared, link, overwrite=exists)
    assert link.is_symlink()
    assert open_recording(target).complete
    assert not exists or target.stat().st_mode & 0o777 == 0o640
    assert names(tmp_path / "files") == ["a.mcap"]


def test_recording_that_cannot_be_renamed_is_kept_and_reported(prepared, tmp_path):
    path = tmp_path / "touch.mcap"
    make_recording(prepared, path)
    recorder = Recorder(prepared, path, overwrite=True)
    recorder.write(Session(prepared).frame, ())
    path.unlink()
    path.mkdir()
    with pytest.raises(RecordingError, match=r"folder of this name.*The complete recording is .*touch\.new\.mcap"):
        recorder.close()
    assert open_recording(tmp_path / "touch.new.mcap").complete


@pytest.mark.long
def test_file_with_the_longest_name_can_be_replaced(prepared, tmp_path):
    path = tmp_path / ("x" * 250 + ".mcap")
    make_recording(prepared, path)
    make_recording(prepared, path, overwrite=True)
    assert names(tmp_path) == [path.name]
