"""Nearest posture of an arm of two hinges in a plane, for which all distances are known."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.path_following.nearest_posture import TargetReach
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.support.generated_robots import chain, load, model

LENGTH = 0.5
"""Length of each link [m]; the arm begins at the origin and points up at zero."""
TIP = np.array([0.0, 0.0, LENGTH])
TARGET, OTHER = (SurfacePoint(0, face, (1.0, 0.0, 0.0)) for face in (0, 1))
STRAIGHT = np.zeros(2)


@pytest.fixture
def reach(tmp_path):
    """Return the search for an arm whose joints have this range [rad]."""

    def made(most: float) -> TargetReach:
        text = model(chain("yy", LENGTH, ranges=f"{-most:g} {most:g}"), height=0.0)
        return TargetReach(load(text, tmp_path))

    return made


def result(search, goal, *, posture=STRAIGHT, target=TARGET):
    for _ in range(100):
        found = search.short_by(target, "link2", TIP, np.array(goal), posture)
    return found


@pytest.mark.parametrize(
    ("goal", "short_by"),
    [
        ((0.0, 0.0, 2 * LENGTH + 0.1), 0.1),  # beyond the straight arm
        ((0.0, 0.0, 2 * LENGTH - 0.1), None),  # the straight arm is at a stationary point, but can bend
        ((0.4, 0.0, 0.5), None),
        ((0.2, 0.1, 0.7), 0.1),  # off the plane of the arm
    ],
)
def test_distance_of_a_target_is_that_to_the_workspace(reach, goal, short_by):
    found = result(reach(2.0), goal)
    assert found == (None if short_by is None else pytest.approx(short_by, abs=1e-4))


def test_distance_of_a_target_beyond_joint_limits_is_that_of_the_best_valid_posture(reach):
    goal = np.array([0.5, 0.0, 2 * LENGTH - 0.2])
    turns = np.linspace(-0.2, 0.2, 201)
    first, second = np.meshgrid(turns, turns)
    x = LENGTH * (np.sin(first) + np.sin(first + second))
    z = LENGTH * (np.cos(first) + np.cos(first + second))
    nearest = np.hypot(x - goal[0], z - goal[2]).min()
    assert result(reach(0.2), goal) == pytest.approx(nearest, abs=1e-3)


def test_no_distance_is_stated_before_the_search_ends(reach):
    search = reach(2.0)
    goal = np.array([0.0, 0.0, 2 * LENGTH + 0.1])
    assert search.short_by(TARGET, "link2", TIP, goal, STRAIGHT) is None
    assert result(search, goal) is not None
    assert search.short_by(OTHER, "link2", TIP, goal, STRAIGHT) is None, "another target"
    assert result(search, goal, target=OTHER) is not None
    assert search.short_by(OTHER, "link2", TIP, goal - [0.0, 0.0, 0.01], STRAIGHT) is None, "the contact has moved"
