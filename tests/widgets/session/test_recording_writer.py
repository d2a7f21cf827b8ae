"""The recording writer: it never keeps the session waiting, and says once why it no longer writes."""

from __future__ import annotations

import os
import shutil
import threading
from pathlib import Path

import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.verify import verify
from tactile_maps.session.bundle import pack_scene
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_widgets.session import recording_writer
from tactile_widgets.session.recording_writer import InlineRecordingWriter, RecordingWriter

FULL = Path("/dev/full")


class GatedRecorder(Recorder):
    """A recorder on a disk that blocks until ``gate`` is set."""

    def __init__(self, *args):
        super().__init__(*args)
        self.gate = threading.Event()
        self.writing = threading.Event()

    def write(self, frame, inputs):
        """Wait for the disk."""
        self.writing.set()
        self.gate.wait()
        super().write(frame, inputs)


def complete(writer):
    """End the file, and wait for what comes of it."""
    writer.end()
    writer.wait()
    return writer.take_closed()


def test_without_a_recorder_nothing_is_written(prepared):
    writer = RecordingWriter()
    writer.write(Session(prepared).frame, [])
    assert writer.recorder is None
    assert writer.take_failure() is None


@pytest.mark.long
def test_written_ticks_and_marks_can_be_read(prepared, tmp_path):
    writer = RecordingWriter()
    session = Session(prepared)
    writer.begin(Recorder(prepared, tmp_path / "kept.mcap"))
    for _ in range(20):
        session.tick()
        writer.write(session.frame, session.inputs)
    assert complete(writer) == [tmp_path / "kept.mcap"]
    assert writer.recorder is None
    assert len(RecordingPlayer(tmp_path / "kept.mcap")) == 20


@pytest.mark.long
def test_blocked_disk_delays_no_caller_and_loses_no_tick(prepared, tmp_path):
    writer = RecordingWriter()
    session = Session(prepared)
    recorder = GatedRecorder(prepared, tmp_path / "slow.mcap")
    writer.begin(recorder)
    for tick in range(20):
        if tick == 10:
            session.submit(PokePressed(1, prepared.skin.taxel_point(70), Finger()))
        session.tick()
        writer.write(session.frame, session.inputs)
    assert recorder.writing.wait(10)
    assert recorder.frames == 0, "the disk still blocks"
    writer.end()
    assert writer.take_closed() == [], "the caller does not wait for the blocked disk"
    recorder.gate.set()
    writer.wait()
    assert writer.take_closed() == [tmp_path / "slow.mcap"]
    assert writer.take_closed() == []
    kept = RecordingPlayer(tmp_path / "slow.mcap")
    assert len(kept) == 20
    assert verify(kept).identical
    assert [tick for tick, act in kept.inputs if isinstance(act, PokePressed) and act.id == 1] == [11]


def test_disk_that_stays_blocked_ends_the_recording_with_a_message(prepared, tmp_path, monkeypatch):
    monkeypatch.setattr(recording_writer, "MOST_WAITING", 5)
    writer = RecordingWriter()
    session = Session(prepared)
    recorder = GatedRecorder(prepared, tmp_path / "slow.mcap")
    writer.begin(recorder)
    for _ in range(10):
        session.tick()
        writer.write(session.frame, session.inputs)
    assert "too slow" in str(writer.take_failure()), "reported while the disk still blocks"
    assert writer.recorder is None
    assert writer.take_failure() is None
    recorder.gate.set()


@pytest.mark.long
@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full, a disk that is full")
def test_full_disk_is_reported_once_and_the_session_continues(prepared, tmp_path, qtbot):
    path = tmp_path / "torn.mcap"
    writer = RecordingWriter()
    session = Session(prepared)
    recorder = Recorder(prepared, path)
    writer.begin(recorder)
    for _ in range(20):
        session.tick()
        writer.write(session.frame, session.inputs)
    qtbot.waitUntil(lambda: recorder.frames == 20)
    with FULL.open("wb") as full:
        os.dup2(full.fileno(), recorder._stream.fileno())
    for _ in range(50):
        session.tick()
        writer.write(session.frame, session.inputs)
    assert session.frame.tick == 70
    failures = []
    qtbot.waitUntil(lambda: failures.append(writer.take_failure()) or failures[-1] is not None)
    assert str(path) in str(failures[-1])
    assert writer.recorder is None
    assert writer.take_failure() is None
    kept = RecordingPlayer(path)
    assert len(kept) >= 12, "whole chunks written before the disk was full stay readable"
    assert not kept.complete


