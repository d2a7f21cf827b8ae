"""Motion along the normal where the normal has errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tactile_maps.control.force_loop.normal_motion import (
    ENOUGH_TILT,
    LEAST_ASIDE,
    LEAST_TILT,
    RISE_SHARE,
    RisingForces,
    bearable_tilt,
    slow_aside,
)
from tactile_maps.control.motion.limits import ActiveLimits, LimitKind

MOST_FORCE = 40.0
MOST_RISE = RISE_SHARE * MOST_FORCE
UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize("seed", range(5))
def test_larger_error_of_the_normal_changes_the_sign_of_the_response(seed):
    """The worst error of each size is tried: towards where the motion goes."""
    move = np.random.default_rng(seed).normal(size=(3, 2))
    tilt = bearable_tilt(UP @ move, move)
    way = move @ (UP @ move)
    away = way - way[2] * UP
    away /= np.linalg.norm(away)
    responses = [way @ (math.cos(angle) * UP - math.sin(angle) * away) for angle in (0.99 * tilt, 1.01 * tilt)]
    assert responses[0] > 0 > responses[1]


def test_joints_that_move_a_point_in_all_directions_tolerate_any_error():
    assert bearable_tilt(UP, np.eye(3)) == pytest.approx(math.pi / 2)
    assert bearable_tilt(np.zeros(2), np.zeros((3, 2))) == pytest.approx(math.pi / 2), "nothing moves"


def test_point_slides_slowly_in_addition_to_the_desired_speed_where_little_error_is_tolerated():
    move = np.array([[1.0], [0.0], [0.1]])
    speed = np.array([0.5])
    limits = ActiveLimits()
    assert slow_aside(move, UP, LEAST_TILT, speed, limits) == pytest.approx([LEAST_ASIDE])
    [limit] = limits.found
    assert limit.kind is LimitKind.WEAK_DIRECTION
    assert limit.value == pytest.approx(0.5 - LEAST_ASIDE), "lost speed"
    assert limit.direction == pytest.approx((1.0, 0.0, 0.0))
    assert slow_aside(move, UP, 0.0, speed, limits, desired=0.1) == pytest.approx([LEAST_ASIDE + 0.1])
    between = [float(slow_aside(move, UP, tilt, speed, limits)[0]) for tilt in np.linspace(LEAST_TILT, ENOUGH_TILT, 9)]
    assert np.all(np.diff(between) >= 0)
    assert between[-1] == speed[0]


def rises(*forces: float, goal: float = 3.0, tilt: float = 0.1) -> list[bool]:
    watch = RisingForces()
    return [watch.look([(1, force, goal, tilt)], MOST_FORCE) for force in forces]


def test_rising_force_is_reported_until_half_of_the_rise_has_gone():
    least = 10.0 + MOST_RISE
    assert rises(30.0, 10.0, least - 0.1, least + 0.1, 10.1 + MOST_RISE / 2, 9.9 + MOST_RISE / 2) == [
        False,
        False,
        False,
        True,
        True,
        False,
    ]


def test_force_may_rise_below_the_goal_and_where_large_errors_are_tolerated():
    assert not any(rises(0.0, 3.0 + RISE_SHARE, goal=3.0))
    assert not any(rises(4.0, 30.0, tilt=ENOUGH_TILT))


def test_lower_goal_does_not_count_as_a_rise():
    watch = RisingForces()
    assert not watch.look([(1, 25.0, 25.0, 0.1)], MOST_FORCE)
    assert not watch.look([(1, 25.0, 3.0, 0.1)], MOST_FORCE)
