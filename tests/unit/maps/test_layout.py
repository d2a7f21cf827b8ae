"""A placement is rigid: lengths on the map stay true."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.maps.layout import MapLayout, Placement

POINTS = np.random.default_rng(0).normal(size=(20, 2))


def _lengths(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


@pytest.mark.parametrize(
    "placement", [Placement(), Placement(0.7, (1.0, -2.0)), Placement(-2.0, (0.0, 0.3), mirrored=True)]
)
def test_lengths_stay(placement):
    np.testing.assert_allclose(_lengths(placement.apply(POINTS)), _lengths(POINTS), atol=1e-12)


def test_a_quarter_turn_is_counter_clockwise_and_comes_before_the_move():
    np.testing.assert_allclose(Placement(np.pi / 2, (5.0, 0.0)).apply(np.array([[1.0, 0.0]])), [[5, 1]], atol=1e-12)


def test_mirroring_comes_first():
    mirrored = Placement(np.pi / 2, (0.0, 0.0), mirrored=True)
    np.testing.assert_allclose(mirrored.apply(np.array([[1.0, 0.0]])), [[0, -1]], atol=1e-12)


@pytest.mark.parametrize("placement", [Placement(np.nan), Placement(0.0, (np.inf, 0.0))])
def test_a_placement_that_is_no_place_is_refused(placement):
    with pytest.raises(MapError, match="not finite"):
        MapLayout((placement,))
