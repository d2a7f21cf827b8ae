"""Axes and tangents of taxels in the formats of taxel files: kept by each, checked when read."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import load_map, save_map
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels, write_taxels
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.open import open_skin
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels
from tests.support.findings import kinds

FORMATS = [".csv", ".npz", ".json", ".urdf"]


def ball(count=24):
    """Taxels all over a ball, every third with one axis, every fourth without a stated tangent."""
    rng = np.random.default_rng(0)
    normals = rng.normal(size=(count, 3))
    normals[:6] = [*np.eye(3), *-np.eye(3)]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    guesses = rng.normal(size=(count, 3))
    guesses[:6] = np.roll(normals[:6], 1, axis=1)
    tangents = tangents_on(guesses / np.linalg.norm(guesses, axis=1, keepdims=True), normals)
    tangents[5::4] = np.nan
    axes = np.where(np.arange(count) % 3, 3, 1)
    return TaxelSet(
        "ball",
        "hand",
        np.arange(count),
        0.05 * normals,
        normals,
        ids=100 + np.arange(count),
        axes=axes,
        tangents=tangents,
    )


def sheet_text(rows, *, columns="axes,t1x,t1y,t1z", first=10):
    """Return a table of taxels 10 mm apart in a plane, with further cells for each."""
    lines = [f"x_mm,y_mm,z_mm,nx,ny,nz,id,{columns}"]
    lines += [f"{10 * (k % 3)},{10 * (k // 3)},0,0,0,1,{first + k},{row}" for k, row in enumerate(rows)]
    return "\n".join(lines) + "\n"


def read(folder, text, name="sheet.csv"):
    (folder / name).write_text(text)
    return read_taxels(folder / name)


@pytest.mark.parametrize("ending", FORMATS)
def test_format_keeps_axes_and_tangents(tmp_path, ending):
    taxels = ball()
    write_taxels(taxels, tmp_path / f"ball{ending}")
    back = read_taxels(tmp_path / f"ball{ending}")
    assert back.axes.tolist() == taxels.axes.tolist()
    np.testing.assert_allclose(back.normals, taxels.normals, atol=1e-9)
    np.testing.assert_allclose(back.tangents, taxels.tangents, atol=1e-9)
    assert not {"frame-not-orthonormal", "axes-unstated"}.intersection(kinds(back.findings))


@pytest.mark.parametrize("ending", FORMATS)
def test_format_without_axes_has_one_axis_and_is_written_without_them(tmp_path, ending):
    plain = skin_from_taxels(ball().select(np.arange(24) == 3))
    write_taxels(plain, tmp_path / f"plain{ending}")
    back = read_taxels(tmp_path / f"plain{ending}")
    assert (back.axes, back.tangents is None) == (None, False), "taxel 3 has one axis and a stated tangent"
    bare = TaxelSet("bare", "hand", [0], np.zeros((1, 3)), [[0.0, 0.0, 1.0]])
    write_taxels(bare, tmp_path / f"bare{ending}")
    back = read_taxels(tmp_path / f"bare{ending}")
    assert (back.axes, back.tangents) == (None, None)
    assert b"axes" not in (tmp_path / f"bare{ending}").read_bytes()


@pytest.mark.parametrize("ending", FORMATS)
def test_skin_and_map_of_a_mixed_file_keep_its_axes(tmp_path, ending):
    rows = ["3,1,0,0", "1,,,", "3,0,1,0", "3,,,", ",,,", "3,0,0,0"]
    write_taxels(read(tmp_path, sheet_text(rows)), tmp_path / f"mixed{ending}")
    skin = open_skin(tmp_path / f"mixed{ending}")
    order = np.argsort(skin.identity.ids)
    assert skin.axes[order].tolist() == [3, 1, 3, 3, 1, 3]
    expected = np.full((6, 3), np.nan)
    expected[[0, 2]] = np.eye(3)[:2]
    np.testing.assert_allclose(skin.tangents[order], expected, atol=1e-9)
    save_map(build_map(skin), tmp_path / "map.npz")
    np.testing.assert_array_equal(load_map(tmp_path / "map.npz").skin.axes, skin.axes)
    np.testing.assert_array_equal(load_map(tmp_path / "map.npz").skin.tangents, skin.tangents)


def test_whole_frames_of_a_table_are_checked_and_small_deviations_corrected(tmp_path):
    columns = "axes,t1x,t1y,t1z,t2x,t2y,t2z"
    exact = read(tmp_path, sheet_text(["3,2,0,0,0,1,0", "3,0,1,0,-1,0,0"], columns=columns))
    np.testing.assert_allclose(exact.tangents, np.eye(3)[:2], atol=1e-12)
    assert set(kinds(exact.findings)) == {"millimetres"}
    tilted = read(tmp_path, sheet_text(["3,1,0,0.06,0,1,0", "3,0,1,0,-1,0.05,0"], columns=columns))
    np.testing.assert_allclose(tilted.tangents, np.eye(3)[:2], atol=1e-12)
    (finding,) = [one for one in tilted.findings if one.kind == "frame-not-orthonormal"]
    assert (finding.where, finding.count) == ("sheet.csv", 2)
    assert "up to 3.4 degrees" in finding.action


@pytest.mark.parametrize(
    ("rows", "problem"),
    [
        (["3,1,0,0,0,-1,0"], "line 2, taxel 10: the frame .* is left-handed .*Swap t1 and t2"),
        (["1,,,,,,", "3,1,0,0,0.5,0.5,0"], "line 3, taxel 11: t2 is not perpendicular to t1 and the normal"),
        (["3,1,0,0.2,,,"], "line 2, taxel 10: t1 is not perpendicular to the normal .*along the skin"),
        (["3,0,0,1,,,"], "line 2, taxel 10: t1 is not perpendicular to the normal"),
        (["3,1,,0,,,"], "line 2, taxel 10: t1 must be three finite numbers"),
        (["3,,,,0,1,0"], "line 2, taxel 10: t2 is stated without t1"),
        (["3,1,0,nan,,,"], "line 2, column t1z: t1z is not a finite number"),
        (["3,,,,,,", "2,,,,,,"], "line 3, column axes: axes must be 1 or 3.*2"),
        (["3,,,,,,", "x,,,,,,"], "line 3, column axes: axes must be a number"),
    ],
)
def test_invalid_frames_of_a_table_name_line_taxel_and_remedy(tmp_path, rows, problem):
    with pytest.raises(SkinError, match=f"sheet.csv, {problem}"):
        read(tmp_path, sheet_text(rows, columns="axes,t1x,t1y,t1z,t2x,t2y,t2z"))


@pytest.mark.parametrize("columns", ["t1x,t1y", "t2x,t2y,t2z"])
def test_incomplete_tangent_columns_are_rejected(tmp_path, columns):
    with pytest.raises(SkinError, match="line 1: .* missing: t1"):
        read(tmp_path, sheet_text([",".join("0" for _ in columns.split(","))], columns=columns))


def test_tangents_without_axes_are_one_axis_and_reported(tmp_path):
    taxels = read(tmp_path, sheet_text(["1,0,0"], columns="tangent1_x,tangent1_y,tangent1_z"))
    assert taxels.axes is None
    np.testing.assert_array_equal(taxels.tangents, [[1, 0, 0]])
    assert "axes-unstated" in kinds(taxels.findings)


def test_invalid_axes_of_json_name_the_taxel(tmp_path):
    write_taxels(ball(), tmp_path / "ball.json")
    document = json.loads((tmp_path / "ball.json").read_text())
    entry = document["skin"]["taxels"][1]
    for key, value, problem in (
        ("axes", 2, "skin, taxel 1: axes must be 1 or 3"),
        ("axes", 3.0, "skin, taxel 1: axes must be 1 or 3"),
        ("t1", [1, 0], "skin, taxel 1: t1 must be 3 finite numbers"),
        ("t1", entry["n"], "skin, taxel 1, id 101: t1 is not perpendicular"),
        ("t2", entry["t1"], "skin, taxel 1, id 101: t2 is not perpendicular"),
    ):
        document["skin"]["taxels"][1] = entry | {key: value}
        (tmp_path / "ball.json").write_text(json.dumps(document))
        with pytest.raises(SkinError, match=problem):
            read_taxels(tmp_path / "ball.json")


def test_invalid_axes_of_npz_and_urdf_are_rejected(tmp_path):
    places = np.zeros((2, 3))
    np.savez(tmp_path / "a.npz", positions=places, normals=np.eye(3)[[2, 2]], tangents=np.eye(3)[[0, 2]])
    with pytest.raises(SkinError, match="tangents, row 1: t1 is not perpendicular"):
        read_taxels(tmp_path / "a.npz")
    np.savez(tmp_path / "b.npz", positions=places, axes=np.array([3, 4]))
    with pytest.raises(SkinError, match="axes, row 1: invalid number of axes"):
        read_taxels(tmp_path / "b.npz")
    write_taxels(ball(), tmp_path / "c.urdf")
    text = (tmp_path / "c.urdf").read_text().replace('axes="3"', 'axes="2"', 1)
    (tmp_path / "c.urdf").write_text(text)
    with pytest.raises(SkinError, match="sensor ball: axes must be 1 or 3 .*2"):
        read_taxels(tmp_path / "c.urdf")


def test_three_axis_array_of_urdf_has_the_x_axis_of_its_sensor(tmp_path):
    (tmp_path / "pad.urdf").write_text(
        '<robot name="r"><sensor name="pad"><parent link="hand"/><origin rpy="0 0 1.5707963267948966"/>'
        '<tactile channel="pad"><array rows="2" cols="2" size="0.01 0.01" axes="3"/></tactile></sensor></robot>'
    )
    (taxels,) = read_taxel_sets(tmp_path / "pad.urdf")
    assert taxels.axes.tolist() == [3] * 4
    np.testing.assert_allclose(taxels.tangents, np.tile([0.0, 1.0, 0.0], (4, 1)), atol=1e-12)


@pytest.mark.parametrize(
    ("mapping", "axes", "tangents"),
    [
        ('axes = 3\nt1 = "along"', [3, 3], [[0, 1, 0], [1, 0, 0]]),
        ('axes = "channels"\nt1 = "along"', [3, 1], [[0, 1, 0], [1, 0, 0]]),
        ("axes = 3\nt1 = [1, 0, 0]", [3, 3], [[1, 0, 0], [1, 0, 0]]),
        ("axes = 3", [3, 3], None),
    ],
)
def test_mapping_file_names_axes_and_tangents(tmp_path, mapping, axes, tangents):
    records = [
        {"p": [0, 0, 0], "n": [0, 0, 1], "channels": 3, "along": [0, 2, 0]},
        {"p": [0, 9, 0], "n": [0, 0, 1], "channels": 1, "along": [2, 0, 0]},
    ]
    (tmp_path / "pad.json").write_text(json.dumps(records))
    (tmp_path / "pad.json.mapping.toml").write_text(f'position = "p"\nnormal = "n"\nunit = "mm"\n{mapping}\n')
    taxels = read_taxels(tmp_path / "pad.json")
    assert taxels.axes.tolist() == axes
    if tangents is None:
        assert taxels.tangents is None
    else:
        np.testing.assert_array_equal(taxels.tangents, tangents)


@pytest.mark.parametrize(
    ("mapping", "problem"),
    [
        ("axes = 2", "axes: must be 1, 3, or the name of a field .*2"),
        ("axes = true", "axes: must be the name of a field"),
        ("t1 = [1, 0]", "t1: must be the name of one field, or a list of three"),
        ('axes = "p.2"', "0, p.2: must be 1 or 3"),
        ("t1 = [0, 0, 1]", "0: t1 is not perpendicular to the normal"),
        ("position = [1, 0, 0]", "position: must be the name of one field"),
    ],
)
def test_invalid_axes_in_a_mapping_are_reported(tmp_path, mapping, problem):
    (tmp_path / "pad.json").write_text(json.dumps([{"p": [0, 0, 0], "n": [0, 0, 1]}]))
    position = "" if mapping.startswith("position") else 'position = "p"\n'
    (tmp_path / "pad.json.mapping.toml").write_text(f'{position}normal = "n"\nunit = "mm"\n{mapping}\n')
    with pytest.raises(SkinError, match=problem):
        read_taxels(tmp_path / "pad.json")


def test_paxini_and_orca_taxels_have_three_axes_and_others_one(tmp_path):
    points = [{"index": k, "x_mm": 3.0 * k, "y_mm": float(k % 2), "z_mm": 0.0} for k in range(4)]
    (tmp_path / "paxini.json").write_text(json.dumps({"points": points}))
    paxini = read_taxels(tmp_path / "paxini.json")
    assert (paxini.axes.tolist(), paxini.tangents) == ([3] * 4, None)
    lines = "".join(f"  - {{x: {3 * k}, y: {k % 2}, z: 0}}\n" for k in range(4))
    (tmp_path / "finger.yaml").write_text(f"units: mm\nnum_taxels: 4\ncoordinates:\n{lines}")
    orca = read_taxels(tmp_path / "finger.yaml")
    assert orca.axes.tolist() == [3] * 4
    np.testing.assert_array_equal(orca.tangents, np.tile([1.0, 0.0, 0.0], (4, 1)))
    assert skin_from_taxels(orca).three_axis.all()
    probes = [
        {"link_name": "palm", "kind": "list", "probes": [{"pos": [0, 0, 0], "normal": [0, 0, 1], "radius": 0.01}]}
    ]
    (tmp_path / "hand.json").write_text(json.dumps(probes))
    assert read_taxels(tmp_path / "hand.json").axes is None
