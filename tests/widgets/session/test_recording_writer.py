"""The tape: it writes while it can, says once why it no longer does, and knows which settings were in force."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.recording.player import RecordingPlayer
from app.recording.recorder import Recorder
from app.session.session import Session
from widgets.session.recording_writer import RecordingWriter

FULL = Path("/dev/full")


def test_without_a_recorder_nothing_is_written(prepared):
    tape = RecordingWriter()
    tape.write(Session(prepared).frame, [])
    assert tape.take_recorder() is None
    assert tape.take_failure() is None


def test_what_was_written_can_be_read(prepared, tmp_path):
    tape, session = RecordingWriter(), Session(prepared)
    tape.recorder = Recorder(tmp_path / "kept.mcap", prepared)
    for _ in range(20):
        tape.write(session.tick(), session.inputs)
    tape.take_recorder().close()
    assert len(RecordingPlayer(tmp_path / "kept.mcap")) == 20


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full, a disk that is full")
def test_a_full_disk_is_told_once_and_the_session_goes_on(prepared, tmp_path):
    path, tape, session = tmp_path / "torn.mcap", RecordingWriter(), Session(prepared)
    tape.recorder = Recorder(path, prepared)
    with FULL.open("wb") as full:
        for _ in range(20):
            tape.write(session.tick(), session.inputs)
        os.dup2(full.fileno(), tape.recorder._stream.fileno())
    for _ in range(50):
        tape.write(session.tick(), session.inputs)
    assert tape.recorder is None
    assert session.frame.tick == 70
    assert str(path) in str(tape.take_failure())
    assert tape.take_failure() is None
    kept = RecordingPlayer(path)
    assert len(kept) >= 12, "whole chunks written before the disk was full stay readable"
    assert not kept.complete
