"""Recording on a thread of its own: nothing waits for a slow disk, and what is left out is counted."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from tactile_maps.core.errors import RecordingError
from tactile_maps.live import frame_recording
from tactile_maps.live.frame_recording import FrameRecording
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.recording.player import open_recording
from tactile_maps.recording.recorder import Recorder
from tests.support.touch import prepared_bar


class Slow:
    """A disk that writes nothing before it is let."""

    def __init__(self):
        self.ready = threading.Event()
        self.written = []

    def write(self, frame, inputs):
        assert self.ready.wait(10.0)
        self.written.append((frame, len(inputs)))


class Full:
    """A disk that takes nothing more."""

    def write(self, frame, inputs):
        raise RecordingError("the recording cannot be written further")


def test_frames_are_written_in_order_with_their_inputs(tmp_path):
    session = MeasuredSession(as_measured(prepared_bar()))
    path = tmp_path / "felt.mcap"
    with Recorder(session.prepared, path, measured="udp:") as recorder:
        recording = FrameRecording(recorder, lossless=False)
        for number in range(20):
            frame = session.show(Arrived(Reading(0.01 * number, np.zeros(60), Unit.PASCAL), 0.0))
            recording.put(frame, session.inputs)
        recording.close()
    player = open_recording(path)
    assert len(player) == 20
    assert len(player.inputs) == len(session.inputs)
    assert recording.left_out == 0


def test_live_source_does_not_wait_for_a_slow_disk(monkeypatch):
    monkeypatch.setattr(frame_recording, "MOST_WAITING", 3)
    disk = Slow()
    recording = FrameRecording(disk, lossless=False)
    for number in range(10):
        recording.put(number, [(number, None)] * number)
    assert recording.left_out in (6, 7)  # one may have been taken from the queue
    disk.ready.set()
    recording.close()
    assert len(disk.written) + recording.left_out == 10
    assert disk.written[-1][1] == disk.written[-1][0]


def test_file_source_waits_for_the_disk(monkeypatch):
    monkeypatch.setattr(frame_recording, "MOST_WAITING", 3)
    disk = Slow()
    recording = FrameRecording(disk, lossless=True)
    threading.Timer(0.0, disk.ready.set).start()
    for number in range(10):
        recording.put(number, [])
    recording.close()
    assert len(disk.written) == 10


def test_error_is_raised_at_the_end():
    recording = FrameRecording(Full(), lossless=False)
    recording.put(0, [])
    with pytest.raises(RecordingError):
        recording.close()
