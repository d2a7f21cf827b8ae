"""Babbling by hand: chance that comes again."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.errors import SceneError
from app.skin.skin import Skin
from app.stimuli.babble import Babble
from app.stimuli.place import Ground
from app.stimuli.stroke import lengths
from app.touch.babbling import BabbleSpec, touched_places
from tests.touch import arm


def tracks(**values):
    return Babble(**values).tracks(Ground(arm().skin))


def test_touches_follow_each_other_at_the_places_that_babbling_touches():
    found = tracks(touches=30, seed=5)
    places, patches = touched_places(arm().skin, BabbleSpec(touches=30, samples=5, seed=5))
    assert np.allclose([track.points[0] for track in found], places[:, 0, 0], atol=0.002)
    assert [int(track.patches[0]) for track in found] == patches[:, 0, 0].tolist()
    assert all(one.times[-1] + 0.19 < other.times[0] for one, other in pairwise(found))


def test_forces_and_shares_are_as_said():
    found = tracks(touches=200, strokes=0.3, length=0.03, force=2.0)
    forces = np.array([track.tip.max_force for track in found])
    assert 1.0 <= forces.min() < 1.2
    assert 2.8 < forces.max() <= 3.0
    moving = [track for track in found if len(track.times) > 2]
    assert len(moving) / 200 == pytest.approx(0.3, abs=0.1)
    assert np.median([lengths(track.points)[-1] for track in moving]) >= 0.028


def test_the_seed_chooses_and_strokes_do_not_move_the_touches():
    one, other = tracks(seed=1)[0], tracks(seed=2)[0]
    assert not np.array_equal(one.points[0], other.points[0])
    assert one.tip != other.tip
    still, moving = tracks(strokes=0.0), tracks(strokes=1.0)
    assert all(np.array_equal(a.points[0], b.points[0]) for a, b in zip(still, moving, strict=True))
    assert all(a.tip == b.tip for a, b in zip(still, moving, strict=True))


def test_ways_of_several_places_at_once():
    pairs = tracks(way="self-touch", touches=10, strokes=0.0)
    assert [track.finger for track in pairs] == [0, 1] * 10
    assert all(a.patches[0] != b.patches[0] for a, b in zip(pairs[::2], pairs[1::2], strict=True))
    assert all(a.tip == b.tip for a, b in zip(pairs[::2], pairs[1::2], strict=True))
    assert len(tracks(way="multi-touch", touches=4)) == 12
    assert 10 <= len(tracks(way="biased", touches=10)) <= 20


def test_one_patch_alone():
    assert {int(track.patches[0]) for track in tracks(patch="hand", touches=40)} == {2}
    with pytest.raises(SceneError, match="no taxels"):
        Babble().tracks(Ground(Skin(())))
