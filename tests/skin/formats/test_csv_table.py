from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats import csv_table
from tactile_maps.skin.formats.csv_table import read_table, write_table
from tactile_maps.skin.formats.vendors import documents
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import assert_equal, dome
from tests.support.findings import kinds


def written(tmp_path, text, name="left_part.csv"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t", " , "])
def test_any_separator_and_column_order_are_read(tmp_path, separator):
    rows = ["# by hand", "taxel,Z, X ,y,module,u_mm,v,weight", "", "7,.3,1e-1,0.2,1,12,0.5,heavy", "2,0,0,0.1,0,-3,0,"]
    (taxels,) = read_table(written(tmp_path, "\r\n".join(rows).replace(",", separator)))
    assert (taxels.name, taxels.link, taxels.normals) == ("left_part", None, None)
    assert taxels.numbers.tolist() == [7, 2]
    assert taxels.modules.tolist() == [1, 0]
    assert taxels.positions.tolist() == [[0.1, 0.2, 0.3], [0, 0.1, 0]]
    np.testing.assert_allclose(taxels.points, [[0.012, 0.5], [-0.003, 0]], atol=1e-15)
    assert kinds(taxels.findings) == {"unknown-column": 1, "millimetres": 1}


def test_table_without_header_contains_positions_or_positions_and_normals(tmp_path):
    (bare,) = read_table(written(tmp_path, "0,0,0.1\n0.2,0,0\n"))
    assert bare.positions.tolist() == [[0, 0, 0.1], [0.2, 0, 0]]
    assert (bare.normals, bare.numbers.tolist()) == (None, [0, 1])
    (full,) = read_table(written(tmp_path, "0;0;0.1;0;0;2\n0.2;0;0;1;0;0"))
    assert full.normals.tolist() == [[0, 0, 1], [1, 0, 0]]
    assert kinds(full.findings) == {"normals-not-unit": 1}


@pytest.mark.parametrize(
    "heading",
    [
        "x_mm,y_mm,z_mm,nx,ny,nz,id,module,area_mm2,link",
        "x [mm],y [mm],z [mm],n_x,n_y,n_z,taxel_id,module_id,area [mm²],body",
        "X (mm), Y (mm) ,Z ( mm ),Normal X,Normal Y,Normal Z,Hardware ID,Board,Area (mm^2),Link name",
        "pos_x/mm,pos_y/mm,pos_z/mm,normal_x,normal_y,normal_z [-],sensor_id,board_id,taxel_area_mm2,frame_id",
    ],
)
def test_common_spellings_of_headings_are_recognized(tmp_path, heading):
    (taxels,) = read_table(written(tmp_path, f"{heading}\n10,0,-5,0,0,1,7,3,30,arm\n20,5,0,1,0,0,8,3,25,arm\n"))
    np.testing.assert_allclose(taxels.positions, [[0.01, 0, -0.005], [0.02, 0.005, 0]], atol=1e-15)
    assert taxels.normals.tolist() == [[0, 0, 1], [1, 0, 0]]
    assert (taxels.ids.tolist(), taxels.modules.tolist(), taxels.link) == ([7, 8], [3, 3], "arm")
    np.testing.assert_allclose(taxels.areas, [30e-6, 25e-6])
    assert kinds(taxels.findings) == {"millimetres": 3}


@pytest.mark.parametrize(("unit", "metres"), [("m", 1), ("cm", 1e-2), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)])
def test_units_in_the_heading_are_applied(tmp_path, unit, metres):
    (taxels,) = read_table(written(tmp_path, f"x [{unit}],y_{unit},z ({unit})\n1,2,3\n"))
    np.testing.assert_allclose(taxels.positions, metres * np.array([[1, 2, 3]]), rtol=1e-12)


def test_missing_units_are_assumed_only_if_metres_are_impossible(tmp_path):
    rows = "\n".join(f"{5 * k},{(k % 2) * 4},0,20" for k in range(6))
    (far,) = read_table(written(tmp_path, f"x,y,z,area\n{rows}\n"))
    np.testing.assert_allclose(far.positions[1], [0.005, 0.004, 0])
    np.testing.assert_allclose(far.areas, 20e-6)
    assert [(f.kind, f.count) for f in far.findings] == [("guessed-unit", 6), ("guessed-unit", 6)]
    assert "neighbouring taxels would be 6.4 m apart" in far.findings[0].action
    for heading in ("x_m,y,z,area_m2", "x,y_m,z,area_m2"):  # one stated unit says what is meant
        with pytest.raises(SkinError, match="positions are in metres"):
            read_table(written(tmp_path, f"{heading}\n{rows}\n"))
    (near,) = read_table(written(tmp_path, "x,y,z\n0.1,0,0\n0.2,0,0\n0.3,0,0\n0.4,0,0\n"))
    assert (near.positions[0, 0], near.findings) == (0.1, ())


def test_areas_are_written_and_read_back(tmp_path):
    taxels = dome(areas=np.linspace(1e-6, 9e-6, 12))
    write_table([taxels], tmp_path / "t.csv")
    (back,) = read_table(tmp_path / "t.csv")
    np.testing.assert_array_equal(back.areas, taxels.areas)
    assert len(taxels.select(np.arange(12) < 5).areas) == 5
    assert not {"guessed-unit", "millimetres"} & set(kinds(back.findings))


def test_incomplete_areas_are_not_used(tmp_path):
    (taxels,) = read_table(written(tmp_path, "x,y,z,area_mm2\n0,0,0,5\n0.01,0,0,\n0.02,0,0,0\n"))
    assert taxels.areas is None
    assert kinds(taxels.findings) == {"area-unknown": 2}


