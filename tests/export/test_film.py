"""The film lasts as long as the recording and shows pressure where it was."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.export.pictures import FilmFrame

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
    canvas = FilmFrame(player.prepared.map, 10)
    titles = [canvas.picture(player.frame(player.number_at(k / 20.0)))[:30].astype(int) for k in range(len(pictures))]
    for k, picture in enumerate(pictures):
        most_similar = np.argmin([np.abs(title - picture[:30]).sum() for title in titles])
        assert most_similar == k


def test_edited_map_is_drawn_from_the_tick_of_the_edit(pictures, player):
    tick = next(tick for tick, act in player.inputs if type(act).__name__ == "MapEdited")
    number = int(np.ceil(tick * player.prepared.scene.tick * 20.0)) + 1
    assert np.abs(pictures[number].astype(int) - pictures[0]).mean() > 3
