"""Damped least squares in levels."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.levels import Level, solve_levels
from app.control.reference import MAX_JOINT_SPEED, MAX_SPEED, WEAK


def random_rows(seed, m, n=7):
    return np.random.default_rng(seed).normal(size=(m, n))


@pytest.mark.parametrize("seed", range(10))
def test_levels_that_do_not_conflict_are_all_met_by_the_least_motion(seed):
    rows, wanted = random_rows(seed, 3), np.array([0.1, -0.2, 0.05])
    levels = [Level(rows[:1], wanted[:1]), Level(rows[1:], wanted[1:])]
    speed, damped = solve_levels(levels, np.zeros(7))
    assert rows @ speed == pytest.approx(wanted, abs=1e-9)
    assert speed == pytest.approx(np.linalg.pinv(rows) @ wanted, abs=1e-9)
    assert not damped


def test_what_is_more_wanted_is_exact_in_a_conflict():
    row = random_rows(0, 1)
    both = np.concatenate([row, random_rows(1, 1)])
    levels = [Level(row, np.array([0.1])), Level(both, np.array([-0.3, 0.2]))]
    speed, _ = solve_levels(levels, np.zeros(7))
    assert (row @ speed)[0] == pytest.approx(0.1, abs=1e-9)
    assert levels[1].rows[1] @ speed == pytest.approx(0.2, abs=1e-6)


def test_rest_moves_only_what_is_free():
    rows, rest = random_rows(3, 3), np.full(7, 0.3)
    speed, _ = solve_levels([Level(rows, np.zeros(3))], rest)
    assert rows @ speed == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.linalg.norm(speed) > 0.1
    assert solve_levels([], rest)[0] == pytest.approx(rest)


@pytest.mark.parametrize("gain", np.geomspace(1e-9, 1.0, 30))
def test_near_a_singularity_the_greatest_point_speed_asks_for_no_more_than_the_greatest_joint_speed(gain):
    rows = np.diag([0.5, gain]) @ np.linalg.qr(random_rows(4, 2, 7).T)[0].T
    speed, damped = solve_levels([Level(rows, np.array([0.0, MAX_SPEED]))], np.zeros(7))
    assert np.linalg.norm(speed) <= MAX_JOINT_SPEED * (1 + 1e-6)
    assert damped == (gain < WEAK)
    weak = 2 * gain / (gain**2 + WEAK**2)
    assert np.linalg.norm(speed) == pytest.approx(MAX_SPEED * (weak if damped else 1 / gain), rel=1e-6)
    strong, _ = solve_levels([Level(rows, np.array([0.1, MAX_SPEED]))], np.zeros(7))
    assert rows[0] @ strong == pytest.approx(0.1, abs=1e-9), "the strong direction is not damped"


def test_nothing_wanted_of_no_joints():
    speed, damped = solve_levels([Level(np.zeros((2, 0)), np.ones(2))], np.zeros(0))
    assert speed.shape == (0,)
    assert not damped
