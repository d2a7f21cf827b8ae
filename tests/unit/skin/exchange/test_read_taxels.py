from __future__ import annotations

import pytest

from app.errors import SkinError
from app.skin.exchange.read import read_taxel_sets, read_taxels
from app.skin.exchange.write import write_taxels
from tests.unit.skin.exchange.taxels_by_hand import dome


@pytest.mark.parametrize("ending", [".txt", ".csv", ".npz", ".json", ".urdf"])
@pytest.mark.parametrize("named", [True, False])
def test_the_ending_or_the_content_finds_the_reader(tmp_path, ending, named):
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


def test_several_links_must_be_chosen_from(tmp_path):
    path = tmp_path / "skin.csv"
    write_taxels([dome(), dome(5, link="arm")], path)
    assert [taxels.link for taxels in read_taxel_sets(path)] == ["hand", "arm"]
    assert len(read_taxels(path, link="arm")) == 5
    with pytest.raises(SkinError, match=r"skin\.csv.*several links.*Choose one of: hand, arm"):
        read_taxels(path)
    with pytest.raises(SkinError, match=r"no such link.*leg.*Choose one of: hand, arm"):
        read_taxels(path, link="leg")


def test_a_layout_alone_is_not_enough(tmp_path):
    with pytest.raises(SkinError, match="states no places.*positions file"):
        read_taxels(tmp_path / "left_arm.ini")


@pytest.mark.parametrize("name", ["nowhere.txt", "nowhere.csv", "nowhere.npz", "nowhere.json", "nowhere.urdf", "no"])
def test_missing_files_are_named(tmp_path, name):
    with pytest.raises(SkinError, match=f"{name}.*cannot be read"):
        read_taxels(tmp_path / name)
