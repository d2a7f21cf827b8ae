"""Taps come and go at one place."""

from __future__ import annotations

import numpy as np

from app.stimuli.place import Ground
from app.stimuli.tap import Tap
from tests.touch import bar_skin


def test_taps_are_short_pokes_of_one_finger():
    tracks = Tap(at=(0.1, 0.0, 0.02), taps=3, down=0.1, up=0.2).tracks(Ground(bar_skin()))
    assert [track.finger for track in tracks] == [0, 0, 0]
    assert np.allclose([track.times for track in tracks], [[0.0, 0.1], [0.3, 0.4], [0.6, 0.7]])
    assert len({track.points.tobytes() for track in tracks}) == 1
    assert tracks[0].tip.speed > 0.05, "quick enough to be felt in so short a time"
