"""Stress below the surface: Love's rectangle is Boussinesq's point summed up, and both carry what was put on them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad, quad

from app.touch.love import disc_stress, point_stress, reach, rectangle_stress, square_stress

DEPTHS = (1e-4, 2e-3, 0.05)


@pytest.mark.parametrize("depth", DEPTHS)
def test_a_point_force_passes_every_depth_whole(depth):
    inner, _ = quad(lambda r: 2 * np.pi * r * point_stress(r, depth), 0, 20 * depth)
    outer, _ = quad(lambda r: 2 * np.pi * r * point_stress(r, depth), 20 * depth, np.inf)
    assert inner + outer == pytest.approx(1, rel=1e-8)
    assert inner == pytest.approx(disc_stress(20 * depth, depth), rel=1e-8)


@pytest.mark.parametrize("depth", [0.5e-3, 2e-3, 2e-2])
@pytest.mark.parametrize("at", [(0.0, 0.0), (0.003, 0.001), (0.002, -0.0015), (-0.01, 0.007)])
def test_a_rectangle_is_the_sum_of_its_points(at, depth):
    x, y = at
    a, b = 0.002, 0.0015
    summed, _ = dblquad(lambda v, u: point_stress(np.hypot(x - u, y - v), depth), -a, a, -b, b, epsrel=1e-9)
    found = rectangle_stress(np.array(x), np.array(y), depth, sides=(np.array(2 * a), np.array(2 * b)))
    assert found == pytest.approx(summed, rel=1e-7, abs=1e-12)


def test_rectangles_side_by_side_are_one_rectangle():
    x, y = np.random.default_rng(0).uniform(-0.02, 0.02, (2, 200))
    third = 0.006 / 3
    parts = sum(rectangle_stress(x - third * k, y, 0.002, sides=(np.array(third), np.array(0.004))) for k in (-1, 0, 1))
    whole = rectangle_stress(x, y, 0.002, sides=(np.array(0.006), np.array(0.004)))
    np.testing.assert_allclose(parts, whole, atol=1e-14)


def test_a_square_is_a_rectangle_seen_from_a_side():
    away, side = np.random.default_rng(2).uniform(0, 0.02, (2, 100))
    whole = rectangle_stress(away, np.zeros(1), 0.002, sides=(side, side))
    np.testing.assert_allclose(square_stress(away, 0.002, side=side), whole, atol=1e-14)


def test_a_small_rectangle_is_a_point_and_a_large_one_a_fluid():
    x, y = np.random.default_rng(1).uniform(-0.01, 0.01, (2, 50))
    small = rectangle_stress(x, y, 0.002, sides=(np.array(1e-5), np.array(2e-5))) / 2e-10
    np.testing.assert_allclose(small, point_stress(np.hypot(x, y), 0.002), rtol=1e-4)
    large = rectangle_stress(x, y, 0.002, sides=(np.array(10.0), np.array(10.0)))
    np.testing.assert_allclose(large, 1, rtol=1e-8)


@pytest.mark.parametrize("depth", DEPTHS)
def test_under_the_middle_of_a_disc_stress_is_that_of_its_rings(depth):
    radius = 0.004
    rings, _ = quad(
        lambda r: 2 * np.pi * r * point_stress(r, depth), 0, radius, points=[depth] if depth < radius else None
    )
    assert disc_stress(radius, depth) == pytest.approx(rings, rel=1e-7)
    assert disc_stress(radius, depth) == pytest.approx(1 - (1 + (radius / depth) ** 2) ** -1.5)


@pytest.mark.parametrize("share", [0.1, 0.01, 1e-4])
def test_what_is_beyond_the_reach_is_the_share(share):
    assert 1 - disc_stress(reach(0.002, share), 0.002) == pytest.approx(share, rel=1e-9)
    assert reach(0.004, share) == pytest.approx(2 * reach(0.002, share))


def test_stress_does_not_care_for_the_unit_of_length():
    one = point_stress(np.array([0.0, 0.001, 0.01]), 0.002)
    np.testing.assert_allclose(point_stress(np.array([0.0, 1, 10]), 2.0) * 1e6, one, rtol=1e-12)
