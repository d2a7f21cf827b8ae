"""A grasp: fingers around a link that press against each other."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SceneError
from app.stimuli.grasp import Grasp
from app.stimuli.place import Ground, long_axes
from tests.touch import arm, bar_skin


@pytest.mark.parametrize("fingers", [2, 3, 5])
def test_fingers_stand_around_the_link_and_their_forces_nearly_cancel(fingers):
    skin = arm().skin
    ground, axis = Ground(skin), long_axes(skin.patches[1])[0]
    tracks = Grasp(patch="forearm", at=(0.5, 0.1), fingers=fingers, hold=2.0).tracks(ground)
    assert [track.finger for track in tracks] == list(range(fingers))
    points = np.array([track.points[0] for track in tracks])
    assert np.ptp(points @ axis) < 1e-5, "all in one section"
    normals = np.array([skin.normal(ground.surface_point(int(t.patches[0]), t.points[0])) for t in tracks])
    assert np.linalg.norm(normals.sum(axis=0)) < 0.1 * fingers
    assert all(np.array_equal(track.times, [0.0, 2.0]) for track in tracks)
    assert {skin.patches[int(t.patches[0])].link for t in tracks} == {"forearm"}


def test_where_the_skin_is_on_one_side_only_a_grasp_is_refused():
    with pytest.raises(SceneError, match=r"grasp\.fingers.*no skin.*bar"):
        Grasp(at=(0.2, 0.0, 0.02)).tracks(Ground(bar_skin()))
