"""Recordings in the window: what a damaged one says."""

from __future__ import annotations

from mcap.reader import make_reader

from app.recording.damage import DamageKind
from tests.widgets.support.window_driver import run
from widgets.timeline.timeline import ScrubBar


def test_a_damaged_recording_says_what_it_has_lost_and_marks_where(window, tmp_path):
    path = tmp_path / "damaged.mcap"
    window.live.start_recording(path)
    run(window, 0.6)
    window.live.stop_recording()
    data = bytearray(path.read_bytes())
    with path.open("rb") as stream:
        index = make_reader(stream).get_summary().chunk_indexes[-2]
    data[index.chunk_start_offset + index.chunk_length // 2] ^= 1
    path.write_bytes(data)
    window.presenters.files.open_path(str(path))
    assert window.live.mode == "replaying"
    assert "damaged.mcap is damaged" in window.notification_bar.text
    assert "frames missing" in window.notification_bar.text
    (span,) = [span for span in window.live.player.damaged_spans() if span[2].kind == DamageKind.FRAMES_MISSING]
    assert 0 < span[0] < span[1] <= window.live.player.duration
    assert window.timeline.findChild(ScrubBar)._damage
