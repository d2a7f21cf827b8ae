from __future__ import annotations

import pytest

from app.errors import MapError
from app.maps.exchange import obj_file
from app.maps.exchange.obj_file import read_obj

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def read(tmp_path, text):
    (tmp_path / "map.obj").write_text(text)
    return read_obj(tmp_path / "map.obj")


def test_all_spellings_of_a_corner(tmp_path):
    text = SQUARE + "mtllib x.mtl\nvn 0 0 1\ng lower part\nf 1/1/1 2/2/1 3/3/1\no upper\ns off\nf -4/-4 -2/-2 -1/-1\n"
    obj = read(tmp_path, text)
    assert obj.surface.faces.tolist() == obj.corners.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert obj.surface.area == 1
    assert (obj.groups, obj.group_of.tolist()) == (("lower part", "upper"), [0, 1])
    assert (obj.square, obj.findings) == (None, ())


def test_polygons_are_split_and_counted(tmp_path):
    obj = read(tmp_path, SQUARE + "# origin 0.1 -0.2 m, side 0.5 m\nf 1/1 2/2 3/3 4/4\n")
    assert obj.surface.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert [(f.kind, f.count) for f in obj.findings] == [("polygon", 1)]
    assert obj.group_of.tolist() == [-1, -1]
    assert obj.square == (0.1, -0.2, 0.5)


def test_a_vertex_may_carry_more_than_its_place(tmp_path):
    obj = read(tmp_path, "v 0 0 0 1.0 0.5 0\nv 1 0 0 1\nv 0 1 0\nvt 0 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    assert obj.surface.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert obj.uv.tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no faces"),
        (SQUARE, "no faces"),
        ("v 0 0\n", "line 1.*3 finite numbers.*0 0"),
        ("v 0 0 x\n", "line 1.*not a number"),
        ("v 0 0 nan\n", "line 1.*3 finite numbers"),
        ("v 0 0 1e30\n", "line 1.*3 finite numbers"),
        ("vt 0\n", "line 1.*2 finite numbers"),
        (SQUARE + "f 1 2 3\n", "line 9.*no texture coordinate.*Unwrap"),
        (SQUARE + "f 1//1 2//1 3//1\n", "line 9.*no texture coordinate"),
        (SQUARE + "f 1/1 2/2\n", "line 9.*three corners"),
        (SQUARE + "f 1/1 2/2 x/3\n", "line 9.*vertex/texture.*x/3"),
        (SQUARE + "f 1/1 2/2 5/3\n", "line 9.*does not come before.*5/3"),
        (SQUARE + "f 1/1 2/2 3/9\n", "line 9.*does not come before"),
        (SQUARE + "f 1/1 2/2 -5/3\n", "line 9.*does not come before"),
        (SQUARE + "f 1/1 2/2 0/3\n", "line 9.*does not come before"),
        (SQUARE + "f" + " 1/1" * 2000 + "\n", "line 9.*three corners"),
        ("# origin 0 0 m, side nan m\n", "line 1"),
    ],
)
def test_broken_files_are_refused_with_line_and_value(tmp_path, text, problem):
    with pytest.raises(MapError, match=rf"map\.obj.*{problem}"):
        read(tmp_path, text)


def test_absurd_sizes_and_missing_files_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(obj_file, "MAX_LINES", 5)
    with pytest.raises(MapError, match="more than 5 lines"):
        read(tmp_path, SQUARE)
    with pytest.raises(MapError, match=r"nowhere\.obj.*cannot be read"):
        read_obj(tmp_path / "nowhere.obj")
