"""The arm is prepared once, and the ball touches it where it is asked to."""

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.learning.touched_arm import prepared_arm, touched_session


@pytest.mark.long
def test_ball_touches_the_target_and_not_while_it_is_approaching():
    prepared = prepared_arm(300)
    assert prepared_arm(300) is prepared
    at = prepared.skin.taxel_point(150)
    settings = ControlSettings(stiffness=20.0)
    (region,) = touched_session(prepared, at, settings, seed=0).run_for(0.05).regions
    assert np.linalg.norm(region.map_point - prepared.map.to_map(at)) < 0.01
    track = np.array([[0.0, 0.005], [0.2, 0.005], [0.4, -0.01], [60.0, -0.01]])
    comes = touched_session(prepared, at, settings, seed=0, track=track)
    assert not comes.run_for(0.15).regions
    assert comes.run_for(0.5).regions
