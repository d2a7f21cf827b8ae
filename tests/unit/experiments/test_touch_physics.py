"""A ball held in a ground: the physics reads it as the closed form says, for as long as one likes."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.dense_touch import PRESSED, ball_radius
from app.experiments.touch_physics import PHYSICS, held, step
from app.experiments.touch_skins import GROUNDS
from app.geometry.pose import Pose
from app.touch.layer import Layer
from app.touch.load import Load, ball_load
from app.touch.shapes import Box


def ball(ground, contact=0.01):
    at, normal = ground.place(0.003, -0.004)
    return ball_load(ground.dense.link, at, normal, 1.0, ball_radius(contact), depth=PRESSED)


@pytest.mark.parametrize("name", GROUNDS)
def test_depth_is_that_of_each_taxel_in_the_ball(name):
    ground = GROUNDS[name](1000, 0)
    load = ball(ground)
    inside = -load.shape.distance(load.pose.inverse.points(ground.skin.patches[0].taxels.positions))
    expected = Layer().foundation * np.maximum(inside, 0)
    assert (expected > 0).sum() >= 3
    np.testing.assert_allclose(step(held(ground, "depth", load)), expected, atol=0.02 * expected.max())


@pytest.mark.parametrize("name", GROUNDS)
def test_the_foundation_is_the_sum_over_the_points_in_the_ball(name):
    ground = GROUNDS[name](316, 0)
    load, points = ball(ground), ground.skin.patches[0].taxels.quadrature
    radial = load.pose.inverse.points(points.positions)
    across = -np.einsum("ij,ij->i", radial, load.pose.inverse.directions(points.normals))
    inside = np.maximum(-load.shape.distance(radial), 0) * across / np.linalg.norm(radial, axis=1)
    inside[points.normals @ load.normal < 0] = 0
    expected = Layer().foundation * np.bincount(points.taxel, inside * points.areas) / ground.skin.areas
    assert (expected > 0).sum() >= 3
    np.testing.assert_allclose(step(held(ground, "foundation", load)), expected, rtol=2e-5, atol=1e-2)


@pytest.mark.parametrize("model", PHYSICS)
def test_nothing_moves(model):
    ground = GROUNDS["flat"](100, 0)
    simulation = held(ground, model, ball(ground, 0.03))
    first = step(simulation)
    assert first.any()
    for _ in range(20):
        np.testing.assert_array_equal(step(simulation), first)


def test_only_a_ball_is_meant():
    ground = GROUNDS["flat"](100, 0)
    load = Load("square", np.zeros(3), np.array([0, 0, 1.0]), 1.0, Box((0.01, 0.01, 0.01)), Pose.identity())
    with pytest.raises(TypeError, match="a ball is meant"):
        held(ground, "depth", load)
