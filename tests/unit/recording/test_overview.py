"""Curves over a whole recording lose no peak, and a summary reads no more than it must."""

from __future__ import annotations

import numpy as np
import pytest

from app.recording.annotations import Annotations, Mark, Outcome, save_annotations
from app.recording.overview import CURVES, Curves, envelope, joined, read_curves, summarise
from app.recording.player import RecordingPlayer
from app.recording.recorder import Recorder


def test_the_curves_are_the_frames_numbers(recording):
    shares, pieces = zip(*read_curves(recording), strict=True)
    curves = joined(list(pieces))
    frames = list(RecordingPlayer(recording))
    assert shares[-1] == 1.0
    assert curves.ticks.tolist() == [frame.tick for frame in frames]
    columns = dict(zip(CURVES, curves.values.T, strict=True))
    np.testing.assert_allclose(columns["force"], [sum(region.force for region in frame.regions) for frame in frames])
    assert columns["force"].max() > 0.5
    np.testing.assert_array_equal(columns["peak"], [frame.pressures.max() for frame in frames])
    np.testing.assert_array_equal(columns["speed"], [np.abs(frame.velocity).max() for frame in frames])
    errors = [np.nan if frame.task is None or frame.task.error is None else frame.task.error for frame in frames]
    np.testing.assert_array_equal(columns["error"], errors)


def test_pieces_that_overlap_count_once():
    one = Curves(np.array([1, 3]), np.array([[1.0] * 4, [3.0] * 4]))
    other = Curves(np.array([2, 3]), np.array([[2.0] * 4, [9.0] * 4]))
    assert joined([one, other]).values[:, 0].tolist() == [1.0, 2.0, 3.0]
    assert len(joined([]).ticks) == 0


def test_the_envelope_keeps_every_extreme_and_leaves_gaps():
    times, values = np.arange(1000) * 0.005, np.zeros(1000)
    values[[137, 731]] = 6.4, -2.0
    times, values = np.delete(times, slice(400, 600)), np.delete(values, slice(400, 600))
    low, high = envelope(times, values, np.linspace(0, 5, 51))
    assert high[6] == 6.4
    assert low[36] == -2.0
    assert np.isnan(high[20:30]).all()
    assert np.isfinite(np.r_[high[:20], high[30:]]).all()
    empty = envelope(times, values, np.linspace(10, 11, 5))
    assert np.isnan(empty).all()


def test_a_summary_says_what_it_is_of_and_shows_the_touch(recording, prepared, tmp_path):
    path = tmp_path / "a.mcap"
    path.write_bytes(recording.read_bytes())
    save_annotations(path, Annotations(marks=(Mark(60, "x"),), outcome=Outcome.SUCCESS))
    found = summarise(path)
    player = RecordingPlayer(path)
    assert found.seconds == pytest.approx(player.duration)
    assert (found.robot, found.taxels, found.problem) == (prepared.robot.name, len(prepared.skin), "")
    assert found.annotations.outcome is Outcome.SUCCESS
    assert found.picture.shape[2] == 3
    assert (found.picture[..., 0].astype(int) - found.picture[..., 2]).max() > 100, "some touch is drawn"


def test_what_is_damaged_says_so(recording, prepared, tmp_path):
    cut, junk, empty = tmp_path / "cut.mcap", tmp_path / "junk.mcap", tmp_path / "empty.mcap"
    cut.write_bytes(recording.read_bytes()[:-2000])
    junk.write_bytes(b"no recording")
    with Recorder(prepared, empty):
        pass
    assert "Damaged" in summarise(cut).problem
    assert summarise(cut).seconds > 0
    assert "not a recording" in summarise(junk).problem
    assert "no frame" in summarise(empty).problem
    assert "cannot be read" in summarise(tmp_path / "gone.mcap").problem
