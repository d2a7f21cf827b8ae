"""What presses, as a value."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.geometry.pose import Pose
from app.touch.load import Load, ball_load
from app.touch.shapes import Ball, Box

UP = np.array([0.0, 0.0, 1.0])


def test_a_balls_lowest_point_is_as_deep_as_it_says():
    point, normal = np.array([0.1, 0.2, 0.3]), np.array([0.6, 0.0, 0.8])
    load = ball_load("arm", point, normal, 5.0, 0.01, depth=0.002)
    assert load.distances(point[None]) == pytest.approx([-0.002])
    assert load.distances(point[None] - 0.002 * normal) == pytest.approx([0.0], abs=1e-15)
    assert load.shape == Ball(0.01)
    assert load.force == 5.0
    assert ball_load("arm", point, normal, 5.0, 0.01).distances(point[None]) == pytest.approx([0.0], abs=1e-15)


def test_distances_are_in_the_links_frame():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    load = Load("arm", np.zeros(3), UP, 1.0, Box((0.03, 0.01, 0.01)), Pose(turn, np.array([1.0, 0, 0])))
    assert load.distances(np.array([[1.0, 0.05, 0], [1.05, 0, 0]])) == pytest.approx([0.02, 0.04])


def test_its_arrays_are_its_own():
    point = np.zeros(3)
    load = ball_load("arm", point, UP, 1.0, 0.01)
    point[0] = 1.0
    assert load.point[0] == 0.0
    for array in (load.point, load.normal, load.pose.translation, load.pose.rotation):
        assert not array.flags.writeable


@pytest.mark.parametrize("force", [-1e-9, np.nan, np.inf])
def test_a_force_that_is_none_is_refused(force):
    with pytest.raises(SimulationError, match=r"on arm: there is no such load"):
        ball_load("arm", np.zeros(3), UP, force, 0.01)


@pytest.mark.parametrize("radius", [0.0, -0.01, np.nan, np.inf])
def test_a_ball_that_is_none_is_refused(radius):
    with pytest.raises(SimulationError, match="no such ball"):
        ball_load("arm", np.zeros(3), UP, 1.0, radius)
