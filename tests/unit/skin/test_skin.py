from __future__ import annotations

import numpy as np
import pytest

from app.skin.place import place_taxels
from app.skin.skin import Patch, Skin
from tests.numerics.hard_meshes import HARD_MESHES


def two_patches() -> Skin:
    ball, tube = HARD_MESHES["sphere"], HARD_MESHES["open tube"]
    return Skin((Patch("ball", "a", ball, place_taxels(ball, 5)), Patch("tube", "b", tube, place_taxels(tube, 7))))


def test_taxels_are_numbered_through_the_patches() -> None:
    skin = two_patches()
    assert len(skin) == 12
    assert skin.first.tolist() == [0, 5, 12]
    assert skin.patch_of.tolist() == [0] * 5 + [1] * 7
    assert skin.areas.sum() == pytest.approx(sum(patch.surface.area for patch in skin.patches))
    assert (skin.patch_of[skin.neighbours[:, 0]] == skin.patch_of[skin.neighbours[:, 1]]).all()


def test_a_taxel_is_a_surface_point_with_position_normal_and_link() -> None:
    skin = two_patches()
    at = skin.taxel_point(6)
    assert (at.patch, skin.link(at)) == (1, "b")
    assert skin.position(at) == pytest.approx(skin.patches[1].taxels.positions[1], abs=1e-12)
    assert skin.normal(at) == pytest.approx(skin.patches[1].taxels.normals[1], abs=1e-12)


def test_a_skin_without_patches_is_a_value_too() -> None:
    skin = Skin(())
    assert len(skin) == 0
    assert (skin.areas.shape, skin.neighbours.shape) == ((0,), (0, 2))
    assert np.array_equal(skin.first, [0])
