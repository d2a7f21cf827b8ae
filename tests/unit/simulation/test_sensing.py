"""Water-fill: force in is force out, where the finger is."""

from __future__ import annotations

import numpy as np
import pytest

from app.simulation.loads import Load
from app.simulation.sensing import FOUNDATION, WaterFill, fill
from tests.touch import arm, bar_skin, pair

SKIN = bar_skin()
UP = np.array([0.0, 0.0, 1.0])
FELT = WaterFill(SKIN)


def press(point, force=5.0, radius=0.008, *, link="bar", normal=UP):
    return Load(link, np.asarray(point, dtype=float), normal, force, radius)


def test_level_of_water_by_hand():
    assert fill(np.array([0.0, 1.0, 4.0]), np.ones(3), 1.0) == pytest.approx(1.0)
    assert fill(np.array([4.0, 0.0, 1.0]), np.ones(3), 3.0) == pytest.approx(2.0)
    assert fill(np.array([0.0, 1.0, 4.0]), np.array([1.0, 2.0, 3.0]), 1e6) == pytest.approx((1e6 + 14) / 6)


def test_a_sphere_on_a_flat_bed_sinks_as_winkler_says():
    """F = π K R d² for a shallow sphere: the peak pressure is K d, and the touched area 2 π R d."""
    skin, force, radius = bar_skin(1500, finer=4), 60.0, 0.05
    pressures = WaterFill(skin).pressures([press((0.2, 0, 0.02), force, radius)])
    depth = np.sqrt(force / (np.pi * FOUNDATION * radius))
    assert 0.9 < pressures.max() / (FOUNDATION * depth) < 1.05, "a taxel averages over its area"
    half = pressures > 0.5 * FOUNDATION * depth  # where the sphere is half as deep: half the area
    assert skin.areas[half].sum() == pytest.approx(np.pi * radius * depth, rel=0.15)


def test_pressure_is_under_the_finger():
    force = FELT.pressures([press((0.12, 0.02, 0.02))]) * SKIN.areas
    centre = force @ SKIN.patches[0].taxels.positions / force.sum()
    assert np.linalg.norm(centre - [0.12, 0.02, 0.02]) < 0.012


def test_loads_add_up():
    one, other = press((0.1, 0, 0.02)), press((0.11, 0, 0.02), 2.0)
    assert FELT.pressures([one, other]) == pytest.approx(FELT.pressures([one]) + FELT.pressures([other]), rel=1e-12)
    assert FELT.pressures([one, other]) @ SKIN.areas == pytest.approx(7.0, rel=1e-12)


def test_beside_the_skin_the_nearest_point_takes_it_but_farther_off_nothing_does():
    beside = FELT.pressures([press((-0.005, 0, 0.02), radius=0.002)])
    assert beside @ SKIN.areas == pytest.approx(5.0, rel=1e-12)
    assert np.count_nonzero(beside) == 1
    assert not FELT.pressures([press((-0.2, 0, 0.02))]).any()


def test_other_links_and_no_loads_are_not_felt():
    assert not FELT.pressures([]).any()
    assert not FELT.pressures([press((0.2, 0, 0.02), 0.0)]).any()
    assert not FELT.pressures([press((0.2, 0, 0.02), link="elsewhere")]).any()
    _, skin = pair()
    load = press((0.05, 0, 0), link="left", normal=np.array([1.0, 0, 0]))
    pressures = WaterFill(skin).pressures([load])
    assert pressures[: skin.first[1]].any()
    assert not pressures[skin.first[1] :].any()


def test_the_far_side_of_a_thin_link_does_not_feel():
    skin = arm().skin
    taxels = skin.patches[1].taxels
    load = Load("forearm", taxels.positions[10], taxels.normals[10], 8.0, 0.2)
    pressed = WaterFill(skin).pressures([load])[skin.first[1] : skin.first[2]] > 0
    assert pressed.any()
    assert (taxels.normals[pressed] @ taxels.normals[10] > 0).all()
