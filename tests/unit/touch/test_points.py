"""A skin's quadrature points in one row."""

from __future__ import annotations

import numpy as np

from app.skin.skin import Skin
from app.touch.points import skin_points
from tests.touch import pair


def test_they_come_patch_after_patch_and_name_the_skins_taxels():
    _, skin = pair()
    points, second = skin_points(skin), skin.patches[1].taxels.quadrature
    assert len(skin.patches) == 2
    np.testing.assert_array_equal(points.positions[-len(second.areas) :], second.positions)
    np.testing.assert_array_equal(points.taxel[-len(second.areas) :], second.taxel + skin.first[1])
    np.testing.assert_allclose(np.bincount(points.taxel, points.areas), skin.areas, rtol=1e-12)
    assert np.linalg.norm(points.normals, axis=1).min() > 0.99


def test_a_bare_robot_has_none():
    assert skin_points(Skin(())).positions.shape == (0, 3)
