"""Pokes as data."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.tactile.poke import Finger, PokeState


@pytest.mark.parametrize("bad", [{"stiffness": 0.0}, {"stiffness": float("nan")}, {"radius": -1.0}, {"max_force": -1.0},
                                 {"speed": float("inf")}])  # fmt: skip
def test_a_finger_that_cannot_be_is_refused(bad):
    with pytest.raises(SimulationError, match=f"finger {next(iter(bad))}"):
        Finger(**bad)


def test_a_state_owns_its_arrays():
    point = np.zeros(3)
    state = PokeState(1, SurfacePoint(0, 0, (1.0, 0.0, 0.0)), 2.0, point, np.ones(3), 0.01)
    point[0] = 5
    assert state.world_position[0] == 0
    assert not state.world_normal.flags.writeable
