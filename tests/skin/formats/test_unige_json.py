"""The format of the University of Genoa: the newer form with maps, the older one, and everything that may be wrong."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats.taxel_files import read_taxels
from tactile_maps.skin.formats.unige_json import UnigeFile, UnigeMap, read_unige, write_unige
from tests.support.example_taxels import assert_equal, dome
from tests.support.findings import kinds


def entry(number, place, **more):
    return {"id": number, "x": place, "type": "pressure", "cut": 0} | more


DOCUMENT = {
    "info": {"file_version": 2, "type": "rigid_body", "name": "H01"},
    "skin": {
        "n_taxels": 4,
        "n_faces": 2,
        "parent_frames": [{"key": 0, "id": 0, "type": "ROS", "name": "handle", "tf_matrix": np.eye(4).tolist()}],
        "taxels": [entry(n, [0.01 * k, 0.02, 0], n=[0, 0, 1]) for k, n in enumerate([31, 32, 33, 34])],
        "faces": [[0, 1, 2], [1, 3, 2]],
    },
    "tactile_maps": [
        {
            "key": 0, "name": "unrolled", "type": "2D", "description": "by hand", "n_taxels": 3, "n_faces": 1,
            "taxels": [entry(n, [0.01 * k, 0.5]) for k, n in enumerate([34, 31, 32])],
            "faces": [[0, 1, 2]],
        }
    ],
}  # fmt: skip


def read(tmp_path, *changes, document=DOCUMENT):
    """The file with ``changes``, each a path of keys and the value there."""
    document = copy.deepcopy(document)
    for *keys, last, value in changes:
        part = document
        for key in keys:
            part = part[key]
        part[last] = value
    (tmp_path / "skin.json").write_text(json.dumps(document))
    return read_unige(tmp_path / "skin.json")


def test_skin_and_its_map_are_read(tmp_path):
    file = read(tmp_path)
    taxels = file.taxels
    assert (taxels.name, taxels.link, taxels.findings) == ("H01", "handle", ())
    assert taxels.numbers.tolist() == [31, 32, 33, 34]
    assert taxels.faces.tolist() == [[0, 1, 2], [1, 3, 2]]
    np.testing.assert_allclose(taxels.positions[3], [0.03, 0.02, 0])
    (drawn,) = file.maps
    assert (drawn.name, drawn.description, drawn.taxels.tolist()) == ("unrolled", "by hand", [3, 0, 1])
    shown = file.with_points()
    np.testing.assert_array_equal(shown.mapped, [True, True, False, True])
    np.testing.assert_allclose(shown.points[[0, 1, 3]], [[0.01, 0.5], [0.02, 0.5], [0, 0.5]])
    assert kinds(shown.findings) == {"not-on-map": 1}


def test_older_format_without_maps_is_read(tmp_path):
    skin = {key: value for key, value in DOCUMENT["skin"].items() if key != "parent_frames"}
    skin["taxels"] = [skin["taxels"][:3], skin["taxels"][3:]]
    document = {"skin": skin | {"parent_frame": {"type": "ROS", "name": "tfh1"}}}
    file = read(tmp_path, document=document)
    assert (file.taxels.name, file.taxels.link, len(file.taxels), file.maps) == ("skin", "tfh1", 4, ())


TURN = np.array([[0.0, -1, 0, 0.1], [1, 0, 0, 0.2], [0, 0, 1, -0.3], [0, 0, 0, 1]])


@pytest.mark.parametrize("stated", [TURN.tolist(), TURN.T.ravel().tolist(), TURN.ravel().tolist()])
def test_skin_s_pose_in_its_frame_is_applied(tmp_path, stated):
    file = read(tmp_path, ("skin", "parent_frames", 0, "tf_matrix", stated), ("skin", "taxels", 1, "n", [1, 0, 0]))
    np.testing.assert_allclose(file.taxels.positions[3], [0.1 - 0.02, 0.2 + 0.03, -0.3], atol=1e-12)
    np.testing.assert_allclose(file.taxels.normals[1], [0, 1, 0], atol=1e-12)
    (note,) = file.taxels.findings
    assert (note.kind, "rotated by 90.0 deg, moved by 374.2 mm" in note.action) == ("frame-transform", True)


def test_rotation_with_few_digits_does_not_scale(tmp_path):
    rounded = [0.7071, 0.7071, 0, 0, -0.7071, 0.7071, 0, 0, 0, 0, 1, 0, 0, 0, 0.024, 1]
    file = read(tmp_path, ("skin", "parent_frames", 0, "tf_matrix", rounded))
    sides = np.linalg.norm(file.taxels.positions - [0, 0, 0.024], axis=1)
    np.testing.assert_allclose(sides, np.hypot(0.01 * np.arange(4), 0.02), rtol=1e-12)


@pytest.mark.parametrize("stated", [np.diag([1.0, 1, -1, 1]).tolist(), [1.0] * 16, [[1, 0], [0, 1]], "none", None])
def test_invalid_pose_is_ignored_with_a_finding(tmp_path, stated):
    file = read(tmp_path, ("skin", "parent_frames", 0, "tf_matrix", stated))
    np.testing.assert_allclose(file.taxels.positions[3], [0.03, 0.02, 0])
    assert kinds(file.taxels.findings) == ({} if stated is None else {"frame-transform": 1})


def test_millimetres_are_recognised_with_a_finding(tmp_path):
    places = [entry(n, [5.0 * k, 2.0 * (k % 2), 0], n=[0, 0, 1]) for k, n in enumerate([31, 32, 33, 34])]
    drawn = [entry(n, [50.0 * k, 2.0 * (k % 2)]) for k, n in enumerate([34, 31, 32])]
    file = read(tmp_path, ("skin", "taxels", places), ("tactile_maps", 0, "taxels", drawn))
    np.testing.assert_allclose(file.taxels.positions[3], [0.015, 0.002, 0])
    np.testing.assert_allclose(file.maps[0].points[2], [0.1, 0])
    assert [(f.kind, f.count) for f in file.taxels.findings] == [("guessed-unit", 4), ("guessed-unit", 3)]


def test_stated_unit_is_not_guessed(tmp_path):
    places = [entry(n, [5.0 * k, 2.0 * (k % 2), 0]) for k, n in enumerate([31, 32, 33, 34])]
    for unit, metres in (("m", 1.0), ("mm", 1e-3)):
        file = read(tmp_path, ("info", "unit", unit), ("skin", "taxels", places[:2]), ("skin", "faces", []))
        np.testing.assert_allclose(file.taxels.positions[1], [5.0 * metres, 2.0 * metres, 0])
        assert "guessed-unit" not in kinds(file.taxels.findings)


def test_single_map_may_be_given_without_a_list(tmp_path):
    file = read(tmp_path, ("tactile_maps", DOCUMENT["tactile_maps"][0]))
    assert (len(file.maps), file.maps[0].name, file.taxels.findings) == (1, "unrolled", ())


@pytest.mark.parametrize(
    ("document", "found"),
    [
        ({"points": [[0.0, 0.0, 0.01]], "unit": "m"}, "points, unit"),
        ({}, "an empty object"),
        ([[0.0, 0.0, 0.01]], "a list"),
    ],
)
def test_json_of_unknown_layout_is_rejected_with_columns_and_mapping_file(tmp_path, document, found):
    path = tmp_path / "points.json"
    path.write_text(json.dumps(document))
    with pytest.raises(SkinError) as refused:
        read_unige(path)
    assert str(refused.value) == (
        f"{path}: the layout of taxels in this JSON file is unknown (found: {found}). Write CSV with the columns x_mm, "
        "y_mm, z_mm (and nx, ny, nz, id, link), or name its fields in points.json.mapping.toml next to it; "
        "tactile-maps inspect points.json --mapping prints a template."
    )
    csv = path.with_suffix(".csv")
    csv.write_text("x_mm,y_mm,z_mm,nx,ny,nz\n0,0,10,0,0,1\n5,0,10,0,0,1\n0,5,10,0,0,1\n")
    np.testing.assert_allclose(read_taxels(csv).positions[1], [0.005, 0, 0.01])


def test_map_without_a_skin_is_a_flat_skin_with_a_finding(tmp_path):
    alone = {"tactile_maps": copy.deepcopy(DOCUMENT["tactile_maps"][0]) | {"faces": [[0, 2, 1]]}}
    file = read(tmp_path, document=alone)
    taxels = file.taxels
    assert (taxels.name, taxels.link, taxels.ids.tolist()) == ("skin", None, [34, 31, 32])
    np.testing.assert_allclose(taxels.positions, [[0, 0.5, 0], [0.01, 0.5, 0], [0.02, 0.5, 0]])
    np.testing.assert_array_equal(taxels.normals, [[0, 0, 1]] * 3)
    np.testing.assert_allclose(file.with_points().points, taxels.positions[:, :2])
    assert kinds(taxels.findings) == {"map-only": 3}
    assert "'unrolled'" in taxels.findings[0].action


def test_flat_skin_faces_up_without_taxels_lacking_an_id_and_with_repeated_ids(tmp_path):
    places = [entry(n, [10.0 * (k % 3), 7.0 * (k // 3)]) for k, n in enumerate([-1, 5, 6, 7, 5, 9])]
    alone = {"tactile_maps": [{"name": "m", "taxels": places, "faces": [[1, 4, 2], [0, 1, 3], [4, 5, 2]]}]}
    file = read(tmp_path, document=alone)
    assert file.taxels.ids.tolist() == [5, 6, 7, 5, 9]
    assert file.maps[0].taxels.tolist() == [0, 1, 2, 3, 4]
    np.testing.assert_allclose(file.taxels.positions[4], [0.02, 0.007, 0])
    a, b, c = (file.taxels.positions[file.taxels.faces[:, k]] for k in range(3))
    assert len(a) == 2
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    assert kinds(file.taxels.findings) == {
        "map-only": 5,
        "taxel-without-id": 1,
        "duplicate-number": 1,
        "guessed-unit": 6,
        "unknown-taxel": 1,
    }


def test_repeated_numbers_are_matched_in_order(tmp_path):
    ids = [7, 8, 7, 9]
    changes = [("skin", "taxels", k, "id", number) for k, number in enumerate(ids)]
    places = [entry(n, [0.1 * k, 0.0]) for k, n in enumerate([9, 7, 8, 7])]
    whole = ("tactile_maps", 0, "taxels", places), ("tactile_maps", 0, "n_taxels", 4)
    file = read(tmp_path, *changes, *whole)
    assert file.taxels.numbers.tolist() == [0, 1, 2, 3]
    assert file.maps[0].taxels.tolist() == [3, 0, 1, 2]
    assert kinds(file.taxels.findings) == {"duplicate-number": 1}
    same = [entry(n, [0.1 * k, 0.0]) for k, n in enumerate(ids[:3])]
    assert read(tmp_path, *changes, ("tactile_maps", 0, "taxels", same)).maps[0].taxels.tolist() == [0, 1, 2]


def test_taxel_without_a_board_is_omitted_from_skin_and_map(tmp_path):
    file = read(tmp_path, ("skin", "taxels", 0, "id", -1), ("tactile_maps", 0, "taxels", 1, "id", -1))
    assert (file.taxels.ids.tolist(), file.taxels.numbers.tolist()) == ([32, 33, 34], [32, 33, 34])
    np.testing.assert_allclose(file.taxels.positions[:, 0], [0.01, 0.02, 0.03])
    assert file.taxels.faces.tolist() == [[0, 2, 1]]
    assert file.maps[0].taxels.tolist() == [2, 0]
    assert kinds(file.taxels.findings) == {"taxel-without-id": 1, "unknown-taxel": 1}


def test_taxel_on_both_sides_of_a_cut_is_one_taxel(tmp_path):
    places = [entry(n, [0.1 * k, 0.0]) for k, n in enumerate([34, 31, 31])]
    file = read(tmp_path, ("tactile_maps", 0, "taxels", places))
    assert file.maps[0].taxels.tolist() == [3, 0, 0]
    np.testing.assert_allclose(file.with_points().points[0], [0.1, 0])
    assert kinds(file.taxels.findings) == {"shown-twice": 1}
    write_unige(file, tmp_path / "again.json")
    flags = [taxel["cut"] for taxel in json.loads((tmp_path / "again.json").read_text())["tactile_maps"][0]["taxels"]]
    assert flags == [0, 1, 1]
    assert read_unige(tmp_path / "again.json").maps[0].taxels.tolist() == [3, 0, 0]


def test_every_other_defect_is_counted(tmp_path):
    frame = DOCUMENT["skin"]["parent_frames"][0]
    file = read(
        tmp_path,
        ("skin", "n_taxels", 5),
        ("skin", "n_faces", 9),
        ("skin", "taxels", 0, "type", "temperature"),
        ("skin", "taxels", 1, "n", [0, 0, 3]),
        ("skin", "parent_frames", [frame | {"tf_matrix": (2 * np.eye(4)).tolist()}, frame]),
        ("tactile_maps", 0, "taxels", 0, "id", 99),
    )
    assert [(f.kind, f.count) for f in file.taxels.findings] == [
        ("count-mismatch", 1),
        ("normals-not-unit", 1),
        ("count-mismatch", 1),
        ("not-pressure", 1),
        ("several-frames", 1),
        ("frame-transform", 1),
        ("unknown-taxel", 1),
    ]
    assert file.maps[0].taxels.tolist() == [0, 1]
    assert file.maps[0].faces.shape == (0, 3)


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (("skin", []), "skin: an object is missing.*list"),
        (("skin", "taxels", {}), "skin, taxels: a list is missing"),
        (("skin", "taxels", []), "skin.*1 to 100000 taxels"),
        (("skin", "taxels", 2, 5), "skin, taxel 2.*object.*int"),
        (("skin", "taxels", 2, "id", -2), "skin, taxel 2.*id must be a whole number.*-2"),
        (("skin", "taxels", [entry(-1, [0, 0, 0])] * 2), "skin: no taxel has an id.*2"),
        (("skin", "taxels", 2, "id", 2.5), "skin, taxel 2.*id must be"),
        (("skin", "taxels", 2, "id", True), "skin, taxel 2.*id must be"),
        (("skin", "taxels", 2, "id", 10**30), "skin, taxel 2.*id must be"),
        (("skin", "taxels", 2, "x", [0, 0]), "skin, taxel 2.*x must be 3 finite"),
        (("skin", "taxels", 2, "x", [0, 0, float("nan")]), "skin, taxel 2.*x must be 3 finite"),
        (("skin", "taxels", 2, "x", [0, 0, "1"]), "skin, taxel 2.*x must be 3 finite"),
        (("skin", "taxels", 2, "x", [0, 0, 10**400]), "skin, taxel 2.*x must be 3 finite"),
        (("skin", "taxels", 2, "x", [0, 0, 85.0]), "positions are in metres"),
        (("skin", "taxels", 2, "n", [0, 1]), "skin, taxel 2.*n must be 3 finite"),
        (("skin", "faces", 1, [0, 1]), "skin, face 1.*three indices"),
        (("skin", "faces", 1, [0, 1, -2]), "skin, face 1.*three indices"),
        (("skin", "faces", 1, [0, 1, 4]), "faces, row 1.*does not exist"),
        (("skin", "parent_frames", [7]), "parent_frames"),
        (("tactile_maps", {}), "tactile_maps: a list is missing"),
        (("tactile_maps", 0, "taxels", 1, "x", [0, 0, 0]), "tactile_maps 0, taxel 1.*x must be 2"),
        (("tactile_maps", 0, "taxels", 1, "x", [0, 500]), "tactile_maps 0.*map point is not within"),
        (("tactile_maps", 0, "faces", [[0, 1, 3]]), "tactile_maps 0.*taxel that the map does not have"),
        (("tactile_maps", 0, "taxels", [entry(99, [0, 0])]), "does not have|none of the skin's taxels"),
    ],
)
def test_invalid_files_are_rejected_with_their_place(tmp_path, change, problem):
    with pytest.raises(SkinError, match=rf"skin\.json.*({problem})"):
        read(tmp_path, change)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "7", "[" * 100_000, '{"skin": ' * 5000, "{} {}", "\x00"])
def test_invalid_documents_are_rejected(tmp_path, text):
    (tmp_path / "skin.json").write_text(text)
    with pytest.raises(SkinError, match=r"skin\.json"):
        read_unige(tmp_path / "skin.json")


def test_round_trip_keeps_taxels(tmp_path):
    taxels = dome(points=None, modules=None, faces=np.array([[0, 1, 2], [3, 4, 5]]), name="handle ü")
    first = UnigeMap("first", np.arange(12), dome().points, np.array([[0, 1, 2]]), "by ear")
    second = UnigeMap("second", np.array([5, 3, 9]), 0.1 * np.eye(3)[:, :2], np.zeros((0, 3)))
    write_unige(UnigeFile(taxels, (first, second)), tmp_path / "skin.json")
    back = read_unige(tmp_path / "skin.json")
    assert_equal(taxels, back.taxels)
    assert (back.taxels.name, back.taxels.link, back.taxels.findings) == ("handle ü", "hand", ())
    for one, other in zip((first, second), back.maps, strict=True):
        assert (one.name, one.description) == (other.name, other.description)
        for field in ("taxels", "points", "faces"):
            np.testing.assert_array_equal(getattr(one, field), getattr(other, field))
