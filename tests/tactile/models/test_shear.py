"""Shear of the taxels under loads: what the springs of the skin remember, and curved skin."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import cell_field
from tactile_maps.tactile.models.shear import ShearModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.support.touch import bar_skin

UP = np.array([0.0, 0.0, 1.0])
LAYER = ElasticLayer()


def model(skin: Skin) -> WaterFillModel:
    """A water-fill model with shear along x and y of a flat skin on top."""
    made = WaterFillModel(skin)
    made.shear = ShearModel(skin, LAYER, cell_field(skin), np.tile(np.eye(3), (len(skin), 1, 1)))
    return made


def ball(x: float, shear: tuple[float, float] = (0.0, 0.0), *, friction: float = 0.5, force: float = 3.0) -> Load:
    """A ball of 15 mm that presses the top of the bar at x and drags it."""
    along = np.array([*shear, 0.0])
    place = np.array([x, 0.0, 0.02])
    return sphere_load("bar", place, UP, force, 0.015, depth=force / LAYER.stiffness, shear=along, friction=friction)


def sums(made: WaterFillModel, skin: Skin) -> np.ndarray:
    return skin.areas @ made.shear.tractions


def test_released_skin_keeps_locked_shear_that_sums_to_zero():
    skin = bar_skin(400, finer=2)
    made = model(skin)
    made.pressures([ball(0.2, (1.2, 0.0))])
    made.pressures([ball(0.2)])
    assert np.abs(made.shear.tractions).max() > 100.0
    np.testing.assert_allclose(sums(made, skin), 0.0, atol=1e-12)


def test_newly_touched_points_start_without_shear():
    skin = bar_skin(400, finer=2)
    made = model(skin)
    made.pressures([ball(0.1, (1.2, 0.0))])
    made.pressures([ball(0.3)])
    assert not made.shear.tractions.any()


def test_returning_contact_starts_without_shear():
    skin = bar_skin(400, finer=2)
    made = model(skin)
    made.pressures([ball(0.2, (1.2, 0.0))])
    made.pressures([])
    made.pressures([ball(0.2)])
    assert not made.shear.tractions.any()


@pytest.mark.parametrize("shear", [(0.7, 0.0), (-0.5, 0.9), (1.5, 0.0)])
def test_sum_of_traction_times_area_is_the_shear_of_all_loads(shear):
    skin = bar_skin(400, finer=2)
    made = model(skin)
    made.pressures([ball(0.1, shear), ball(0.3, (0.2, -0.1), force=5.0)])
    np.testing.assert_allclose(sums(made, skin), np.add(shear, (0.2, -0.1)), atol=1e-11)
    assert made.shear.loads[0].usage == pytest.approx(np.hypot(*shear) / 1.5)
