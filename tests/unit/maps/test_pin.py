"""A pin is a plain value: it can be compared, kept in a set and sent to another process."""

from __future__ import annotations

import pickle

from app.geometry.surface_point import SurfacePoint
from app.maps.pin import Pin


def test_equal_pins_are_one_and_survive_the_way_to_another_process():
    pin = Pin(SurfacePoint(1, 4, (0.25, 0.5, 0.25)), (0.1, -0.2))
    assert pickle.loads(pickle.dumps(pin)) == pin
    assert len({pin, Pin(SurfacePoint(1, 4, (0.25, 0.5, 0.25)), (0.1, -0.2))}) == 1
