"""A single function opens every kind of input as a skin, or raises a clear error."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tactile_maps.core.errors import SkinError, TactileMapsError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.skin.model.skin_file import save_skin
from tactile_maps.skin.open import SkinOptions, open_skin
from tactile_maps.skin.taxel_placement.placement import BoundaryZone, PlacementSpec
from tests.support.surfaces import frustum, sheet, skin_of

FEW = PlacementSpec(taxels=40)


@pytest.fixture
def skin():
    return skin_of(sheet(), frustum())


@pytest.fixture
def ball(tmp_path):
    path = tmp_path / "ball.stl"
    trimesh.creation.icosphere(subdivisions=3, radius=0.1).export(path)
    return path


def test_saved_skin_or_map_is_opened_unchanged(skin, tmp_path):
    save_skin(skin, tmp_path / "skin.npz")
    save_map(build_map(skin), tmp_path / "map.npz")
    for name in ("skin.npz", "map.npz"):
        opened = open_skin(tmp_path / name)
        np.testing.assert_array_equal(opened.areas, skin.areas)


@pytest.mark.long
def test_taxels_of_a_bare_mesh_are_on_its_faces_or_on_a_cover(ball):
    own = open_skin(ball, SkinOptions(FEW))
    cover = open_skin(ball, SkinOptions(FEW, surface="cover", thickness=0.005))
    assert len(own) == len(cover) == 40
    radius = [np.linalg.norm(skin.patches[0].taxels.positions, axis=1).max() for skin in (own, cover)]
    assert radius[0] <= 0.1 + 1e-6
    assert radius[1] > 0.103


@pytest.mark.long
def test_cover_follows_pitch_and_pattern(ball):
    skin = open_skin(ball, SkinOptions(PlacementSpec(pitch=0.03, pattern="hexagonal"), surface="cover"))
    (patch,) = skin.patches
    assert patch.surface.area / len(patch.taxels) == pytest.approx(np.sqrt(3) / 2 * 0.03**2, rel=0.01)


@pytest.mark.long
def test_placements_that_a_cover_does_not_support_are_rejected():
    for placement in (
        PlacementSpec(taxels=300, density=np.ones(8)),
        PlacementSpec(taxels=300, keep_out=(BoundaryZone(0.01),)),
    ):
        with pytest.raises(SkinError, match="no keep-out zones and no painted density"):
            open_skin("arm", SkinOptions(placement))
    with pytest.raises(SkinError, match=r"unknown surface.*lower"):
        SkinOptions(surface="lower")


@pytest.mark.parametrize("name", ["nowhere.npz", "nowhere.csv", "nowhere.obj", "nowhere.urdf", "nobody"])
def test_missing_sources_are_named(name):
    with pytest.raises(TactileMapsError, match=name):
        open_skin(name)
