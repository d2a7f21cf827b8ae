"""The nearest taxel's own value."""

from __future__ import annotations

import numpy as np

from app.maps.interpolation.nearest import nearest
from app.maps.interpolation.triangles import TaxelTriangles
from tests.numerics.taxel_fields import jittered


def test_it_is_the_nearest_of_all():
    triangles = TaxelTriangles(jittered())
    points = np.random.default_rng(2).uniform(-0.02, 0.11, (800, 2))
    expected = np.linalg.norm(points[:, None] - triangles.sites, axis=2).argmin(axis=1)
    np.testing.assert_array_equal(nearest(triangles, points).indices, expected)
