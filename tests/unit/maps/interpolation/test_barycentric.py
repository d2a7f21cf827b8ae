"""Linear between three taxels: what scipy finds by other means."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from app.maps.interpolation.barycentric import barycentric
from app.maps.interpolation.triangles import TaxelTriangles
from tests.numerics.taxel_fields import held, jittered


def test_it_agrees_with_scipy_between_the_taxels():
    triangles = TaxelTriangles(jittered())
    points, values = held(triangles), np.random.default_rng(2).random(len(triangles.sites))
    expected = LinearNDInterpolator(triangles.sites, values)(points)
    np.testing.assert_allclose(barycentric(triangles, points) @ values, expected, atol=1e-12)
