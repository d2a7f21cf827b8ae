"""Curves over a whole recording lose no peak, and a summary reads no more than it must."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.writer import Writer

from tactile_maps.recording.encoding.annotations import Annotations, Mark, Outcome, save_annotations
from tactile_maps.recording.file.mcap_file import begin_recording
from tactile_maps.recording.overview.summary import summarise
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.bundle import pack_scene

pytestmark = pytest.mark.long


def test_summary_has_its_source_and_an_image_of_the_touch(recording, prepared, tmp_path):
    path = tmp_path / "a.mcap"
    path.write_bytes(recording.read_bytes())
    save_annotations(path, Annotations(marks=(Mark(60, "x"),), outcome=Outcome.SUCCESS))
    found = summarise(path)
    player = RecordingPlayer(path)
    assert found.seconds == pytest.approx(player.duration)
    assert (found.robot, found.taxels, found.problem) == (prepared.robot.name, len(prepared.skin), "")
    assert found.annotations.outcome is Outcome.SUCCESS
    assert np.isnan(found.picture).any(), "off the skin"
    assert np.nanmax(found.picture) > 1.0, "some touch is drawn [kPa]"


def test_damaged_recording_is_marked(recording, prepared, tmp_path):
    cut = tmp_path / "cut.mcap"
    junk = tmp_path / "junk.mcap"
    empty = tmp_path / "empty.mcap"
    cut.write_bytes(recording.read_bytes()[:-2000])
    junk.write_bytes(b"no recording")
    with empty.open("wb") as stream:
        writer = Writer(stream)
        begin_recording(writer, {}, pack_scene(prepared))
        writer.finish()
    assert "Damaged" in summarise(cut).problem
    assert summarise(cut).seconds > 0
    assert "not a recording" in summarise(junk).problem
    assert "no frame" in summarise(empty).problem
    assert "cannot be read" in summarise(tmp_path / "gone.mcap").problem
