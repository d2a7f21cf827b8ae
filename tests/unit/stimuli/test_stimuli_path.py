"""A path is at each of its points when it says."""

from __future__ import annotations

import numpy as np

from app.stimuli.path import Path
from app.stimuli.place import Ground
from tests.touch import arm, bar_skin


def test_a_path_is_where_it_says_when_it_says():
    points = ((0.0, 0.1, 0.0, 0.02), (0.5, 0.2, 0.0, 0.02), (2.0, 0.2, 0.04, 0.02))
    (track,) = Path(points=points).tracks(Ground(bar_skin()))
    for time, *place in points:
        assert np.allclose(track.at(time)[1], place, atol=1e-9)
    assert np.allclose(track.at(0.25)[1], [0.15, 0, 0.02], atol=1e-9)


def test_a_path_over_two_patches():
    skin = arm().skin
    places = [skin.position(skin.taxel_point(int(skin.first[patch]))) for patch in (1, 2)]
    path = Path(points=tuple((float(n), *place) for n, place in enumerate(places)), patches=("forearm", "hand"))
    (track,) = path.tracks(Ground(skin))
    assert track.patches.tolist() == [1, 2]
    assert np.allclose(track.points, places, atol=1e-9)
