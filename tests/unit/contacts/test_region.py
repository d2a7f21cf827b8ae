"""A contact region as a value."""

from __future__ import annotations

import numpy as np

from app.contacts.region import ContactRegion
from app.geometry.surface_point import SurfacePoint


def test_it_owns_its_arrays():
    at, point = SurfacePoint(0, 0, (1.0, 0.0, 0.0)), np.zeros(3)
    region = ContactRegion(1, np.array([3, 4]), 2.0, 1e-4, 5e3, np.zeros(2), at, "bar", point, point)
    point[0] = 1
    assert region.point[0] == 0
    assert not region.taxels.flags.writeable
    assert not region.torn
    assert (region.partner, region.merged, region.split_from) == (0, (), 0)
    assert region.axes.shape == (2, 3)
    assert region.map_axes.shape == (2, 2)
