"""A poke stays where it is pressed."""

from __future__ import annotations

import numpy as np

from app.stimuli.place import Ground
from app.stimuli.poke import Poke
from tests.touch import bar_skin


def test_a_poke_is_one_finger_that_stays():
    (track,) = Poke(at=(0.1, 0.02, 0.02), hold=0.7, force=3.0).tracks(Ground(bar_skin()))
    assert (track.finger, track.tip.max_force) == (0, 3.0)
    assert np.array_equal(track.times, [0.0, 0.7])
    assert np.allclose(track.points, [0.1, 0.02, 0.02], atol=1e-12)
