"""Force step on a streamed skin: the robot's driver receives a stop within the validity of a command, under any load.

``stop_reaction`` prints the whole table; only the validity is asserted here. On a busy machine sending may also stop
before a step or for another reason; such a step is repeated.
"""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.live.motion.motion_sender import VALID_SECONDS
from tests.benchmarks.stop_reaction import measure, prepared_arm
from tests.support.touch import prepared_bar


def test_force_step_stops_the_robot_within_the_validity(tmp_path):
    found = measure(prepared_bar(), 1000.0, "hold_force", 3, tmp_path)
    assert "a contact passed the limit of force" in found.reasons
    assert 0 < np.median(found.times) < VALID_SECONDS


@pytest.mark.long
@pytest.mark.parametrize(("taxels", "rate"), [(100, 5000.0), (5000, 2000.0)])
@pytest.mark.parametrize("controller", ["hold_force", "qp"])
def test_force_step_under_load_stops_the_robot_within_the_validity(tmp_path, taxels, rate, controller):
    found = measure(prepared_arm(taxels), rate, controller, 10, tmp_path)
    assert 0 < found.times.min() < found.times.max() < VALID_SECONDS
