"""A placement keeps angles, and lengths too unless a person enlarges a patch."""

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


PLACEMENTS = [
    Placement(0.7, (1.0, -2.0)), Placement(-2.0, (0.0, 0.3), mirrored=True), Placement(3.0, (2.0, 1.0), scale=2.5),
    Placement(-0.4, (0.5, 0.0), mirrored=True, scale=0.2),
]  # fmt: skip


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_a_scale_is_of_all_lengths_and_the_way_back_is_exact(placement):
    drawn = placement.apply(POINTS)
    np.testing.assert_allclose(_lengths(drawn), placement.scale * _lengths(POINTS), atol=1e-12)
    np.testing.assert_allclose(placement.back(drawn), POINTS, atol=1e-12)


@pytest.mark.parametrize("second", PLACEMENTS)
@pytest.mark.parametrize("first", PLACEMENTS)
def test_one_after_another_is_both(first, second):
    both = second.after(first)
    np.testing.assert_allclose(both.apply(POINTS), second.apply(first.apply(POINTS)), atol=1e-12)
    assert abs(both.angle) <= np.pi


@pytest.mark.parametrize(("change", "says"), [({"offset": (1e6, 0.0)}, "too far out"), ({"scale": 20.0}, "too large")])
def test_a_placement_out_of_bounds_is_refused(change, says):
    with pytest.raises(MapError, match=says):
        MapLayout((Placement(), Placement(**change)))


@pytest.mark.parametrize("placement", [Placement(np.nan), Placement(0.0, (np.inf, 0.0)), Placement(scale=np.nan)])
def test_a_placement_that_is_no_place_is_refused(placement):
    with pytest.raises(MapError, match="not finite"):
        MapLayout((placement,))
