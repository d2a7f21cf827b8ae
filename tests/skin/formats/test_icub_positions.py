"""iCub positions files: rows and importer, on files written here with each defect and on real ones where at hand."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError, SkinError
from tactile_maps.skin.formats.icub import positions as icub_positions
from tactile_maps.skin.formats.icub.positions import (
    read_icub_positions,
    read_position_rows,
    write_icub_positions,
)
from tactile_maps.skin.formats.import_skin import TaxelFile
from tactile_maps.skin.formats.npz import read_taxel_npz, write_taxel_npz
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_robots import two_rods
from tests.support.example_taxels import dome
from tests.support.findings import kinds
from tests.support.real_icub import POSITIONS, needs_files


def text_file(tmp_path, text):
    path = tmp_path / "left_part.txt"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_header_taxel_list_and_rows_are_read(tmp_path):
    text = "name\t l_part\r\nspatial_sampling taxel\r\ntaxel2Repr ( 1 1 -2\t-1 )\r\n[calibration]\r\n"
    rows = read_position_rows(text_file(tmp_path, text + "0.1 0.2 0.3\t1 0 0\r\n\r\n0 0 0 0 0 0 \r\n"))
    assert rows.name == "l_part"
    assert rows.representatives is not None
    assert rows.representatives.tolist() == [1, 1, -2, -1]
    assert rows.values.tolist() == [[0.1, 0.2, 0.3, 1, 0, 0], [0, 0, 0, 0, 0, 0]]


def test_rows_with_comments_and_no_final_newline_are_read(tmp_path):
    rows = read_position_rows(text_file(tmp_path, "// made by hand\n# too\n0 0 0.1\n1e-2 -.5 0.2"))
    assert (rows.name, rows.representatives) == (None, None)
    assert rows.values.tolist() == [[0, 0, 0.1], [0.01, -0.5, 0.2]], "the last row counts"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no taxel rows"),
        ("name part\n", "no taxel rows"),
        ("0 0 1\n0 0\n", "line 2.*3 or 6 numbers.*found: 0 0"),
        ("0 0 1\n0 0 1 2\n", "line 2.*3 or 6"),
        ("0 0 1\n0 0 1 0 0 1\n", "line 2.*have 3 numbers"),
        ("0 0 1\n0 x 1\n", "line 2.*3 or 6.*0 x 1"),
        ("0 0 1\nxyz 0 1\n", "line 2.*3 or 6"),
        ("0 0 nan\n", "line 1.*not finite"),
        ("0 0 1\n0 inf 1\n", "line 2.*not finite"),
        ("30.8 66.9 23.5\n", "line 1.*positions are in metres.*30.8"),
        ("taxel2Repr 1 2 3\n0 0 1\n", "line 1.*list in brackets"),
        ("taxel2Repr ( 1 two )\n0 0 1\n", "line 1.*taxel number.*two"),
        ("taxel2Repr ( -3 )\n0 0 1\n", "taxel number.*-3"),
        ("taxel2Repr ( --1 )\n0 0 1\n", "taxel number.*--1"),
        ("taxel2Repr ( 99999999999999999999 )\n0 0 1\n", "taxel number"),
        ("taxel2Repr ( 0 7 )\n0 0 1\n", "does not exist.*7"),
        (b"\x80\x04\x95pickle\x00\n", "no taxel rows"),
    ],
)
def test_invalid_files_are_rejected_with_line_and_value(tmp_path, text, problem):
    with pytest.raises(SkinError, match=f"left_part.txt.*{problem}"):
        read_position_rows(text_file(tmp_path, text))


def test_implausible_sizes_are_rejected(tmp_path, monkeypatch):
    path = text_file(tmp_path, "0 0 1\n" * 20)
    monkeypatch.setattr(icub_positions, "MAX_ROWS", 10)
    with pytest.raises(SkinError, match="line 11.*more than 10 rows"):
        read_position_rows(path)
    with pytest.raises(SkinError, match="more than 10 entries"):
        read_position_rows(text_file(tmp_path, f"taxel2Repr ( {'1 ' * 11})\n0 0 1\n"))
    monkeypatch.setattr(icub_positions, "MAX_BYTES", 10)
    with pytest.raises(SkinError, match="too large"):
        read_position_rows(path)


def module(number=0, *, normal="0 0 1"):
    """Twelve rows: a grid of pads 6 mm apart on the upper rod's side, the thermal pads included."""
    rows = []
    for pad in range(12):
        angle = 0.15 * (pad % 4)
        height = 0.1 + 0.006 * (pad // 4) + 0.02 * number
        rows.append(f"{0.04 * np.cos(angle):.5f}\t{0.04 * np.sin(angle):.5f} {height:.5f}   {normal}")
    return rows


def positions_file(tmp_path, rows, *, header="", end="\n"):
    path = tmp_path / "left_rod.txt"
    path.write_bytes((header + end.join(rows) + end).encode())
    return path


def test_file_of_rows_only_drops_the_thermal_pads_and_keeps_the_last_row(tmp_path):
    taxels = read_icub_positions(positions_file(tmp_path, module() + module(1), end="\r\n"))
    assert taxels.link is None
    assert taxels.numbers.tolist() == [0, 1, 2, 3, 4, 5, 7, 8, 9, 11, 12, 13, 14, 15, 16, 17, 19, 20, 21, 23]
    assert kinds(taxels.findings) == {"thermal-pad": 4, "dummy-normals": 20}
    assert taxels.normals is None


def test_list_takes_precedence_over_the_position_of_the_pad(tmp_path):
    listed = "taxel2Repr ( 3 3 3 3 3 3 3 3 3 3 -1 -1 )\n"
    taxels = read_icub_positions(positions_file(tmp_path, module(), header="name upper\n" + listed))
    assert taxels.link == "upper"
    assert taxels.numbers.tolist() == list(range(10))
    assert kinds(taxels.findings)["thermal-pad"] == 1
    assert kinds(taxels.findings)["unfitted-taxel"] == 1


def test_every_other_defect_is_counted(tmp_path):
    rows = module() + module(1)
    rows[3] = rows[2]
    rows[5] = "0 0 0 0 0 0"
    listed = f"taxel2Repr ( {'3 ' * 30})\n"
    findings = kinds(read_icub_positions(positions_file(tmp_path, rows, header=listed)).findings)
    assert findings == {
        "list-length": 6,
        "unused-row": 1,
        "missing-position": 1,
        "duplicate-taxel": 1,
        "dummy-normals": 22,
    }


def test_rows_at_one_place_are_aliases_and_rows_count_as_a_stream(tmp_path):
    rows = module() + module(1)
    rows[3] = rows[2]
    rows[4] = rows[2]
    taxels = read_icub_positions(positions_file(tmp_path, rows))
    assert taxels.stream == 24
    assert taxels.aliases.tolist() == [[3, 2], [4, 2]]
    assert taxels.ids.tolist()[:4] == [0, 1, 2, 5]
    half = taxels.select(taxels.ids > 1)
    assert (half.aliases.tolist(), half.stream) == ([[3, 0], [4, 0]], 24)
    write_icub_positions(taxels, tmp_path / "again.txt")
    again = read_icub_positions(tmp_path / "again.txt")
    assert (again.ids.tolist(), again.aliases.tolist()) == (taxels.ids.tolist(), taxels.aliases.tolist())
    assert again.stream == 36, "the original program loses the last row, so that rows were appended"
    write_taxel_npz([taxels], tmp_path / "again.npz")
    (again,) = read_taxel_npz(tmp_path / "again.npz")
    assert (again.aliases.tolist(), again.stream) == ([[3, 2], [4, 2]], 24)


def test_normals_of_a_real_file_are_kept_with_unit_length(tmp_path):
    taxels = read_icub_positions(positions_file(tmp_path, module() + module(1, normal="2 0 0")))
    assert taxels.normals is not None
    assert np.linalg.norm(taxels.normals, axis=1) == pytest.approx(1.0)
    assert kinds(taxels.findings)["normals-not-unit"] == 10


def test_positions_without_normals_are_accepted(tmp_path):
    rows = [" ".join(row.split()[:3]) for row in module()]
    assert read_icub_positions(positions_file(tmp_path, rows)).normals is None


def test_file_without_taxels_is_rejected(tmp_path):
    with pytest.raises(SkinError, match="no usable taxel"):
        read_icub_positions(positions_file(tmp_path, ["0 0 0 0 0 0"] * 12))


@pytest.mark.long
def test_taxels_keep_their_positions_on_the_link(tmp_path):
    path = positions_file(tmp_path, module() + module(1), header="name upper\n")
    skin = TaxelFile(path).skin(two_rods(), thickness=0.002)
    assert [(patch.name, patch.link, len(patch.taxels)) for patch in skin.patches] == [("upper", "upper", 20)]
    taxels = skin.patches[0].taxels
    stated = read_icub_positions(path).positions
    assert np.linalg.norm(taxels.positions - stated, axis=1).max() < 0.004
    assert (taxels.areas > 0).all()
    # The area of a taxel extends at most about one pitch around it.
    assert taxels.areas.max() < np.pi * 0.009**2
    assert kinds(skin.findings)["taxel-distance"] == 20


@pytest.mark.long
def test_unknown_link_must_be_replaced_by_one_of_the_robot(tmp_path):
    path = positions_file(tmp_path, module(), header="name arm\n")
    with pytest.raises(SkinError, match="found: arm.*Choose one of: base, upper"):
        TaxelFile(path).skin(two_rods())
    assert TaxelFile(path).skin(two_rods(), links=("upper",)).patches[0].link == "upper"


def test_missing_link_must_be_chosen(tmp_path):
    path = positions_file(tmp_path, module())
    with pytest.raises(SkinError, match="does not name its link"):
        TaxelFile(path).skin(two_rods())
    with pytest.raises(RobotError, match="unknown link"):
        TaxelFile(path).skin(two_rods(), links=("elbow",))


@needs_files
def test_real_files_have_the_known_contents():
    arm = read_icub_positions(POSITIONS / "left_arm.txt")
    assert (arm.link, len(arm.positions), arm.normals) == ("l_upper_arm", 350, None)
    assert kinds(arm.findings) == {"list-length": 192, "unused-row": 418, "dummy-normals": 350}
    assert arm.numbers[-1] == 767, "the row that the original reader drops"
    forearm = read_icub_positions(POSITIONS / "left_forearm_V2.txt")
    assert (forearm.link, len(forearm.positions)) == ("l_forearm", 148)
    assert kinds(forearm.findings)["duplicate-taxel"] == len(forearm.aliases) == 240 - 148
    assert (forearm.stream, arm.stream) == (384, 768)
    torso = read_icub_positions(POSITIONS / "torso.txt")
    assert kinds(torso.findings)["thermal-pad"] == 88
    assert len(torso.positions) + kinds(torso.findings)["duplicate-taxel"] == 440


def test_written_file_is_read_back_sorted_by_row(tmp_path):
    taxels = dome()
    write_icub_positions(taxels, tmp_path / "dome.txt")
    back = read_icub_positions(tmp_path / "dome.txt")
    order = np.argsort(taxels.numbers)
    assert (back.name, back.link) == ("dome", "hand")
    np.testing.assert_array_equal(back.numbers, taxels.numbers[order])
    np.testing.assert_array_equal(back.positions, taxels.positions[order])
    np.testing.assert_allclose(back.normals, taxels.normals[order], atol=1e-15)
    np.testing.assert_array_equal(back.modules, back.numbers // 12)
    assert set(kinds(back.findings)) == {"unused-row"}
    text = (tmp_path / "dome.txt").read_text().splitlines()
    assert text[:2] == ["name hand", "spatial_sampling taxel"]
    assert text[-1] == "0.0 0.0 0.0 0.0 0.0 0.0", "the original reader loses the last row"
    assert len(text) == 4 + 12 * (83 // 12 + 2)


def test_middle_pad_represents_its_module_or_else_the_first(tmp_path):
    taxels = TaxelSet("two", None, np.array([3, 7, 6, 14, 13]), np.eye(5, 3) + [0, 0, 1])
    write_icub_positions(taxels, tmp_path / "two.txt")
    rows = read_position_rows(tmp_path / "two.txt")
    assert rows.name is None
    assert rows.representatives is not None
    assert rows.representatives[:24].tolist() == [
        -1,
        -1,
        -1,
        3,
        -1,
        -1,
        3,
        3,
        -1,
        -1,
        -2,
        -1,
        -1,
        13,
        13,
        -1,
        -1,
        -1,
        -2,
        -1,
        -1,
        -1,
        -2,
        -1,
    ]


def test_taxels_that_rows_cannot_store_are_rejected(tmp_path):
    with pytest.raises(SkinError, match="its row in this format.*100000.*Renumber"):
        write_icub_positions(TaxelSet("far", None, np.array([100_000]), np.ones((1, 3))), tmp_path / "far.txt")
    with pytest.raises(SkinError, match="would read as unused"):
        write_icub_positions(TaxelSet("zero", None, np.array([0]), np.zeros((1, 3))), tmp_path / "zero.txt")


def test_common_normal_is_valid_for_taxels_in_a_plane(tmp_path):
    flat = ["0.01 0.02 0.1 0 0 2", "0.02 0.02 0.1 0 0 2", "0.02 0.03 0.1005 0 0 2"]
    taxels = read_icub_positions(positions_file(tmp_path, flat))
    assert taxels.normals is not None
    assert taxels.normals.tolist() == [[0, 0, 1]] * 3
    assert kinds(taxels.findings) == {"normals-not-unit": 3}
    assert read_icub_positions(positions_file(tmp_path, [*flat, "0.03 0.03 0.11 0 0 2"])).normals is None


def test_taxels_with_three_axes_are_rejected_with_the_formats_that_keep_them(tmp_path):
    taxels = TaxelSet("pad", None, np.arange(2), np.ones((2, 3)), axes=np.array([1, 3]))
    with pytest.raises(
        SkinError, match=r"pad\.txt: this format has no axes of taxels.*1 taxels with three axes.*\.csv"
    ):
        write_icub_positions(taxels, tmp_path / "pad.txt")
    assert not (tmp_path / "pad.txt").exists()
