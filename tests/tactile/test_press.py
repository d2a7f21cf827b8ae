"""A ball pressed on a fixed skin."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import Finger, PokePressed
from tactile_maps.tactile.press import press_skin
from tests.support.touch import bar, bar_map, prepared_bar

SKIN = prepared_bar().skin


def test_pressure_occurs_at_the_pressed_place():
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


@pytest.mark.parametrize("model", ["point", "water-fill", "punch", "half-space"])
@pytest.mark.parametrize(("force", "radius"), [(700.0, 0.008), (1e6, 0.008), (50.0, 1e-4)])
def test_readings_add_up_to_a_force_that_pushes_the_ball_below_the_skin(force, radius, model):
    pressures = press_skin(SKIN, SKIN.taxel_point(30), force=force, radius=radius, model=model)
    assert pressures @ SKIN.areas == pytest.approx(force, rel=1e-9)


def test_finger_of_a_session_is_measured_at_a_force_that_pushes_it_below_the_skin():
    session = Session.of(bar(hinged=False), bar_map())
    session.submit(PokePressed(1, SKIN.taxel_point(30), Finger(stiffness=1e5, max_force=900.0, speed=1.0)))
    frame = session.run_for(0.05)
    assert frame.pokes[0].force == pytest.approx(900.0)
    assert frame.pressures @ SKIN.areas == pytest.approx(900.0)
