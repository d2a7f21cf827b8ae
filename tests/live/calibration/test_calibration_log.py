"""Logs of loads and readings: forms, units, places and mistakes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import GRAVITY
from tactile_maps.live.calibration.calibration_log import CalibrationLog, read_calibration_log
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tests.support.touch import bar_skin

SKIN = bar_skin()
PLACES = SKIN.patches[0].taxels.positions


def read(tmp_path, text):
    path = tmp_path / "log.csv"
    path.write_text(text)
    return read_calibration_log(path, SKIN)


def test_taxel_of_a_reading_is_given_by_number_or_position(tmp_path):
    x, y, z = 1e3 * PLACES[7]
    by_taxel = read(tmp_path, "time,taxel,force_mN,reading\n0,7,0,100\n1,7,500,150\n")
    by_place = read(tmp_path, f"x_mm,y_mm,z_mm,link,Force_mN,value\n{x},{y},{z},bar,0,100\n{x},{y},{z},bar,500,150\n")
    for log in (by_taxel, by_place):
        assert log.loads.tolist() == [0.0, 0.5]
        assert log.readings[:, 7].tolist() == [100.0, 150.0]
        assert np.isnan(np.delete(log.readings, 7, axis=1)).all()
        assert not log.pressure


def test_column_for_each_taxel_may_have_empty_cells(tmp_path):
    log = read(tmp_path, "# known weights\nmass_g;4;2\n0;10;20\n200;15;\n")
    assert np.allclose(log.loads, [0, 0.2 * GRAVITY])
    assert log.readings[0, [4, 2]].tolist() == [10.0, 20.0]
    assert log.readings[1, 4] == 15.0
    assert np.isnan(log.readings[1, 2])


def test_columns_may_name_modules_and_channels(tmp_path):
    (patch,) = SKIN.patches
    numbers = np.arange(60)
    identity = TaxelIdentity(ids=numbers, modules=numbers // 12, channels=numbers % 12)
    skin = Skin((replace(patch, taxels=replace(patch.taxels, identity=identity)),))
    path = tmp_path / "log.csv"
    path.write_text("force,1.3,4.11\n0,10,20\n2,15,\n")
    readings = read_calibration_log(path, skin).readings
    assert readings[0, [15, 59]].tolist() == [10.0, 20.0]
    assert readings[1, 15] == 15.0
    assert np.isnan(np.delete(readings[1], 15)).all()


def test_pressures_are_in_pascals(tmp_path):
    log = read(tmp_path, "pressure (kPa),0\n0,1\n2.5,3\n")
    assert log.pressure
    assert log.loads.tolist() == [0.0, 2500.0]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("taxel,reading\n1,2\n", "header: no column states the load .found: taxel, reading"),
        ("force,mass,taxel,reading\n1,1,1,2\n", "several columns state the load"),
        ("force,taxel,reading,colour\n1,1,2,3\n", "header: unknown column .found: colour"),
        ("force,reading\n1,2\n", "the columns do not state the reading of each taxel"),
        ("force,reading,5\n1,2,3\n", "the columns do not state the reading of each taxel"),
        ("force,5,14.3\n1,2,3\n", "taxels are named in two ways"),
        ("force,taxel,reading\n1,60,2\n", "line 2: unknown taxel .found: 60.. Give its number .taxel., 0 to 59"),
        ("force,75\n1,2\n", "columns name unknown or ambiguous taxels .found: 75"),
        ("force,taxel,reading\n1,1,much\n", "line 2, reading: expected a number .found: much"),
        ("force,taxel,reading\n1,1\n", "line 2: a row does not fit the header"),
        ("force,taxel,reading\n-3,1,5\n1,1,5\n", "loads are negative, or all 0 .found: -3 to 1"),
        ("force,taxel,reading\nnan,1,5\n", "a load is not finite"),
        ("x,y,z,force,reading\n5,0,0,1,1\n", "line 2: no taxel is at the place .found: the nearest is 46.."),
        ("x,y,z,link,force,reading\n0,0,0,arm,1,1\n", "line 2: a link has no skin .found: arm.. Links with skin: bar"),
        ("", "the table is empty"),
    ],
)
def test_invalid_log_entry_is_reported(tmp_path, text, problem):
    with pytest.raises(LiveError, match=problem) as caught:
        read(tmp_path, text)
    assert str(caught.value.file) == str(tmp_path / "log.csv")


def test_log_without_rows_is_rejected():
    with pytest.raises(LiveError, match="no rows"):
        CalibrationLog([], np.zeros((0, 60)))
