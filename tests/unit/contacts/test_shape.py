"""Ellipses of contact regions: their size and direction on body and map."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.place import Place
from app.contacts.shape import principal_axes
from app.geometry.surface_point import SurfacePoint

AT = SurfacePoint(0, 0, (1.0, 0.0, 0.0))


def flat(*, map_sides=((1.0, 0.0), (0.0, 1.0)), normal=(0.0, 0.0, 1.0), sides=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))):
    zero = np.zeros(3)
    return Place(AT, np.zeros(2), zero, np.array(normal), np.array(sides), np.array(map_sides), False)


def ellipse(long: float, short: float, angle: float, count: int = 20_000) -> np.ndarray:
    """Points spread evenly over an ellipse in the plane z = 0."""
    random = np.random.default_rng(0)
    turn, reach = random.uniform(0, 2 * np.pi, count), np.sqrt(random.uniform(0, 1, count))
    x, y = long * reach * np.cos(turn), short * reach * np.sin(turn)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * x - s * y, s * x + c * y, 0 * x], axis=1)


@pytest.mark.parametrize("angle", [0.0, 0.4, 1.5, -1.0])
def test_an_evenly_pressed_ellipse_is_found(angle):
    points = ellipse(0.03, 0.01, angle)
    axes, on_map = principal_axes(points, np.full(len(points), 1 / len(points)), 0.0, flat())
    assert np.linalg.norm(axes, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
    assert abs(axes[0] @ [np.cos(angle), np.sin(angle), 0]) == pytest.approx(0.03, rel=0.02)
    assert axes[0] @ axes[1] == pytest.approx(0, abs=1e-15)
    assert on_map == pytest.approx(axes[:, :2])


def test_a_region_off_its_centre_has_the_same_axes():
    points, share = ellipse(0.03, 0.01, 0.4), np.full(20_000, 1 / 20_000)
    one, other = (principal_axes(points + shift, share, 0.0, flat())[0] for shift in (0.0, np.array([0.01, 0.02, 0.0])))
    assert one == pytest.approx(other, abs=1e-12)


def test_one_taxel_is_as_large_as_its_area():
    axes, _ = principal_axes(np.zeros((1, 3)), np.ones(1), 1e-4 / 12, flat())
    assert np.linalg.norm(axes, axis=1) == pytest.approx(2 * np.sqrt(1e-4 / 12))


def test_a_map_that_stretches_carries_the_axes_along():
    points, share = ellipse(0.03, 0.01, 0.0), np.full(20_000, 1 / 20_000)
    _, on_map = principal_axes(points, share, 0.0, flat(map_sides=((2.0, 0.0), (0.0, 0.5))))
    assert np.linalg.norm(on_map, axis=1) == pytest.approx([0.06, 0.005], rel=0.02)


def test_a_triangle_without_area_carries_nothing():
    points, share = ellipse(0.03, 0.01, 0.0), np.full(20_000, 1 / 20_000)
    axes, on_map = principal_axes(points, share, 0.0, flat(sides=((1.0, 0.0, 0.0), (2.0, 0.0, 0.0))))
    assert np.linalg.norm(axes[0]) == pytest.approx(0.03, rel=0.02)
    assert not on_map.any()


@pytest.mark.parametrize("side", [(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_a_side_along_the_normal_gives_axes_all_the_same(side):
    points, share = ellipse(0.03, 0.01, 0.0), np.full(20_000, 1 / 20_000)
    axes, _ = principal_axes(points, share, 0.0, flat(sides=(side, (0.0, 1.0, 0.0))))
    assert np.linalg.norm(axes, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
    x = principal_axes(points[:, [2, 0, 1]], share, 0.0, flat(sides=((1.0, 0, 0), (0, 1.0, 0)), normal=(1.0, 0, 0)))[0]
    assert np.linalg.norm(x, axis=1) == pytest.approx([0.03, 0.01], rel=0.02)
