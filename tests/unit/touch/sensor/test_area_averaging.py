from __future__ import annotations

from app.touch.sensor.area_averaging import AreaAveraging
from tests.sensors import refuses


def test_a_pad_is_that_of_roboskin_unless_told():
    assert AreaAveraging().radius == 0.0019


def test_a_radius_out_of_range_is_refused():
    refuses(AreaAveraging, "radius", 0.0, -0.001, 0.06)
