from __future__ import annotations

import numpy as np
import pytest

from app.errors import SkinError
from app.geometry.topology import euler_characteristic
from app.skin.exchange.read import read_taxel_sets, read_taxels
from app.skin.exchange.write import taxel_sets, write_taxels
from app.skin.skin import Patch, Skin
from tests.numerics.map_surfaces import frustum, named, skin_of
from tests.unit.skin.exchange.taxels_by_hand import assert_equal, dome

SKIN = skin_of(frustum(along=12, around=24), named("saddle"), taxels=60)
POINTS = np.random.default_rng(3).uniform(0, 0.4, (120, 2))


@pytest.mark.parametrize("ending", [".csv", ".npz", ".urdf"])
def test_a_skin_on_several_links(tmp_path, ending):
    write_taxels(SKIN, tmp_path / f"skin{ending}", points=POINTS)
    sets = read_taxel_sets(tmp_path / f"skin{ending}")
    assert [taxels.link for taxels in sets] == ["link 0", "link 1"]
    for patch, first, taxels in zip(SKIN.patches, SKIN.first, sets, strict=False):
        np.testing.assert_array_equal(taxels.numbers, first + np.arange(60))
        np.testing.assert_array_equal(taxels.positions, patch.taxels.positions)
        np.testing.assert_allclose(taxels.normals, patch.taxels.normals, atol=1e-14)
        if ending != ".urdf":
            np.testing.assert_array_equal(taxels.points, POINTS[first : first + 60])


@pytest.mark.parametrize("ending", [".txt", ".json"])
def test_formats_for_one_link_refuse_two(tmp_path, ending):
    with pytest.raises(SkinError, match=rf"skin\{ending}.*one link.*link 0, link 1.*\.csv, \.npz, \.urdf"):
        write_taxels(SKIN, tmp_path / f"skin{ending}")
    assert not list(tmp_path.iterdir())


def test_patches_of_one_link_are_one_set():
    patches = tuple(Patch(patch.name, "arm", patch.surface, patch.taxels) for patch in SKIN.patches)
    (taxels,) = taxel_sets(Skin(patches), points=POINTS)
    assert (taxels.name, taxels.link, len(taxels)) == ("arm", "arm", 120)
    np.testing.assert_array_equal(taxels.points, POINTS)


def test_genoa_gets_a_mesh_over_the_taxels(tmp_path):
    tube = skin_of(frustum(along=16, around=32), taxels=150)
    write_taxels(tube, tmp_path / "tube.json")
    taxels = read_taxels(tmp_path / "tube.json")
    assert euler_characteristic(taxels.faces) == 0
    a, b, c = (taxels.positions[taxels.faces[:, k]] for k in range(3))
    outward = (np.cross(b - a, c - a) * taxels.normals[taxels.faces[:, 0]]).sum(axis=1)
    assert (outward > 0).all()


def test_a_set_keeps_what_the_format_has_a_place_for(tmp_path):
    taxels = dome(faces=np.array([[0, 1, 2]]))
    kept = {
        ".csv": ("numbers", "positions", "normals", "points", "modules"),
        ".npz": ("numbers", "positions", "normals", "points", "modules", "faces"),
        ".json": ("numbers", "positions", "normals", "points", "faces"),
        ".urdf": ("numbers", "positions", "normals"),
    }
    for ending, arrays in kept.items():
        write_taxels(taxels, tmp_path / f"set{ending}")
        assert_equal(taxels, read_taxels(tmp_path / f"set{ending}"), arrays=arrays)


def test_what_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(SkinError, match=r"set\.pcd.*cannot be written as this.*\.pcd.*Choose one of"):
        write_taxels(dome(), tmp_path / "set.pcd")
    with pytest.raises(SkinError, match="no taxels to write"):
        write_taxels([], tmp_path / "set.csv")
    with pytest.raises(SkinError, match=r"set\.csv.*differ in number.*3 and 12"):
        write_taxels(dome(), tmp_path / "set.csv", points=np.zeros((3, 2)))
    with pytest.raises(SkinError, match="cannot be written.*folder"):
        write_taxels(dome(), tmp_path / "no" / "set.csv")
