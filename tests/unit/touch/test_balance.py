"""A stiff body on springs: force and place are matched wherever they can be, and said where they cannot."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from app.touch.balance import balanced
from app.touch.fill import fill


def bed(seed: int, count: int = 200, radius: float = 0.02):
    """Springs at random under a ball: offsets, gaps, areas."""
    generator = np.random.default_rng(seed)
    offsets = generator.uniform(-0.01, 0.01, (count, 2))
    gaps = radius - np.sqrt(radius**2 - (offsets**2).sum(axis=1))
    return offsets, gaps, generator.uniform(0.5, 1.5, count) * 4e-4 / count


def rest(offsets, gaps, areas, volume):
    return balanced(gaps, areas, offsets, volume, level=fill(gaps, areas, volume).level)


@pytest.mark.parametrize("newtons", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("seed", range(8))
def test_force_and_place_are_matched(seed, newtons):
    offsets, gaps, areas = bed(seed)
    offsets = offsets - np.random.default_rng(seed).uniform(-0.003, 0.003, 2)
    found = rest(offsets, gaps, areas, newtons / 3e7)
    assert found.matched
    assert found.borne.sum() == pytest.approx(newtons / 3e7, rel=1e-9)
    np.testing.assert_allclose(found.borne @ offsets / found.borne.sum(), 0, atol=1e-10)
    plane = found.plane[0] + offsets @ found.plane[1:]
    np.testing.assert_allclose(found.borne, areas * np.maximum(plane - gaps, 0), rtol=1e-9, atol=1e-9 * newtons / 3e7)


def test_it_is_the_least_of_the_energy():
    offsets, gaps, areas = bed(0)
    offsets, volume = offsets - [0.002, -0.001], 1e-7
    found = rest(offsets, gaps, areas, volume)

    def energy(plane):
        sunk = np.maximum(plane[0] * 1e-3 + offsets @ plane[1:] - gaps, 0)
        return 1e12 * (0.5 * areas @ sunk**2 - volume * plane[0] * 1e-3)

    slow = minimize(energy, [1.0, 0, 0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    np.testing.assert_allclose(found.plane, slow.x * [1e-3, 1, 1], atol=1e-6)


def test_a_straight_body_stays_straight():
    ring = 0.004 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1], [0, 0]])
    found = rest(ring, np.array([1e-4, 1e-4, 1e-4, 1e-4, 0]), np.full(5, 1e-5), 1e-8)
    assert found.matched
    np.testing.assert_allclose(found.plane[1:], 0, atol=1e-15)
    assert found.plane[0] == pytest.approx((1e-8 + 4e-9) / 5e-5)


@pytest.mark.parametrize("unit", [1e-2, 1.0, 1e3])
def test_the_unit_of_length_does_not_matter(unit):
    offsets, gaps, areas = bed(3)
    offsets = offsets + [0.001, 0.002]
    one, other = (rest(u * offsets, u * gaps, u**2 * areas, u**3 * 2e-8) for u in (1.0, unit))
    np.testing.assert_allclose(other.borne / unit**3, one.borne, rtol=1e-6, atol=1e-9 * 2e-8)
    np.testing.assert_allclose(other.plane[1:], one.plane[1:], rtol=1e-6)


@pytest.mark.parametrize("beyond", [(0.02, 0.0), (0.0101, 0.0101), (-0.5, 0.3)])
def test_a_force_outside_the_springs_has_no_balance(beyond):
    offsets, gaps, areas = bed(1)
    found = rest(offsets - np.array(beyond), gaps, areas, 1e-7)
    assert not found.matched


def test_a_force_in_a_hollow_of_the_springs_has_none():
    corner = np.array([[0.01, 0.0], [0.0, 0.01], [-0.001, 0.0], [0.0, -0.001]])
    found = rest(corner - [0.006, 0.006], np.zeros(4), np.full(4, 1e-5), 1e-8)
    assert found.rounds > 0, "no line along the axes tells the force from the springs"
    assert not found.matched


def test_one_spring_bears_a_force_that_acts_on_it_and_no_other():
    assert rest(np.zeros((1, 2)), np.zeros(1), np.full(1, 1e-5), 1e-8).matched
    assert not rest(np.full((1, 2), 1e-3), np.zeros(1), np.full(1, 1e-5), 1e-8).matched
