"""A stroke goes at an even speed from its start to its end."""

from __future__ import annotations

import numpy as np
import pytest

from app.stimuli.place import Ground
from app.stimuli.stroke import Stroke, lengths
from tests.touch import arm


def test_hold_go_stay():
    stroke = Stroke(patch="forearm", start=(0.1, 0.2), end=(0.9, 0.4), hold=0.5, speed=0.05, stay=0.3)
    (track,) = stroke.tracks(Ground(arm().skin))
    length = lengths(track.points)[-1]
    assert length > 0.1
    assert track.times[-1] == pytest.approx(0.5 + length / 0.05 + 0.3)
    assert np.array_equal(track.at(0.49)[1], track.points[0])
    assert np.array_equal(track.at(track.times[-1] - 0.29)[1], track.points[-1])
    for start, end in ((0.5, 1.5), (1.0, 2.0)):
        way = np.array([track.at(time)[1] for time in np.linspace(start, end, 401)])
        assert lengths(way)[-1] == pytest.approx(0.05, rel=0.01)


def test_lengths_along_a_polyline():
    assert np.array_equal(lengths(np.array([[0.0, 0, 0], [3, 4, 0], [3, 4, 2]])), [0, 5, 7])
