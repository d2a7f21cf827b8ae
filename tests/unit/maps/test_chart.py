"""Charts are values: frozen, with arrays of their own."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from app.maps.flatten import flatten
from tests.numerics.map_surfaces import sheet


def test_a_chart_cannot_be_changed():
    chart = flatten(sheet())
    with pytest.raises(FrozenInstanceError):
        chart.method = "other"
    for name in ("faces", "plane", "vertex_of", "seams"):
        assert not getattr(chart, name).flags.writeable


def test_a_chart_tells_its_rounds():
    chart = flatten(sheet())
    assert len(chart.energies) == len(chart.seconds) > 1
    assert list(chart.seconds) == sorted(chart.seconds)
    assert np.diff(chart.energies).max() <= 1e-12  # but for rounding, never up


def test_what_is_computed_from_a_chart_does_not_travel_with_it():
    chart = flatten(sheet())
    assert chart.locator.query(chart.plane[:1])[0] >= 0
    assert len(chart.border) == len(set(chart.border.tolist())) == 40
    assert len(chart.torn) == 0
    back = pickle.loads(pickle.dumps(chart))
    assert not {"border", "torn", "locator"} & set(vars(back))
    np.testing.assert_array_equal(back.plane, chart.plane)