def test_links_become_sets(tmp_path):
    text = "x,y,z,link,taxel\n0,0,1,l hand,5\n0,0,2, arm ,5\n0,0,3,l hand,6\n0,0,4,,1\n"
    sets = read_table(written(tmp_path, text))
    assert [(taxels.name, taxels.link, taxels.numbers.tolist()) for taxels in sets] == [
        ("l hand", "l hand", [5, 6]),
        ("arm", "arm", [5]),
        ("left_part", None, [1]),
    ]


def test_incomplete_normals_are_dropped_and_incomplete_map_points_kept(tmp_path):
    text = "x,y,z,nx,ny,nz,u,v\n0,0,1,0,0,1,,\n0,0,2,,,,0.1,0.2\n"
    (taxels,) = read_table(written(tmp_path, text))
    assert taxels.normals is None
    assert taxels.mapped.tolist() == [False, True]
    assert kinds(taxels.findings) == {"dummy-normals": 1}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no rows"),
        ("# only this\n", "no rows"),
        ("x,y,z\n", "no rows below"),
        ("x,y\n0,0\n", "line 1.*missing.*z"),
        ("x,y,z,nx\n0,0,0,1\n", "line 1.*missing.*ny, nz"),
        ("x,y,z,u\n0,0,0,1\n", "line 1.*missing.*v"),
        ("x,y,z,x_mm\n0,0,0,1\n", "line 1.*x is duplicated"),
        ("0,0\n", "columns are missing.*2 columns.*line of names"),
        ("0,0,0,0\n", "columns are missing.*4 columns"),
        ("x,y,z\n0,0,0\n0,0\n", "line 3.*must have 3 cells"),
        ("x,y,z\n0,,0\n", "line 2.*y must be a number"),
        ("x;y;z\n0;0,5;0\n", "line 2, column y: the table uses decimal commas.*0,5.*Replace them by decimal points"),
        ("0,01;0;0\n", "line 1: the table uses decimal commas.*0,01"),
        ("x;y;z\n0;0.5mm;0\n", "line 2.*y must be a number with a decimal point.*0.5mm"),
        ("time,100,l_hand:101\n0,5,6\n", "line 1: the table has readings, not taxels.*File > Connect"),
        ("a,b,c\n0,0,0\n", r"line 1: columns are missing: x, y, z \(found: a, b, c\)"),
        ("x_in,y_in,z_in\n0,0,0\n", r"columns are missing: x, y, z \(found: x_in.*known units: m, cm, mm"),
        ("x,y,z\n0,nan,0\n", "line 2.*y is not a finite"),
        ("x,y,z\n0,0,-inf\n", "line 2.*z is not a finite"),
        ("x,y,z\n30,0,0\n", "positions are in metres"),
        ("x,y,z,taxel\n0,0,0,-1\n", "line 2.*taxel must be a whole number.*-1"),
        ("x,y,z,taxel\n0,0,0,1.5\n", "line 2.*taxel must be a whole number"),
        ("x,y,z,module\n0,0,0,1e12\n", "line 2.*module must be a whole number"),
        ("x,y,z,taxel\n0,0,0,1\n0,0,0,\n", "line 3.*taxel must be a number"),
        ("x [in],y,z\n0,0,0\n", r"line 1, column x \[in\].*unit of x is not known.*in.*Choose one of: m, cm, mm"),
        ("x_mm,y_mm,z_raw\n0,0,0\n", "line 1.*column is missing.*z.*with a unit as in x_mm"),
        ("x_mm,y_mm,z_mm\n0,zero,0\n", "line 2, column y_mm.*y must be a number.*zero.*Correct the cell"),
        ("0,0,0\n1,b,0\n", r"line 2, column 2 \(y\).*y must be a number.*b"),
        ("x,y,z,u,v\n0,0,0,1,\n", "map point"),
        ('x,y,z\n0,0,"0\n', "cannot be parsed"),
        ('x,y,z\n0,0,"0\n0,0,0"\n', "quoted cell runs over"),
    ],
)
def test_invalid_tables_are_rejected_with_line_and_value(tmp_path, text, problem):
    with pytest.raises(SkinError, match=f"left_part.csv.*{problem}"):
        read_table(written(tmp_path, text))


def test_implausible_sizes_are_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr(documents, "MAX_TAXELS", 3)
    with pytest.raises(SkinError, match="more than 3 rows"):
        read_table(written(tmp_path, "0,0,0\n" * 5))
    monkeypatch.setattr(csv_table, "MAX_LINKS", 1)
    with pytest.raises(SkinError, match="column body: the table names more than 1 links.*found: 2"):
        read_table(written(tmp_path, "x,y,z,body\n0,0,0,a\n0,0,1,b\n0,0,2,a\n"))


def test_round_trip_keeps_taxels(tmp_path):
    first = dome()
    points = first.points.copy()
    points[3] = np.nan
    sets = (
        dome(points=points),
        dome(link="left  arm\n2", normals=None, modules=None, points=None, numbers=np.arange(12)),
    )
    write_table(sets, tmp_path / "out.csv")
    back = read_table(tmp_path / "out.csv")
    for one, other in zip(sets, back, strict=True):
        assert_equal(one, other)
    assert [taxels.link for taxels in back] == ["hand", "left arm 2"]
    assert [taxels.findings for taxels in back] == [(), ()]
    assert (tmp_path / "out.csv").read_text().startswith("x_m,y_m,z_m,nx,ny,nz,u_m,v_m,taxel,module,link\n")


def test_only_known_columns_are_written(tmp_path):
    write_table([TaxelSet("one", None, np.array([4]), np.array([[0.1, 0, 0]]))], tmp_path / "out.csv")
    assert (tmp_path / "out.csv").read_text() == "x_m,y_m,z_m,taxel\n0.1,0.0,0.0,4\n"
