"""Reading and writing taxels by the file's ending."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels, taxel_sets, write_taxels
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.open import open_skin
from tests.support.example_taxels import dome
from tests.support.surfaces import frustum, named, skin_of


def test_table_without_a_suffix_may_be_utf_16(tmp_path):
    path = tmp_path / "taxels"
    path.write_bytes("x\ty\tz\n0.1\t0.2\t0.3\n".encode("utf-16"))
    (taxels,) = read_taxel_sets(path)
    assert taxels.positions.tolist() == [[0.1, 0.2, 0.3]]


@pytest.mark.parametrize("ending", [".txt", ".csv", ".npz", ".json", ".urdf"])
@pytest.mark.parametrize("named", [True, False])
def test_format_follows_from_suffix_or_content(tmp_path, ending, named):
    path = tmp_path / f"patch{ending}"
    write_taxels(dome(), path)
    if not named:
        path = path.rename(tmp_path / "patch.unknown")
    taxels = read_taxels(path)
    assert (len(taxels), taxels.link) == (12, "hand")


@pytest.mark.parametrize(
    ("text", "link"),
    [
        ("name arm\n0 0 0.1\n", "arm"),
        ("name left,arm\n0 0 0.1\n", "left,arm"),
        ("0 0 0.1\n", None),
        ("0\t0\t0.1\n", None),
        ("// old\n0 0 0.1 0 0 1\n", None),
        ("# new\nX_mm\ty\tz\n0\t0\t0.1\n", None),
        ("0, 0, 0.1\n", None),
        ("x;y;z;link\n0;0;0.1;arm\n", "arm"),
    ],
)
def test_text_is_a_positions_file_or_a_table(tmp_path, text, link):
    (tmp_path / "patch.txt").write_text(text)
    taxels = read_taxels(tmp_path / "patch.txt")
    assert taxels.positions.tolist() == [[0, 0, 0.1]]
    assert taxels.link == link


def test_taxels_of_several_links_are_not_one_set(tmp_path):
    path = tmp_path / "skin.csv"
    write_taxels([dome(), dome(5, link="arm")], path)
    assert [taxels.link for taxels in read_taxel_sets(path)] == ["hand", "arm"]
    with pytest.raises(SkinError, match=r"skin\.csv.*several links.*hand, arm.*Give a file"):
        read_taxels(path)


def test_layout_alone_is_a_flat_skin(tmp_path):
    path = tmp_path / "left_arm.ini"
    path.write_text("[SENSORS]\ntriangle_10pad 2 0 0 0 1\ntriangle_10pad 3 40 0 90 1\n")
    taxels = read_taxels(path)
    assert (len(taxels), taxels.link, {finding.kind for finding in taxels.findings}) == (20, None, {"map-only"})
    assert {30, 34} & {*taxels.ids.tolist()} == set()  # thermal pads
    np.testing.assert_array_equal(taxels.positions, np.column_stack([taxels.points, np.zeros(20)]))
    np.testing.assert_allclose(np.ptp(taxels.positions, axis=0)[0], 0.04, atol=0.025)
    assert len(open_skin(path)) == 20


@pytest.mark.parametrize("ending", [".xlsx", ".ods"])
def test_spreadsheet_is_rejected_with_the_columns_to_save(tmp_path, ending):
    path = tmp_path / f"taxels{ending}"
    path.write_bytes(b"PK")
    with pytest.raises(SkinError, match=r"a spreadsheet cannot be opened.*CSV with the columns x_mm, y_mm, z_mm"):
        open_skin(path)


@pytest.mark.parametrize("name", ["nowhere.txt", "nowhere.csv", "nowhere.npz", "nowhere.json", "nowhere.urdf", "no"])
def test_missing_files_are_named(tmp_path, name):
    with pytest.raises(SkinError, match=f"{name}.*cannot be read"):
        read_taxels(tmp_path / name)


SKIN = skin_of(frustum(along=12, around=24), named("saddle"), taxels=60)
POINTS = np.random.default_rng(3).uniform(0, 0.4, (120, 2))


@pytest.mark.parametrize("ending", [".csv", ".npz", ".urdf"])
def test_skin_on_several_links_is_read(tmp_path, ending):
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
def test_formats_for_one_link_reject_two(tmp_path, ending):
    with pytest.raises(SkinError, match=rf"skin\{ending}.*one link.*link 0, link 1.*\.csv, \.npz, \.urdf"):
        write_taxels(SKIN, tmp_path / f"skin{ending}")
    assert not list(tmp_path.iterdir())


def test_patches_of_one_link_are_one_set():
    patches = tuple(Patch(patch.name, "arm", patch.surface, patch.taxels) for patch in SKIN.patches)
    (taxels,) = taxel_sets(Skin(patches), points=POINTS)
    assert (taxels.name, taxels.link, len(taxels)) == ("arm", "arm", 120)
    np.testing.assert_array_equal(taxels.points, POINTS)


def test_genoa_format_contains_a_mesh_over_the_taxels(tmp_path):
    tube = skin_of(frustum(along=16, around=32), taxels=150)
    write_taxels(tube, tmp_path / "tube.json")
    taxels = read_taxels(tmp_path / "tube.json")
    assert Connectivity(taxels.faces).euler_characteristic == 0
    a, b, c = (taxels.positions[taxels.faces[:, k]] for k in range(3))
    outward = (np.cross(b - a, c - a) * taxels.normals[taxels.faces[:, 0]]).sum(axis=1)
    assert (outward > 0).all()


def test_invalid_output_is_rejected(tmp_path):
    with pytest.raises(SkinError, match=r"set\.pcd.*cannot be saved in this format.*\.pcd.*Choose one of"):
        write_taxels(dome(), tmp_path / "set.pcd")
    with pytest.raises(SkinError, match="no taxels to write"):
        write_taxels([], tmp_path / "set.csv")
    with pytest.raises(SkinError, match=r"set\.csv.*differ in number.*3 and 12"):
        write_taxels(dome(), tmp_path / "set.csv", points=np.zeros((3, 2)))
    with pytest.raises(SkinError, match="cannot be written.*folder"):
        write_taxels(dome(), tmp_path / "no" / "set.csv")
