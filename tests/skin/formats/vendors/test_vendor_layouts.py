"""Layouts of vendors: recognised by their content, read with ids, units, normals and links, refused with the place."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import load_robot_and_skin
from tactile_maps.skin.formats.identify import kind_of
from tactile_maps.skin.formats.taxel_files import read_taxel_sets, read_taxels
from tactile_maps.skin.open import open_skin


def written(folder, name, text):
    path = folder / name
    path.write_text(text if isinstance(text, str) else json.dumps(text))
    return path


def paxini(**change):
    points = [{"index": 1 + k, "x_mm": 4.0 * (k % 4), "y_mm": 4.0 * (k // 4), "z_mm": 0.5} for k in range(12)]
    points[2] |= change
    return {"name": "pad", "units": "millimeters", "points": points}


def test_paxini_points_are_millimetres_with_index_as_id(tmp_path):
    path = written(tmp_path, "pad.json", paxini())
    taxels = read_taxels(path)
    assert taxels.ids.tolist() == list(range(1, 13))
    np.testing.assert_allclose(taxels.positions[5], [0.004, 0.004, 0.0005])
    assert [finding.kind for finding in taxels.findings] == ["vendor-layout"]
    assert len(open_skin(path)) == 12


def test_paxini_list_of_triples_keeps_the_order(tmp_path):
    taxels = read_taxels(written(tmp_path, "S1.json", {"model": "S1", "taxels_mm": [[-5, 0, 2], [0, 1, 7], [5, 0, 2]]}))
    assert (taxels.ids, taxels.numbers.tolist()) == (None, [0, 1, 2])
    np.testing.assert_allclose(taxels.positions[1], [0, 0.001, 0.007])


def test_paxini_value_that_is_not_a_number_is_rejected_with_its_place(tmp_path):
    with pytest.raises(SkinError, match=r"pad\.json, points\.2, y_mm: must be a number \(found: left\)"):
        read_taxels(written(tmp_path, "pad.json", paxini(y_mm="left")))


ORCA = """
units: {unit}
num_taxels: {count}
coordinates:
- x: 4.0
  y: 28.0
  z: 3.5
