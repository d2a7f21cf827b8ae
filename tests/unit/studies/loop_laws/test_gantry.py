"""The plate of skin on three slides: what it is, and what its map says."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.studies.loop_laws.gantry import MASS, gantry


def test_every_joint_moves_the_plate_alike():
    made = gantry()
    configuration = Configuration(made.robot)
    assert configuration.inertia() == pytest.approx([MASS] * 3, rel=1e-5)
    assert configuration.jacobian("plate", np.zeros(3)) == pytest.approx(np.eye(3))


def test_the_map_is_the_plate_and_the_middle_its_origin():
    made = gantry()
    taxels = made.skin.patches[0].taxels
    assert made.map.taxel_points == pytest.approx(taxels.positions[:, :2])
    assert np.abs(taxels.positions[:, 2]).max() == 0
    assert made.believed.skin is made.skin


@pytest.mark.parametrize("stretch", [1.0, 2.0, 5.0])
def test_a_stretched_map_keeps_areas(stretch):
    points = gantry(stretch=stretch).map.taxel_points / gantry().map.taxel_points
    assert points == pytest.approx(np.tile([stretch**0.5, stretch**-0.5], (len(points), 1)))


def test_a_turned_belief_has_the_same_taxels_on_the_same_map():
    made = gantry(turn=30.0)
    true = made.map.skin.patches[0].taxels
    believed = made.believed.skin.patches[0].taxels
    assert np.array_equal(true.faces, believed.faces)
    assert np.array_equal(made.map.taxel_points, made.believed.taxel_points)
    c = np.cos(np.pi / 6)
    s = np.sin(np.pi / 6)
    turned = true.positions[:, :2] @ np.array([[c, s], [-s, c]])
    assert believed.positions[:, :2] == pytest.approx(turned)
    assert believed.quadrature.areas.sum() == pytest.approx(0.12**2)
