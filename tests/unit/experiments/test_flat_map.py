"""A flat skin whose map is itself."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.flat_map import SIDE, flat_map
from app.maps.bijective import signed_areas


@pytest.mark.parametrize("taxels", [1, 2, 100, 1000])
def test_map_and_body_are_the_same_places(taxels):
    map_ = flat_map(taxels)
    worn = map_.skin.patches[0].taxels
    assert len(map_.skin) == round(np.sqrt(taxels)) ** 2
    np.testing.assert_allclose(map_.taxel_points, worn.positions[:, :2], atol=1e-12)
    np.testing.assert_allclose(map_.bounds, [[0, 0], [SIDE, SIDE]], atol=1e-12)
    assert map_.skin.areas.sum() == pytest.approx(SIDE**2)
    assert map_.skin.areas.min() > 0
    assert (signed_areas(map_.uv[0], map_.charts[0].faces) > 0).all()


def test_the_seed_decides_all():
    np.testing.assert_array_equal(flat_map(100, seed=3).taxel_points, flat_map(100, seed=3).taxel_points)
    assert np.abs(flat_map(100, seed=3).taxel_points - flat_map(100, seed=4).taxel_points).max() > 1e-3
