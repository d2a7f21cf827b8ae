"""Pokes as data."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.tactile.poke import Finger


@pytest.mark.parametrize(
    "bad",
    [{"stiffness": 0.0}, {"stiffness": float("nan")}, {"radius": -1.0}, {"max_force": -1.0}, {"speed": float("inf")}],
)
def test_invalid_finger_is_rejected(bad):
    with pytest.raises(SimulationError, match=f"finger {next(iter(bad))}"):
        Finger(**bad)