@pytest.mark.long
@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full, a disk that is full")
def test_failure_while_completing_a_file_is_reported(prepared, tmp_path):
    writer = RecordingWriter()
    session = Session(prepared)
    recorder = Recorder(prepared, tmp_path / "torn.mcap")
    writer.begin(recorder)
    with FULL.open("wb") as full:
        os.dup2(full.fileno(), recorder._stream.fileno())
    for _ in range(50):
        session.tick()
        writer.write(session.frame, session.inputs)
    (error,) = complete(writer)
    assert isinstance(error, RecordingError)
    assert "torn.mcap" in str(error)
    assert writer.recorder is None


def let_it_write(writer, session, recorder, ticks, qtbot):
    """Record so many ticks, all of them on the disk afterwards."""
    before = recorder.frames
    for _ in range(ticks):
        session.tick()
        writer.write(session.frame, session.inputs)
    qtbot.waitUntil(lambda: recorder.frames == before + ticks)


@pytest.mark.long
def test_remaining_space_is_reported_below_an_hour_ten_minutes_and_a_minute(prepared, tmp_path, qtbot):
    now = [0.0]
    free = [10**15]
    writer = RecordingWriter(free=lambda _folder: free[0], clock=lambda: now[0])
    session = Session(prepared)
    recorder = Recorder(prepared, tmp_path / "long.mcap")
    writer.begin(recorder)
    let_it_write(writer, session, recorder, 1, qtbot)  # the scene, which does not count
    start = recorder.bytes_written
    warnings = []
    for share in (1e9, 5000.0, 3000.0, 2500.0, 500.0, 450.0, 48.0, 40.0):
        let_it_write(writer, session, recorder, 24, qtbot)
        now[0] += 10.0
        free[0] = int(share * (recorder.bytes_written - start) / now[0])
        let_it_write(writer, session, recorder, 1, qtbot)
        warnings.append(writer.take_warning())
    assert [warning is not None for warning in warnings] == [False, False, True, False, True, False, True, False]
    assert warnings[2].folder == tmp_path
    assert warnings[2].seconds == pytest.approx(3000.0, rel=0.18), "but for the chunk that is being filled"
    assert warnings[6].free < warnings[4].free
    complete(writer)


@pytest.mark.long
@pytest.mark.parametrize("gone", ["file", "folder", "replaced"])
def test_deleted_file_ends_the_recording_with_a_message(prepared, tmp_path, qtbot, gone):
    now = [0.0]
    folder = tmp_path / "stick"
    folder.mkdir()
    writer = RecordingWriter(clock=lambda: now[0])
    session = Session(prepared)
    recorder = Recorder(prepared, folder / "a.mcap")
    writer.begin(recorder)
    let_it_write(writer, session, recorder, 5, qtbot)
    if gone == "folder":
        shutil.rmtree(folder)
    else:
        (folder / "a.mcap").unlink()
    if gone == "replaced":
        (folder / "a.mcap").write_bytes(b"another")
    now[0] = 10.0
    session.tick()
    writer.write(session.frame, session.inputs)
    failures = []
    qtbot.waitUntil(lambda: failures.append(writer.take_failure()) or failures[-1] is not None)
    assert "removed or replaced" in str(failures[-1])
    assert writer.recorder is None
    session.tick()
    if gone == "replaced":
        assert (folder / "a.mcap").read_bytes() == b"another"


def test_deleted_file_is_not_reported_as_saved(prepared, tmp_path):
    writer = RecordingWriter()
    session = Session(prepared)
    writer.begin(Recorder(prepared, tmp_path / "a.mcap"))
    session.tick()
    writer.write(session.frame, session.inputs)
    (tmp_path / "a.mcap").unlink()
    (error,) = complete(writer)
    assert isinstance(error, RecordingError)
    assert "removed or replaced" in str(error)


@pytest.mark.long
def test_compressing_robot_and_map_does_not_block_the_window(prepared, tmp_path, monkeypatch):
    packing = threading.Event()
    go_on = threading.Event()

    def slow(scene):
        packing.set()
        assert go_on.wait(10)
        return pack_scene(scene)

    monkeypatch.setattr("tactile_maps.recording.recorder.pack_scene", slow)
    writer = RecordingWriter()
    session = Session(prepared)
    writer.begin(Recorder(prepared, tmp_path / "a.mcap"))
    writer.write(session.frame, session.inputs)
    assert packing.wait(10)
    session.tick()
    writer.write(session.frame, session.inputs)
    go_on.set()
    assert complete(writer) == [tmp_path / "a.mcap"]
    assert len(RecordingPlayer(tmp_path / "a.mcap")) == 2


@pytest.mark.long
def test_inline_writer_completes_the_file_at_its_end(prepared, tmp_path):
    writer = InlineRecordingWriter()
    session = Session(prepared)
    writer.begin(Recorder(prepared, tmp_path / "a.mcap"))
    writer.write(session.frame, session.inputs)
    writer.end()
    assert writer.take_closed() == [tmp_path / "a.mcap"]
