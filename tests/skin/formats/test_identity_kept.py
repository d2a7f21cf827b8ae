"""Ids, modules and channels through every format: from a file to a skin, and from the skin to a file."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.export import write_map
from tactile_maps.maps.formats.map_file import load_map
from tactile_maps.maps.formats.svg import svg
from tactile_maps.skin.formats.icub.layout import apply_layout, read_icub_layout
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.npz import read_taxel_npz
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels, taxel_sets, write_taxels
from tactile_maps.skin.model.skin import IDENTITY_FIELDS, LARGEST_NUMBER, Skin, TaxelIdentity
from tactile_maps.skin.model.skin_file import skin_from_bytes, skin_to_bytes
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.open import open_skin
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels
from tactile_widgets.document.taxel_search import find_taxels
from tests.support.example_taxels import assert_equal, dome, strip
from tests.support.findings import kinds
from tests.support.real_icub import LAYOUTS, POSITIONS, needs_files
from tests.support.surfaces import frustum, sheet, skin_of

HARD = np.array([LARGEST_NUMBER, 0, 87012, 86999, 5, 5, 2**24 + 1, 7, 5, 11, 12, 10])
"""Ids at both ends, not sorted, with gaps, repeated, and one that single precision rounds."""
KEPT = {
    ".csv": IDENTITY_FIELDS,
    ".tsv": IDENTITY_FIELDS,
    ".npz": IDENTITY_FIELDS,
    ".json": IDENTITY_FIELDS,
    ".urdf": ("ids",),
}


def hard(**changes):
    return dome(numbers=np.arange(12), ids=HARD, modules=HARD % 17, channels=HARD % 12, **changes)


def identified():
    """A skin on two links, whose boards number their taxels alike."""
    skin = skin_of(sheet(6, 5), frustum(around=12, along=5), taxels=12)
    identity = TaxelIdentity(HARD, HARD % 17, HARD % 12)
    return Skin(tuple(replace(p, taxels=replace(p.taxels, identity=identity)) for p in skin.patches))


@pytest.mark.parametrize("ending", [".csv", ".json", ".npz", ".txt"])
def test_format_keeps_further_ids_at_a_place(tmp_path, ending):
    ids = np.arange(20, 32)
    taxels = dome(numbers=np.arange(12), ids=ids, aliases=np.array([[3, 5], [1, 5], [7, 0]]))
    write_taxels(taxels, tmp_path / f"set{ending}")
    back = read_taxels(tmp_path / f"set{ending}")
    found = {(number, int(back.ids[row])) for number, row in back.aliases.tolist()}
    merged = {frozenset(pair) for pair in found}
    expected = [{1, 25}, {3, 25}, {7, 20}] if ending != ".txt" else [{1, 3}, {1, 25}, {7, 20}]
    assert merged == set(map(frozenset, expected))


@pytest.mark.parametrize("ending", [".csv", ".json", ".npz"])
def test_format_keeps_the_length_of_the_stream(tmp_path, ending):
    write_taxels(hard(stream=384), tmp_path / f"set{ending}")
    assert read_taxels(tmp_path / f"set{ending}").stream == 384
    write_taxels(hard(), tmp_path / f"other{ending}")
    assert read_taxels(tmp_path / f"other{ending}").stream is None


def test_contradictory_stream_length_is_rejected(tmp_path):
    path = tmp_path / "set.csv"
    path.write_text("x,y,z,id,stream\n0,0,0.1,4,384\n0.1,0,0,5,300\n0,0.1,0,6,384\n")
    with pytest.raises(SkinError, match=r"line 3, column stream: stream must be the same for all taxels.*384.*300"):
        read_taxels(path)
    write_taxels(hard(), tmp_path / "set.json")
    document = json.loads((tmp_path / "set.json").read_text())
    document["skin"]["stream"] = -1
    (tmp_path / "set.json").write_text(json.dumps(document))
    with pytest.raises(SkinError, match=r"skin, stream.*positive whole number.*-1"):
        read_taxels(tmp_path / "set.json")


@pytest.mark.parametrize(("ending", "problem"), [(".csv", "line 2, column aliases"), (".json", "skin, taxel 0")])
def test_invalid_further_ids_are_rejected_with_their_place(tmp_path, ending, problem):
    text = "x,y,z,id,aliases\n0,0,0.1,4,5 -6\n0.1,0,0,5,\n0,0.1,0,6,\n"
    if ending == ".json":
        entry = {"id": 4, "x": [0.0, 0.0, 0.1], "type": 0, "cut": 0, "aliases": [5, -6]}
        others = [{"id": k, "x": [0.1 * k, 0.0, 0.0], "type": 0, "cut": 0} for k in (5, 6)]
        text = json.dumps({"info": {"file_version": 2}, "skin": {"taxels": [entry, *others], "faces": []}})
    path = tmp_path / f"set{ending}"
    path.write_text(text)
    with pytest.raises(SkinError, match=problem):
        read_taxels(path)


@pytest.mark.parametrize("ending", [ending for ending in KEPT if ending != ".tsv"])
def test_format_keeps_unusual_ids(tmp_path, ending):
    write_taxels(hard(), tmp_path / f"set{ending}")
    back = read_taxels(tmp_path / f"set{ending}")
    assert_equal(hard(), back, arrays=KEPT[ending], atol=0)
    assert len(np.unique(back.numbers)) == 12
    assert kinds(back.findings) == ({} if ending in (".csv", ".npz") else {"duplicate-number": 2})


def test_positions_file_stores_ids_as_rows_and_reports_what_it_cannot_store(tmp_path):
    ids = np.array([1999, 3, 40, 41, 52, 55, 60, 61, 62, 63, 65, 12])
    write_taxels(dome(numbers=np.arange(12), ids=ids, modules=None), tmp_path / "set.txt")
    back = read_taxels(tmp_path / "set.txt")
    assert back.ids.tolist() == sorted(ids.tolist())
    assert (back.modules == back.ids // 12).all()
    assert (back.channels == back.ids % 12).all()
    with pytest.raises(SkinError, match=r"its row.*2147483647.*\.csv"):
        write_taxels(hard(), tmp_path / "hard.txt")
    with pytest.raises(SkinError, match=r"its row.*3-4 are repeated.*\.csv"):
        write_taxels(dome(numbers=np.arange(12), ids=[3, 3, 4, 4, *range(5, 13)]), tmp_path / "hard.txt")


@pytest.mark.parametrize("ending", [".csv", ".npz", ".json"])
def test_format_keeps_names(tmp_path, ending):
    named = hard(names=tuple(f"thumb, cell {row // 2}" for row in range(12)))
    write_taxels(named, tmp_path / f"set{ending}")
    assert read_taxels(tmp_path / f"set{ending}").names == named.names
    write_taxels(hard(), tmp_path / f"bare{ending}")
    assert read_taxels(tmp_path / f"bare{ending}").names is None


def test_names_are_kept_by_skin_and_map_and_find_their_taxels(tmp_path):
    names = tuple("Tip" if row < 3 else f"cell {row}" for row in range(12))
    identity = TaxelIdentity(HARD, names=names)
    skin = identified()
    first, *others = skin.patches
    skin = Skin((replace(first, taxels=replace(first.taxels, identity=identity)), *others))
    again = skin_from_bytes(skin_to_bytes(skin))
    assert again.patches[0].taxels.identity.names == names
    assert again.patches[1].taxels.identity.names is None
    assert again.taxels_named("tip").tolist() == [0, 1, 2]
    assert str(again.taxel_name(3)) == f"cell 3, id {HARD[3]}"
    assert taxel_sets(again)[0].names == names
    assert find_taxels(again, "TIP").taxels.tolist() == [0, 1, 2]


@pytest.mark.long
@pytest.mark.parametrize("ending", [".csv", ".npz", ".urdf"])
def test_skin_of_two_boards_keeps_the_ids_of_each(tmp_path, ending):
    write_taxels(identified(), tmp_path / f"skin{ending}")
    for back, taxels in zip(read_taxel_sets(tmp_path / f"skin{ending}"), taxel_sets(identified()), strict=True):
        assert_equal(taxels, back, arrays=KEPT[ending], atol=0)


def test_skin_without_ids_is_written_with_taxel_numbers(tmp_path):
    skin = skin_of(sheet(6, 5), taxels=4)
    for ending in (".csv", ".json", ".urdf"):
        write_taxels(skin, tmp_path / f"skin{ending}")
        assert read_taxels(tmp_path / f"skin{ending}").ids.tolist() == [0, 1, 2, 3]
    assert "id" not in (tmp_path / "skin.csv").read_text().splitlines()[0].split(",")


def test_table_states_ids_and_numbers(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("x,y,z,taxel,id,module,channel\n0,0,0,1,87012,14,3\n1,0,0,0,86999,13,\n")
    with pytest.raises(SkinError, match="line 3.*channel"):
        read_taxels(table)
    table.write_text("x,y,z,taxel,id,module,channel\n0,0,0,1,87012,14,3\n1,0,0,0,86999,13,0\n")
    taxels = read_taxels(table)
    assert (taxels.numbers.tolist(), taxels.ids.tolist()) == ([1, 0], [87012, 86999])
    assert (taxels.modules.tolist(), taxels.channels.tolist()) == ([14, 13], [3, 0])
    table.write_text("x,y,z,id\n0,0,0,2147483648\n")
    with pytest.raises(SkinError, match="line 2.*2147483648"):
        read_taxels(table)
    table.write_text("x,y,z,id\n0,0,0,7\n1,0,0,7\n")
    taxels = read_taxels(table)
    assert (taxels.numbers.tolist(), taxels.ids.tolist(), kinds(taxels.findings)) == (
        [0, 1],
        [7, 7],
        {"duplicate-number": 1},
    )


def test_npz_without_ids_uses_its_numbers_and_rejects_invalid_ones(tmp_path):
    np.savez(tmp_path / "t.npz", positions=np.eye(3), numbers=np.array([9, 9, 4]))
    (taxels,) = read_taxel_npz(tmp_path / "t.npz")
    assert (taxels.ids.tolist(), taxels.numbers.tolist()) == ([9, 9, 4], [0, 1, 2])
    np.savez(tmp_path / "t.npz", positions=np.eye(3))
    assert read_taxel_npz(tmp_path / "t.npz")[0].ids is None
    for values, problem in ((np.ones(3), "wrong shape or type"), (np.array([1, -2, 3]), "row 1.*negative.*-2")):
        np.savez(tmp_path / "t.npz", positions=np.eye(3), channels=values)
        with pytest.raises(SkinError, match=f"t.npz.*channels.*{problem}"):
            read_taxel_npz(tmp_path / "t.npz")


def test_genoa_format_omits_modules_unless_every_taxel_has_one(tmp_path):
    write_taxels(hard(), tmp_path / "t.json")
    document = json.loads((tmp_path / "t.json").read_text())
    assert [document["skin"]["taxels"][0][key] for key in ("id", "module", "channel")] == [2147483647, 8, 7]
    del document["skin"]["taxels"][3]["module"]
    (tmp_path / "t.json").write_text(json.dumps(document))
    taxels = read_taxels(tmp_path / "t.json")
    assert (taxels.modules, taxels.channels.tolist()) == (None, (HARD % 12).tolist())
    assert kinds(taxels.findings) == {"duplicate-number": 2, "module-unknown": 11}


def test_layout_finds_its_taxels_by_id():
    taxels, layout = strip()
    turned = TaxelSet("strip", "arm", np.arange(len(taxels)), taxels.positions[::-1], ids=taxels.numbers[::-1])
    joined = apply_layout(turned, layout)
    plain = apply_layout(taxels, layout)
    np.testing.assert_array_equal(joined.points, plain.points[::-1])
    assert_equal(joined, replace(turned, modules=turned.ids // 12, channels=turned.ids % 12), arrays=IDENTITY_FIELDS)


@pytest.mark.long
@pytest.mark.parametrize("ending", [".csv", ".npz", ".json"])
def test_ids_are_kept_from_file_through_skin_and_map_to_file(tmp_path, ending):
    """Through patches in another order than the file's, a map of them, and out again."""
    far = dome().positions + np.where(np.arange(12) < 4, 0.5, 0.0)[:, None]
    ids = 86999 + 13 * ((5 * np.arange(12)) % 12)
    write_taxels(
        dome(numbers=np.arange(12), positions=far, ids=ids, modules=ids // 12, channels=ids % 12, points=None),
        tmp_path / f"in{ending}",
    )
    skin = open_skin(tmp_path / f"in{ending}")
    assert len(skin.patches) > 1
    write_map(build_map(skin), tmp_path / "map.npz")
    map_ = load_map(tmp_path / "map.npz")
    for target in (".csv", ".json"):
        write_map(map_, tmp_path / f"out{target}")
        back = read_taxels(tmp_path / f"out{target}")
        assert sorted(back.ids.tolist()) == sorted(ids.tolist())
        for k, number in enumerate(ids.tolist()):
            (row,) = np.flatnonzero(back.ids == number)
            np.testing.assert_allclose(back.positions[row], far[k], atol=1e-9)
            assert (back.modules[row], back.channels[row]) == divmod(number, 12)
    drawn = svg(map_).decode()
    assert all(f">{number}</text>" in drawn for number in ids.tolist())


@needs_files
@pytest.mark.parametrize(
    ("name", "count", "last", "modules"),
    [("left_arm", 350, 767, 35), ("left_forearm_V2", 148, 355, 24), ("torso", 373, 755, 44)],
)
def test_real_files_keep_their_rows(tmp_path, name, count, last, modules):
    """Every id is the row of the file that holds the taxel's place, in the skin, a table and on the drawn layout."""
    path = POSITIONS / f"{name}.txt"
    taxels = read_icub_positions(path)
    rows = np.array(
        [words for line in path.read_text().splitlines() if len(words := line.split()) == 6 and "(" not in line], float
    )
    np.testing.assert_array_equal(rows[taxels.ids, :3], taxels.positions)
    assert (len(taxels), int(taxels.ids.max()), len(np.unique(taxels.modules))) == (count, last, modules)
    np.testing.assert_array_equal(12 * taxels.modules + taxels.channels, taxels.ids)
    skin = skin_from_taxels(taxels)
    assert sorted(skin.identity.ids.tolist()) == taxels.ids.tolist()
    write_taxels(skin, tmp_path / "t.csv")
    assert read_taxels(tmp_path / "t.csv").ids.tolist() == skin.identity.ids.tolist()
    layout = {"left_arm": "left_arm_V2_7"}.get(name, name)
    drawn = apply_layout(taxels, read_icub_layout(LAYOUTS / f"{layout}.ini"))
    np.testing.assert_array_equal(drawn.ids, taxels.ids)
