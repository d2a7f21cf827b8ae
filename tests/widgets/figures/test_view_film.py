"""Film of a recording: both views in every picture, its duration, and no file after cancelling."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.dialogs.figures.view_film import film_recording
from tests.widgets.support.samples import middle_taxel

av = pytest.importorskip("av", reason="films need PyAV, of the extra 'export'")


@pytest.fixture(scope="module")
def recording(coarse_prepared, tmp_path_factory):
    """Half a second, pressed from the start."""
    path = tmp_path_factory.mktemp("film") / "push.mcap"
    session = Session(coarse_prepared, scripted=False)
    taxel = middle_taxel(coarse_prepared.map, 1)
    with Recorder(coarse_prepared, path) as recorder:
        session.submit(PokePressed(0, coarse_prepared.skin.taxel_point(taxel)))
        for _ in range(100):
            recorder.write(session.tick(), session.inputs)
    return path


@pytest.mark.long
def test_film_shows_the_touch_in_both_views(qapp, recording, tmp_path):
    path = tmp_path / "push.mp4"
    film_recording(recording, path, size=(901, 420), rate=10.0, theme="light")
    with av.open(str(path)) as film:
        pictures = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video=0)]
    assert len(pictures) == 5
    assert pictures[0].shape == (420, 900, 3)
    changed = np.abs(pictures[-1] - pictures[0]).max(axis=2) > 60
    body = changed[:, :440]
    map_ = changed[:, 520:]
    assert body.sum() > 20
    assert map_.sum() > 20


@pytest.mark.long
def test_cancelled_film_leaves_no_file_and_none_is_overwritten(qapp, recording, tmp_path):
    path = tmp_path / "push.mp4"

    def cancel(_text, fraction):
        if fraction > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        film_recording(recording, path, size=(860, 300), rate=10.0, progress=cancel)
    assert list(tmp_path.iterdir()) == []
    path.write_bytes(b"mine")
    with pytest.raises(ExportError):
        film_recording(recording, path, size=(860, 300))
    assert path.read_bytes() == b"mine"


def test_range_is_filmed_and_a_range_outside_is_rejected(qapp, recording, tmp_path):
    path = tmp_path / "part.mp4"
    film_recording(recording, path, size=(400, 400), rate=10.0, span=(0.25, 9.0))
    with av.open(str(path)) as film:
        assert len(list(film.decode(video=0))) == 3
    with pytest.raises(ExportError, match="Choose a part of 0 to 0.49 s"):
        film_recording(recording, tmp_path / "none.mp4", span=(3.0, 4.0))
    assert not (tmp_path / "none.mp4").exists()


FILM = """
import sys
from pathlib import Path
from tactile_widgets.dialogs.figures.film_job import FilmRequest, film

film(FilmRequest(Path(sys.argv[1]), Path(sys.argv[2]), (320, 160), span=(0.0, 0.1)), lambda *_progress: None)
"""


@pytest.mark.long
def test_film_in_its_own_process_writes_nothing_to_the_terminal(recording, tmp_path):
    words = [sys.executable, "-c", FILM, str(recording), str(tmp_path / "push.mp4")]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert (tmp_path / "push.mp4").is_file()
    assert done.stdout + done.stderr == ""