- {{x: 0, y: 24, z: 10}}
"""


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("m", 1.0)])
def test_orca_coordinates_have_the_stated_unit(tmp_path, unit, metres):
    text = ORCA.format(unit=unit, count=2) if unit == "mm" else "units: m\ncoordinates:\n- {x: 4.0, y: 2.8, z: 3.5}\n"
    taxels = read_taxels(written(tmp_path, "config.yaml", text))
    np.testing.assert_allclose(taxels.positions[0, [0, 2]], [4.0 * metres, 3.5 * metres])


@pytest.mark.parametrize(
    ("unit", "count", "problem"), [("furlong", 2, "unknown unit.*mm"), ("mm", 3, "differ.*3 and 2")]
)
def test_inconsistent_orca_file_is_rejected(tmp_path, unit, count, problem):
    with pytest.raises(SkinError, match=problem):
        read_taxels(written(tmp_path, "config.yaml", ORCA.format(unit=unit, count=count)))


def probe(x, y, normal=(0.0, 0.0, 2.0)):
    return {"radius": 0.003, "pos": [x, y, 0.01], "normal": list(normal)}


GENESIS = [
    {"link_name": "index", "kind": "grid", "probes": [[probe(0, 0), probe(0.005, 0)], [probe(0, 0.005)]]},
    {"link_name": "palm", "kind": "list", "probes": [probe(0.1, 0.1, (1, 0, 0))]},
]


def test_genesis_grid_and_list_are_read_by_link(tmp_path):
    index, palm = read_taxel_sets(written(tmp_path, "probes.json", GENESIS))
    assert [(one.link, len(one)) for one in (index, palm)] == [("index", 3), ("palm", 1)]
    np.testing.assert_allclose(index.positions[2], [0, 0.005, 0.01])
    np.testing.assert_allclose(palm.normals, [[1, 0, 0]])
    np.testing.assert_allclose(index.areas, np.pi * 0.003**2)
    assert "normals-not-unit" in {finding.kind for finding in index.findings}


def test_genesis_probes_of_radius_0_are_omitted_and_others_keep_their_stream_position(tmp_path):
    filler = {"radius": 0.0, "pos": [0, 0, 0], "normal": [0, 0, 1]}
    grid = {"link_name": "index", "kind": "grid", "probes": [[probe(0, 0), filler], [filler, probe(0, 0.005)]]}
    palm = {"link_name": "palm", "kind": "list", "probes": [filler]}
    (index,) = read_taxel_sets(written(tmp_path, "probes.json", [palm, grid]))
    assert (index.link, index.ids.tolist()) == ("index", [0, 3])
    np.testing.assert_allclose(index.areas, np.pi * 0.003**2)
    assert {finding.kind: finding.count for finding in index.findings}["unfitted-taxel"] == 3
    with pytest.raises(SkinError, match="every probe has the radius 0"):
        read_taxel_sets(written(tmp_path, "empty.json", [palm]))


def test_genesis_probe_without_position_is_rejected_with_its_place(tmp_path):
    broken = [GENESIS[0], {"link_name": "palm", "kind": "list", "probes": [{"radius": 0.003, "normal": [0, 0, 1]}]}]
    with pytest.raises(SkinError, match=r"1\.probes\.0: a field is missing \(found: pos\)\. It has: radius, normal"):
        read_taxel_sets(written(tmp_path, "probes.json", broken))


SPHERE = '<visual><geometry><sphere radius="0.0"/></geometry></visual>'


def gentact(*, axis="<axis xyz='0 -1 0'/>", shape=SPHERE, count=4, xyz="0.01 0 0"):
    joint = '<joint name="j{0}" type="fixed"><origin xyz="{1}" rpy="1.5707963267948966 0 0"/>{2}'
    links = '<parent link="fr3_skin"/><child link="fr3_sensor_{0}"/></joint><link name="fr3_sensor_{0}">{3}</link>'
    places = [xyz if k == 1 else f"0 {k / 100} 0" for k in range(count)]
    sensors = [(joint + links).format(k, place, axis, shape) for k, place in enumerate(places)]
    body = '<link name="fr3_skin"><visual><geometry><box size=".1 .1 .1"/></geometry></visual></link>'
    camera = '<joint name="c" type="fixed"><parent link="fr3_skin"/><child link="camera"/></joint><link name="camera"/>'
    return f'<robot name="link6">{body}{camera}{"".join(sensors)}</robot>'


@pytest.mark.parametrize("change", [{}, {"axis": "", "shape": ""}])
def test_gentact_sensors_are_taxels_of_the_link_that_carries_them(tmp_path, change):
    path = written(tmp_path, "link6.urdf", gentact(**change))
    assert kind_of(path) is FileKind.ROBOT_WITH_TAXELS
    taxels = read_taxels(path)
    assert (taxels.link, taxels.ids.tolist(), taxels.names[3]) == ("fr3_skin", [0, 1, 2, 3], "fr3_sensor_3")
    np.testing.assert_allclose(taxels.normals, np.tile([0, -1, 0], (4, 1)), atol=1e-12)
    np.testing.assert_allclose(taxels.positions[1], [0.01, 0, 0])


def test_gentact_origin_of_two_numbers_is_rejected_with_its_joint(tmp_path):
    with pytest.raises(SkinError, match=r"joint j1: origin xyz must be 3 finite numbers \(found: 1 2\)"):
        read_taxels(written(tmp_path, "link6.urdf", gentact(xyz="1 2")))


@pytest.mark.parametrize(
    ("cell", "encoding"), [("（{}，-11，{}）", "utf-8-sig"), ('"({},-11,{})"', "utf8"), ("（{}，-11，{}）", "gbk")]
)
def test_rapid_table_has_a_taxel_in_each_cell(tmp_path, cell, encoding):
    rows = [",".join(cell.format(1.5 * column - 4.2, 35.6 - 1.2 * row) for column in range(4)) for row in range(3)]
    path = tmp_path / "tactile.csv"
    path.write_bytes("\n".join(rows).encode(encoding))
    taxels = read_taxels(path)
    assert len(taxels) == 12
    np.testing.assert_allclose(taxels.positions[[0, 5]], [[-4.2e-3, -0.011, 0.0356], [-2.7e-3, -0.011, 0.0344]])
    assert [finding.kind for finding in taxels.findings] == ["vendor-layout"]


@pytest.mark.long
def test_rapid_table_with_semicolons_and_empty_last_rows_is_read_by_a_scene(tmp_path):
    rows = [";".join(f"({2.4 * column - 8.4:g},-11.3,{36 - 2.4 * row:g})" for column in range(8)) for row in range(12)]
    written(tmp_path, "tactile.csv", "\n".join([*rows, ";" * 7, ";" * 7]))
    text = 'robot = "hand"\ntaxel_file = "tactile.csv"\n[cover]\nlinks = ["left_finger"]\n'
    _, skin = load_robot_and_skin(load_scene(str(written(tmp_path, "scene.toml", text))))
    assert [(patch.link, len(patch.taxels)) for patch in skin.patches] == [("left_finger", 96)]


def test_rapid_cell_without_a_position_is_rejected_with_its_place(tmp_path):
    with pytest.raises(SkinError, match=r"line 2, column 1: must be a position \(x, y, z\) \(found: none\)"):
        read_taxels(written(tmp_path, "tactile.csv", '"(1,2,3)","(2,2,3)"\nnone,"(4,2,3)"\n'))


def test_urdf_with_two_numbered_frames_is_only_a_robot(tmp_path):
    assert kind_of(written(tmp_path, "robot.urdf", gentact(count=2))) is FileKind.ROBOT
