"""Recordings in the window: what a damaged one says."""

from __future__ import annotations

import os
import re
from datetime import datetime
from pathlib import Path

import pytest
from mcap.reader import make_reader
from PySide6.QtWidgets import QToolButton

from tactile_widgets.common.mode import Mode
from tactile_widgets.plots.timeline.scrub_bar import ScrubBar
from tactile_widgets.session.recording_writer import DiskSpace
from tests.widgets.support.window_driver import record_run, run

pytestmark = pytest.mark.long
FULL = Path("/dev/full")


@pytest.fixture
def window(window_again):
    """Recordings end with the scene."""
    return window_again


def test_damage_of_a_recording_is_reported_and_marked(window, tmp_path):
    path = tmp_path / "damaged.mcap"
    window.live.reset()
    run(window, 2.0)
    record_run(window, path, 0.6)
    data = bytearray(path.read_bytes())
    with path.open("rb") as stream:
        summary = make_reader(stream).get_summary()
    (frames,) = [channel.id for channel in summary.channels.values() if channel.topic == "/frame"]
    index = [one for one in summary.chunk_indexes if frames in one.message_index_offsets][-2]
    data[index.chunk_start_offset + index.chunk_length // 2] ^= 1
    path.write_bytes(data)
    window.presenters.files.open_path(str(path))
    assert window.live.mode is Mode.REPLAYING
    assert "damaged.mcap is damaged" in window.notification_bar.text
    assert "frames missing" in window.notification_bar.text
    player = window.live.replay.player
    (span,) = [span for span in player.damaged_spans() if "frames missing" in span[2]]
    assert 0 < span[0] < span[1] <= player.duration
    assert float(player.times[0]) > 1.0, "the session began before the recording"
    assert span[2] in window.notification_bar.text
    stated = re.search(r"s from ([\d.]+) s on\)", span[2])
    assert float(stated[1]) == pytest.approx(span[0], abs=1e-3), "as on the timeline"
    assert window.timeline.findChild(ScrubBar)._damage


def test_recordings_of_the_same_second_have_different_names(window, tmp_path, monkeypatch):
    monkeypatch.setattr("tactile_widgets.presenters.session.session_presenter.datetime", SameSecond)
    for _ in range(3):
        window.action("record").trigger()
        run(window, 0.1)
        window.action("record").trigger()
    names = sorted(path.name for path in (tmp_path / "recordings").iterdir())
    assert names == ["arm 2026-01-02 03.04.05 2.mcap", "arm 2026-01-02 03.04.05 3.mcap", "arm 2026-01-02 03.04.05.mcap"]


class SameSecond(datetime):
    """A clock with a constant time."""

    @classmethod
    def now(cls, tz=None):
        """Always the same."""
        return cls(2026, 1, 2, 3, 4, 5, tzinfo=tz)


def test_filling_disk_is_reported(window, tmp_path):
    window.live.recording.disk_filling.emit(DiskSpace(tmp_path, 42_000_000, 3540.0))
    assert "full in about 59 minutes of recording (42 MB left)" in window.notification_bar.text
    window.live.recording.disk_filling.emit(DiskSpace(tmp_path, 1_000_000, 50.0))
    assert "about 50 seconds" in window.notification_bar.text


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full, a disk that is full")
def test_recording_on_a_full_disk_offers_another_folder(window, tmp_path):
    window.live.recording.start(tmp_path / "a.mcap")
    with FULL.open("wb") as full:
        os.dup2(full.fileno(), window.live.recording.recorder._stream.fileno())
    run(window, 0.4)
    assert window.live.recording.recorder is None
    assert "(found: No space left on device). Free space or choose another folder" in window.notification_bar.text
    button = window.notification_bar.findChild(QToolButton, "message-remedy")
    assert button.text() == "Preferences"
