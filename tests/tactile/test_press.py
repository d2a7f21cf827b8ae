"""A ball pressed on a skin that stands still."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.tactile.press import press_skin
from tests.support.touch import prepared_bar

SKIN = prepared_bar().skin


def test_pressure_is_at_the_pressed_place():
    pressures = press_skin(SKIN, SKIN.taxel_point(10))
    place = np.concatenate([patch.taxels.positions for patch in SKIN.patches])
    centre = pressures * SKIN.areas @ place / 3.0
    assert np.linalg.norm(centre - place[10]) < 0.01


@pytest.mark.parametrize(
    ("changed", "word"),
    [
        ({"force": float("nan")}, "force"),
        ({"force": -1.0}, "force"),
        ({"radius": 0.0}, "radius"),
        ({"model": "water-fil"}, "water-fill"),
        ({"at": SurfacePoint(99, 0, (1.0, 0.0, 0.0))}, "place"),
        ({"at": SurfacePoint(0, 0, (2.0, 0.0, 0.0))}, "place"),
    ],
)
def test_invalid_setting_is_rejected(changed, word):
    arguments = {"at": SKIN.taxel_point(0)} | changed
    with pytest.raises(SimulationError, match=word):
        press_skin(SKIN, arguments.pop("at"), **arguments)
