"""The values of a skin: read-only taxels, numbered through the patches."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.hard_cases.meshes import HARD_MESHES
from tests.support.touch import bar_skin


def test_arrays_are_read_only_and_counted():
    one = np.array([[0.0, 0, 1]])
    quadrature = Quadrature(one, one, np.ones(1), np.zeros(1))
    taxels = Taxels(one, one, np.zeros(1), one, np.ones(1), np.zeros((0, 2)), quadrature)
    assert len(taxels) == 1
    assert taxels.faces.dtype == np.int64
    with pytest.raises(ValueError, match="read-only"):
        taxels.areas[0] = 2
    with pytest.raises(ValueError, match="read-only"):
        quadrature.areas[0] = 2


def two_patches():
    ball = HARD_MESHES["sphere"]
    tube = HARD_MESHES["open tube"]
    return Skin((Patch("ball", "a", ball, place_evenly(ball, 5)), Patch("tube", "b", tube, place_evenly(tube, 7))))


def test_taxels_are_numbered_consecutively_over_patches():
    skin = two_patches()
    assert len(skin) == 12
    assert skin.first.tolist() == [0, 5, 12]
    assert skin.patch_of.tolist() == [0] * 5 + [1] * 7
    assert skin.areas.sum() == pytest.approx(sum(patch.surface.area for patch in skin.patches))
    assert (skin.patch_of[skin.neighbours[:, 0]] == skin.patch_of[skin.neighbours[:, 1]]).all()


def test_taxel_is_a_surface_point_with_position_normal_and_link():
    skin = two_patches()
    at = skin.taxel_point(6)
    assert (at.patch, skin.link(at)) == (1, "b")
    assert skin.position(at) == pytest.approx(skin.patches[1].taxels.positions[1], abs=1e-12)
    assert skin.normal(at) == pytest.approx(skin.patches[1].taxels.normals[1], abs=1e-12)


def test_skin_without_patches_is_valid():
    skin = Skin(())
    assert len(skin) == 0
    assert (skin.areas.shape, skin.neighbours.shape) == ((0,), (0, 2))
    assert np.array_equal(skin.first, [0])


@pytest.mark.parametrize("taxel", [-1, 60])
def test_unknown_taxel_is_rejected_with_the_range(taxel):
    with pytest.raises(SkinError, match=f"unknown taxel.*{taxel}.*Choose 0 to 59"):
        bar_skin(60).taxel_point(taxel)
