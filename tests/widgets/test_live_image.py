"""The live image: one buffer, the scale's own colours, and a rim carried outwards."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.colours import PressureScale
from widgets.map_view.live_image import LiveImage
from widgets.map_view.tile import halo_of


@pytest.fixture
def inside():
    inside = np.zeros((20, 30), dtype=bool)
    inside[5:15, 10:20] = True
    return inside


def live_image(inside):
    return LiveImage(inside.shape, *halo_of(inside))


def colour(live, row, column):
    return live.image.pixel(column, row) & 0xFFFFFF


def test_pressures_take_the_colours_of_the_scale(inside):
    live, scale = live_image(inside), PressureScale(20.0)
    kilopascals = np.zeros(inside.shape, np.float32)
    kilopascals[7, 12], kilopascals[8, 12], kilopascals[9, 12] = 10.0, 20.0, 500.0
    live.fill(kilopascals, scale)
    half = (len(scale.lut) - 1) // 2
    assert colour(live, 6, 12) == int(scale.lut[0]) & 0xFFFFFF
    assert colour(live, 7, 12) == int(scale.lut[half]) & 0xFFFFFF
    assert colour(live, 8, 12) == colour(live, 9, 12) == int(scale.lut[-1]) & 0xFFFFFF


def test_the_rim_is_carried_outwards(inside):
    live, scale = live_image(inside), PressureScale(20.0)
    live.fill(np.where(inside, np.float32(20.0), np.float32(0.0)), scale)
    top = int(scale.lut[-1]) & 0xFFFFFF
    assert [colour(live, 10, column) == top for column in (21, 22, 24, 9, 7, 5)] == [True, True, False] * 2


@pytest.mark.parametrize("value", [True, False])
def test_all_or_nothing_inside(value):
    live = live_image(np.full((4, 6), value))
    live.fill(np.zeros((4, 6), np.float32), PressureScale(20.0))
    assert live.image.width() == 6
