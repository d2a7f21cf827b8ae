"""The film lasts as long as the recording and shows pressure where it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.export.pictures import FilmFrame
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.trim import trim

av = pytest.importorskip("av", reason="PyAV is not installed (extra export)")


@pytest.fixture(scope="module")
def pictures(player, tmp_path_factory):
    path = tmp_path_factory.mktemp("film") / "out.mp4"
    export_recording(player, path, to="mp4", options=ExportOptions(rate=20.0))
    with av.open(str(path)) as container:
        assert float(container.streams.video[0].average_rate) == 20.0
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_film_has_a_frame_for_each_time(pictures, player):
    assert len(pictures) == int(player.duration * 20.0 + 1e-9) + 1


@pytest.mark.long
def test_pictures_are_at_equal_steps_and_show_the_contacts_of_their_times(player, tmp_path):
    path = tmp_path / "out.mp4"
    rate = 50.0
    times = []
    marked = []
    export_recording(player, path, to="mp4", options=ExportOptions(rate=rate))
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        for frame in container.decode(video=0):
            times.append(float(frame.pts * stream.time_base))
            away = np.abs(frame.to_ndarray(format="rgb24").astype(int) - (31, 119, 180)).max(axis=2)
            marked.append(bool((away < 50).any()))  # H.264 changes colours, most those of thin lines
    np.testing.assert_allclose(times, np.arange(int(player.duration * rate + 1e-9) + 1) / rate, atol=1e-4)
    forces = [sum(region.force for region in player.frame(player.number_at(time)).regions) for time in times]
    firm = np.array(forces) > 0.5
    free = np.array(forces) == 0
    assert min(firm.sum(), free.sum()) > 5
    assert all(np.array(marked)[firm])
    assert not any(np.array(marked)[free])


def test_frames_are_the_drawn_pictures(pictures, player, frames):
    """Up to what H.264 loses; the scale is the next round number above the highest pressure shown."""
    shown = [player.frame(player.number_at(k / 20.0)) for k in range(len(pictures))]
    highest = 1e-3 * max(frame.pressures.max() for frame in shown)
    scale = next(step for step in (1, 2, 5, 10, 20, 50, 100, 200) if step >= highest)
    canvas = FilmFrame(player.prepared.map, scale)
    touched = max(range(6), key=lambda k: shown[k].pressures.max())  # before the edit of the map
    drawn = canvas.picture(shown[touched])
    assert drawn.shape == pictures[touched].shape
    assert np.abs(drawn.astype(int) - pictures[touched]).mean() < 3
    assert np.abs(canvas.picture(shown[0]).astype(int) - drawn).max() > 100


def test_pictures_state_the_time_at_which_they_are_shown(pictures, player):
    canvas = FilmFrame(player.prepared.map, 10, begins=float(player.times[0]))
    titles = [canvas.picture(player.frame(player.number_at(k / 20.0)))[:30].astype(int) for k in range(len(pictures))]
    for k, picture in enumerate(pictures):
        most_similar = np.argmin([np.abs(title - picture[:30]).sum() for title in titles])
        assert most_similar == k


@pytest.fixture(scope="module")
def late(player, tmp_path_factory):
    """The second half of the recording, as a recording."""
    path = tmp_path_factory.mktemp("late") / "late.mcap"
    trim(player.path, path, first=player.tick_at(0.5 * player.duration))
    return RecordingPlayer(path)


@pytest.mark.parametrize("start", [pytest.param(None, marks=pytest.mark.long), 0.2])
def test_captions_count_from_the_first_frame_of_the_recording_also_in_a_range(late, start, tmp_path):
    assert late.times[0] > 0.2
    span = None if start is None else (start, late.duration)
    export_recording(late, tmp_path / "out.mp4", to="mp4", options=ExportOptions(rate=20.0), span=span)
    with av.open(str(tmp_path / "out.mp4")) as container:
        picture = next(container.decode(video=0)).to_ndarray(format="rgb24").astype(int)
    frame = late.frame(late.number_at(start or 0.0))
    canvas = FilmFrame(late.prepared.map, 10)
    captions = {time: canvas.picture(replace(frame, time=time))[:30].astype(int) for time in (0.0, 0.2, frame.time)}
    assert min(captions, key=lambda time: np.abs(captions[time] - picture[:30]).sum()) == (start or 0.0)


def test_edited_map_is_drawn_from_the_tick_of_the_edit(pictures, player):
    tick = next(tick for tick, act in player.inputs if type(act).__name__ == "MapEdited")
    number = int(np.ceil(tick * player.prepared.scene.tick * 20.0)) + 1
    assert np.abs(pictures[number].astype(int) - pictures[0]).mean() > 3
