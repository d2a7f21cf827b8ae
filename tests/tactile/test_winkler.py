"""The level and the tilt at which a bed of springs carries a force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from tactile_maps.tactile.mechanics.winkler import WarmStart, winkler_level, winkler_tilt


def sorted_level(floors, areas, volume):
    """The textbook way: with the k lowest floors wet, the first level that does not reach the next floor."""
    order = np.argsort(floors)
    for k in range(1, len(order) + 1):
        wet = order[:k]
        level = (volume + (areas[wet] * floors[wet]).sum()) / areas[wet].sum()
        if k == len(order) or level <= floors[order[k]]:
            return level
    raise AssertionError("the last floor always holds the rest")


def test_level_equals_the_one_found_by_sorting():
    generator = np.random.default_rng(0)
    for _ in range(300):
        count = int(generator.integers(1, 200))
        floors = generator.normal(size=count)
        areas = generator.uniform(0.1, 2, count)
        volume = 10.0 ** generator.uniform(-6, 3)
        wet = winkler_level(floors, areas, volume)
        assert wet.level == pytest.approx(sorted_level(floors, areas, volume), rel=1e-12, abs=1e-12)
        np.testing.assert_array_equal(wet.points, np.flatnonzero(floors < wet.level))
        np.testing.assert_array_equal(wet.floors, floors[wet.points])
        np.testing.assert_array_equal(wet.areas, areas[wet.points])
        assert wet.areas @ (wet.level - wet.floors) == pytest.approx(volume, rel=1e-9)


def test_level_does_not_depend_on_the_guess():
    generator = np.random.default_rng(1)
    guess = WarmStart()
    areas = generator.uniform(0.1, 2, 120)
    for _ in range(300):
        floors = generator.normal(size=120)
        volume = 10.0 ** generator.uniform(-6, 3)
        assert winkler_level(floors, areas, volume, guess=guess).level == winkler_level(floors, areas, volume).level


def test_floors_at_infinity_stay_dry_even_if_initially_wet():
    floors = np.array([0.0, 0.1, 0.2])
    areas = np.ones(3)
    guess = WarmStart()
    assert len(winkler_level(floors, areas, 1.0, guess=guess).points) == 3
    floors[1] = np.inf
    assert winkler_level(floors, areas, 1.0, guess=guess).level == pytest.approx(0.6)
    assert guess.points.tolist() == [0, 2]
    floors[1] = 0.1
    assert len(winkler_level(floors, areas, 1.0, guess=guess).points) == 3


def test_tiny_volume_of_water_wets_the_lowest_floor():
    wet = winkler_level(np.array([0.3, 0.2, 0.4]), np.ones(3), 5e-324)
    assert wet.points.tolist() == [1]
    assert wet.level == 0.2


@pytest.mark.parametrize("count", [2, 7, 50])
def test_iteration_terminates_for_equal_and_nearly_equal_floors(count):
    areas = np.random.default_rng(2).uniform(0.1, 2, count)
    assert winkler_level(np.full(count, 0.1), areas, 0.3).level == pytest.approx(0.1 + 0.3 / areas.sum())
    floors = 0.1 + np.arange(count) * np.spacing(0.1)
    for volume in (0.0, 1e-17, 1e-16 * areas.sum(), 1.0):
        wet = winkler_level(floors, areas, volume)
        assert (wet.level >= wet.floors).all()


def bed(seed: int, count: int = 200, radius: float = 0.02):
    """Springs at random under a ball: offsets, gaps, areas."""
    generator = np.random.default_rng(seed)
    offsets = generator.uniform(-0.01, 0.01, (count, 2))
    gaps = radius - np.sqrt(radius**2 - (offsets**2).sum(axis=1))
    return offsets, gaps, generator.uniform(0.5, 1.5, count) * 4e-4 / count


def rest(offsets, gaps, areas, volume):
    return winkler_tilt(gaps, areas, offsets, volume, level=winkler_level(gaps, areas, volume).level)


@pytest.mark.parametrize("newtons", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("seed", range(8))
def test_force_and_centre_of_pressure_are_matched(seed, newtons):
    offsets, gaps, areas = bed(seed)
    offsets = offsets - np.random.default_rng(seed).uniform(-0.003, 0.003, 2)
    found = rest(offsets, gaps, areas, newtons / 3e7)
    assert found.matched
    assert found.borne.sum() == pytest.approx(newtons / 3e7, rel=1e-9)
    np.testing.assert_allclose(found.borne @ offsets / found.borne.sum(), 0, atol=1e-10)
    plane = found.plane[0] + offsets @ found.plane[1:]
    np.testing.assert_allclose(found.borne, areas * np.maximum(plane - gaps, 0), rtol=1e-9, atol=1e-9 * newtons / 3e7)


def test_tilt_minimizes_the_energy():
    offsets, gaps, areas = bed(0)
    offsets = offsets - [0.002, -0.001]
    volume = 1e-7
    found = rest(offsets, gaps, areas, volume)

    def energy(plane):
        sunk = np.maximum(plane[0] * 1e-3 + offsets @ plane[1:] - gaps, 0)
        return 1e12 * (0.5 * areas @ sunk**2 - volume * plane[0] * 1e-3)

    slow = minimize(energy, [1.0, 0, 0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000})
    np.testing.assert_allclose(found.plane, slow.x * [1e-3, 1, 1], atol=1e-6)


@pytest.mark.parametrize("beyond", [(0.02, 0.0), (0.0101, 0.0101), (-0.5, 0.3)])
def test_force_outside_the_springs_has_no_balance(beyond):
    offsets, gaps, areas = bed(1)
    found = rest(offsets - np.array(beyond), gaps, areas, 1e-7)
    assert not found.matched


def test_force_in_a_concavity_of_the_springs_has_no_balance():
    corner = np.array([[0.01, 0.0], [0.0, 0.01], [-0.001, 0.0], [0.0, -0.001]])
    found = rest(corner - [0.006, 0.006], np.zeros(4), np.full(4, 1e-5), 1e-8)
    assert found.rounds > 0, "a search along the axes cannot find the force of the springs"
    assert not found.matched
