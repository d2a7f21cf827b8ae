from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats import urdf_tactile
from tactile_maps.skin.formats.urdf_tactile import read_urdf_taxels, write_urdf_taxels
from tests.support.example_taxels import assert_equal, dome
from tests.support.findings import kinds

TAXEL = '<taxel idx="0" xyz="0 0 0" rpy="0 0 0"/>'
ARRAY = '<array rows="2" cols="3" size="0.01 0.02"/>'


def sensor(inside, *, name="pad", link="hand", origin=""):
    return f'<sensor name="{name}"><parent link="{link}"/>{origin}<tactile channel="c">{inside}</tactile></sensor>'


def read(tmp_path, *sensors, head='<robot name="r">'):
    path = tmp_path / "robot.urdf"
    path.write_text(f"{head}<link name='hand'/>{''.join(sensors)}</robot>")
    return read_urdf_taxels(path)


def test_taxels_are_placed_in_the_sensor_and_the_sensor_on_its_link(tmp_path):
    taxel = (
        '<taxel idx="4" xyz="0.1 0 0" rpy="1.5707963267948966 0 0"><geometry><sphere radius="1"/></geometry></taxel>'
    )
    origin = '<origin xyz="0 0 0.5" rpy="0 0 1.5707963267948966"/>'
    (taxels,) = read(tmp_path, sensor(taxel, origin=origin))
    assert (taxels.name, taxels.link, taxels.numbers.tolist()) == ("pad", "hand", [4])
    np.testing.assert_allclose(taxels.positions, [[0, 0.1, 0.5]], atol=1e-15)
    np.testing.assert_allclose(taxels.normals, [[1, 0, 0]], atol=1e-15)
    assert taxels.findings == ()


def test_array_is_laid_out_by_rows_or_columns(tmp_path):
    (rows,) = read(tmp_path, sensor(ARRAY))
    mm = 1e3 * rows.positions
    np.testing.assert_allclose(mm, [[10 * r, 20 * c, 0] for r in range(2) for c in range(3)], atol=1e-12)
    assert (rows.normals == [0, 0, 1]).all()
    for order in ("col-major", "column-major"):
        array = f'<array rows="2" cols="3" order="{order}" size="1 1" spacing="0.01 -0.02" offset="0.001 0"/>'
        (columns,) = read(tmp_path, sensor(array))
        expected = [[10 * r - 1, -20 * c, 0] for c in range(3) for r in range(2)]
        np.testing.assert_allclose(1e3 * columns.positions, expected, atol=1e-12)
        assert kinds(columns.findings) == {"array-offset": 1}


def test_namespaced_names_are_read_and_other_sensors_ignored(tmp_path):
    other = '<sensor name="camera"><parent link="hand"/><camera/></sensor>'
    (taxels,) = read(tmp_path, other, sensor(TAXEL + ARRAY), head='<robot xmlns="http://www.ros.org">')
    assert len(taxels) == 1
    assert kinds(taxels.findings) == {"array-left-out": 1}


def test_sensors_of_one_link_are_joined_with_a_finding(tmp_path):
    hand, arm = read(tmp_path, sensor(ARRAY), sensor(TAXEL, name="arm", link="arm"), sensor(ARRAY, name="pad 2"))
    assert (hand.link, len(hand), arm.link, len(arm)) == ("hand", 12, "arm", 1)
    assert hand.numbers.tolist() == list(range(12))
    assert kinds(hand.findings) == {"sensors-joined": 1, "duplicate-number": 6}


def test_missing_normals_stay_missing(tmp_path):
    (taxels,) = read(tmp_path, sensor('<taxel idx="0" xyz="0 0 1"/>'))
    assert taxels.normals is None
    (mixed,) = read(tmp_path, sensor('<taxel idx="9" xyz="0 0 1"/>'), sensor(ARRAY))
    assert mixed.normals is None
    assert kinds(mixed.findings) == {"sensors-joined": 1, "normals-missing": 1}


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        ("", "sensor pad.*neither taxels nor an array"),
        ('<taxel xyz="0 0 0"/>', "sensor pad.*idx must be a whole number.*nothing"),
        ('<taxel idx="-1" xyz="0 0 0"/>', "idx must be a whole number.*-1"),
        ('<taxel idx="1" xyz="0 0"/>', "xyz must be 3 finite numbers.*0 0"),
        ('<taxel idx="1" xyz="0 0 nan"/>', "xyz must be 3 finite"),
        ('<taxel idx="1" xyz="0 0 1e99"/>', "xyz must be 3 finite"),
        ('<taxel idx="1" xyz="0 0 up"/>', "xyz must be numbers.*up"),
        ('<taxel idx="1" xyz="0 0 30"/>', "robot.urdf.*positions are in metres"),
        ('<array rows="2" cols="3"/>', "size must be 2 finite"),
        ('<array rows="0" cols="3" size="1 1"/>', "1 to 100000 taxels.*0 x 3"),
        ('<array rows="99999" cols="99999" size="1 1"/>', "1 to 100000 taxels"),
        ('<array rows="2.5" cols="3" size="1 1"/>', "rows must be a whole"),
        ('<array rows="2" cols="3" size="1 1" order="zigzag"/>', "order must be.*zigzag"),
    ],
)
def test_invalid_sensors_are_rejected_by_name(tmp_path, inside, problem):
    with pytest.raises(SkinError, match=rf"robot\.urdf.*{problem}|{problem}"):
        read(tmp_path, sensor(inside))


def test_hostile_files_are_rejected(tmp_path, monkeypatch):
    bomb = '<!DOCTYPE r [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><robot name="&b;">'
    with pytest.raises(SkinError, match="document type"):
        read(tmp_path, sensor(TAXEL), head=bomb)
    with pytest.raises(SkinError, match="not valid XML"):
        read(tmp_path, "<sensor>")
    with pytest.raises(SkinError, match="no tactile sensor"):
        read(tmp_path)
    with pytest.raises(SkinError, match="no parent link"):
        read(tmp_path, sensor(TAXEL, link=""))
    monkeypatch.setattr(urdf_tactile, "MAX_TAXELS", 7)
    with pytest.raises(SkinError, match="more than 7 taxels"):
        read(tmp_path, sensor(ARRAY), sensor(ARRAY))


def test_round_trip_keeps_taxels(tmp_path):
    sets = (dome(name='odd "name" & <more>\x07'), dome(name="arm", link="arm", normals=None), dome(link=None))
    write_urdf_taxels(sets, tmp_path / "robot.urdf")
    back = read_urdf_taxels(tmp_path / "robot.urdf")
    assert [(taxels.name, taxels.link) for taxels in back] == [
        ('odd "name" & <more>', "hand"),
        ("arm", "arm"),
        ("dome", "skin"),
    ]
    for one, other in zip(sets, back, strict=True):
        assert_equal(one, other, arrays=("numbers", "positions", "normals"))


def test_every_direction_is_restored_from_its_angles(tmp_path):
    axes = np.concatenate([np.eye(3), -np.eye(3), np.random.default_rng(0).normal(size=(30, 3))])
    normals = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    taxels = dome(36, normals=normals)
    write_urdf_taxels([taxels], tmp_path / "robot.urdf")
    np.testing.assert_allclose(read_urdf_taxels(tmp_path / "robot.urdf")[0].normals, normals, atol=1e-15)
