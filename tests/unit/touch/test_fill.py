"""The level of water, against sorting and by hand."""

from __future__ import annotations

import numpy as np
import pytest

from app.touch.fill import Guess, fill


def sorted_level(floors, areas, volume):
    """The textbook way: with the k lowest floors wet, the first level that does not reach the next floor."""
    order = np.argsort(floors)
    for k in range(1, len(order) + 1):
        wet = order[:k]
        level = (volume + (areas[wet] * floors[wet]).sum()) / areas[wet].sum()
        if k == len(order) or level <= floors[order[k]]:
            return level
    raise AssertionError("the last floor always holds the rest")


def test_by_hand():
    assert fill(np.array([0.0, 1.0, 4.0]), np.ones(3), 1.0).level == pytest.approx(1.0)
    assert fill(np.array([4.0, 0.0, 1.0]), np.ones(3), 3.0).level == pytest.approx(2.0)
    assert fill(np.array([0.0, 1.0, 4.0]), np.array([1.0, 2.0, 3.0]), 1e6).level == pytest.approx((1e6 + 14) / 6)


def test_it_is_the_level_of_sorting():
    generator = np.random.default_rng(0)
    for _ in range(300):
        count = int(generator.integers(1, 200))
        floors, areas = generator.normal(size=count), generator.uniform(0.1, 2, count)
        volume = 10.0 ** generator.uniform(-6, 3)
        wet = fill(floors, areas, volume)
        assert wet.level == pytest.approx(sorted_level(floors, areas, volume), rel=1e-12, abs=1e-12)
        np.testing.assert_array_equal(wet.points, np.flatnonzero(floors < wet.level))
        np.testing.assert_array_equal(wet.floors, floors[wet.points])
        np.testing.assert_array_equal(wet.areas, areas[wet.points])
        assert wet.areas @ (wet.level - wet.floors) == pytest.approx(volume, rel=1e-9)


def test_the_answer_does_not_depend_on_the_guess_to_the_bit():
    generator, guess = np.random.default_rng(1), Guess()
    areas = generator.uniform(0.1, 2, 120)
    for _ in range(300):
        floors, volume = generator.normal(size=120), 10.0 ** generator.uniform(-6, 3)
        assert fill(floors, areas, volume, guess=guess).level == fill(floors, areas, volume).level


def test_floors_at_infinity_stay_dry_even_if_they_were_wet():
    floors, areas, guess = np.array([0.0, 0.1, 0.2]), np.ones(3), Guess()
    assert len(fill(floors, areas, 1.0, guess=guess).points) == 3
    floors[1] = np.inf
    assert fill(floors, areas, 1.0, guess=guess).level == pytest.approx(0.6)
    assert guess.points.tolist() == [0, 2]
    floors[1] = 0.1
    assert len(fill(floors, areas, 1.0, guess=guess).points) == 3


def test_next_to_no_water_wets_the_lowest_floor():
    wet = fill(np.array([0.3, 0.2, 0.4]), np.ones(3), 5e-324)
    assert wet.points.tolist() == [1]
    assert wet.level == 0.2


@pytest.mark.parametrize("count", [2, 7, 50])
def test_equal_floors_and_floors_apart_by_rounding_end(count):
    areas = np.random.default_rng(2).uniform(0.1, 2, count)
    assert fill(np.full(count, 0.1), areas, 0.3).level == pytest.approx(0.1 + 0.3 / areas.sum())
    floors = 0.1 + np.arange(count) * np.spacing(0.1)
    for volume in (0.0, 1e-17, 1e-16 * areas.sum(), 1.0):
        wet = fill(floors, areas, volume)
        assert (wet.level >= wet.floors).all()
