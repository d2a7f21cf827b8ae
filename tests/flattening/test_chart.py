"""A chart and its pins: what they hold, and what travels with them."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from tactile_maps.flattening.chart import Pin
from tactile_maps.flattening.flatten import flatten
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.support.surfaces import sheet


def test_equal_pins_compare_equal_after_pickling():
    pin = Pin(SurfacePoint(1, 4, (0.25, 0.5, 0.25)), (0.1, -0.2))
    assert pickle.loads(pickle.dumps(pin)) == pin
    assert len({pin, Pin(SurfacePoint(1, 4, (0.25, 0.5, 0.25)), (0.1, -0.2))}) == 1


def test_chart_is_immutable():
    chart = flatten(sheet())
    with pytest.raises(FrozenInstanceError):
        chart.method = "other"
    for name in ("faces", "plane", "vertex_of", "seams"):
        assert not getattr(chart, name).flags.writeable


def test_chart_reports_its_rounds():
    chart = flatten(sheet())
    assert len(chart.energies) == len(chart.seconds) > 1
    assert list(chart.seconds) == sorted(chart.seconds)
    assert np.diff(chart.energies).max() <= 1e-12  # but for rounding, never up


def test_cached_values_of_a_chart_are_not_pickled():
    chart = flatten(sheet())
    assert chart.locator.query(chart.plane[:1])[0] >= 0
    assert len(chart.border) == len(set(chart.border.tolist())) == 40
    assert len(chart.seam_edges) == 0
    back = pickle.loads(pickle.dumps(chart))
    assert not {"border", "seam_edges", "locator"} & set(vars(back))
    np.testing.assert_array_equal(back.plane, chart.plane)
