"""How long a neighbourhood holds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.geometry.pose import Pose
from app.touch.load import Load
from app.touch.neighbourhood import TILT, Neighbourhood
from app.touch.shapes import Ball, Box

UP = np.array([0.0, 0, 1])
GRID = np.stack([k.ravel() for k in np.meshgrid(np.linspace(-0.02, 0.02, 9), np.linspace(-0.02, 0.02, 9), [0.0])], 1)
BALL, BOX = Ball(0.01), Box((0.01, 0.01, 0.01))


def load(shape, *, at=(0, 0, 0.01), normal=UP, turn=(0, 0, 0), point=(0, 0, 0)):
    pose = Pose(Rotation.from_rotvec(turn).as_matrix(), np.asarray(at, dtype=float))
    return Load("link", np.asarray(point, dtype=float), np.asarray(normal), 1.0, shape, pose)


def near(shape, normals=None) -> Neighbourhood:
    normals = np.tile(UP, (len(GRID), 1)) if normals is None else normals
    return Neighbourhood(load(shape), 0.2, np.arange(len(GRID)), GRID, normals, np.ones(len(GRID)),
                         cutoff=0.01, slack=0.002, depth=0.0, extent=0.03)  # fmt: skip


def test_it_holds_until_the_body_has_moved_by_the_slack_and_promises_less_on_the_way():
    ball = near(BALL)
    assert ball.complete == 0.01
    assert ball.holds(load(BALL, at=(0.0015, 0, 0.01)), 0.2)
    assert ball.complete == pytest.approx(0.0085)
    assert not ball.holds(load(BALL, at=(0.0015, 0.0015, 0.01)), 0.2)
    assert ball.holds(load(BALL), 0.2)
    assert ball.complete == 0.01


def test_turning_moves_a_box_but_not_a_ball():
    assert near(BALL).holds(load(BALL, turn=(0, 0, 2.0)), 0.2)
    assert near(BOX).holds(load(BOX, turn=(0, 0, 0.02)), 0.2)
    assert not near(BOX).holds(load(BOX, turn=(0, 0, 0.2)), 0.2)


def test_a_box_that_rolls_about_the_place_it_presses_hardly_moves_there():
    turn = 0.02
    rolled = Rotation.from_rotvec((turn, 0, 0)).as_matrix() @ [0, 0, 0.01]
    box = near(BOX)
    assert box.holds(load(BOX, at=rolled, turn=(turn, 0, 0)), 0.2)
    assert box.complete > 0.01 - 1.5 * 0.03 * turn


def test_another_body_another_normal_and_another_question_are_other_neighbourhoods():
    ball = near(BALL)
    assert ball.holds(load(Ball(0.01)), 0.2), "an equal ball is the same"
    assert not ball.holds(load(Ball(0.011)), 0.2)
    assert not ball.holds(load(BALL), -0.2)
    tilted = np.array([np.sin(1.1 * TILT), 0, np.cos(1.1 * TILT)])
    assert not ball.holds(load(BALL, normal=tilted), 0.2)


def test_a_point_at_the_limb_is_far_while_it_looks_away():
    normals = np.tile(UP, (len(GRID), 1))
    normals[0] = [np.sqrt(1 - 0.21**2), 0, 0.21]
    ball = near(BALL, normals)
    assert np.isfinite(ball.distances(load(BALL))).all()
    away = np.array([-np.sin(0.03), 0, np.cos(0.03)])
    distances = ball.distances(load(BALL, normal=away))
    assert distances[0] == np.inf
    assert np.isfinite(distances[1:]).all()


def test_distances_are_those_of_the_load():
    turned = load(BOX, at=(0.003, 0.001, 0.008), turn=(0.3, 0.2, -0.1))
    np.testing.assert_allclose(near(BOX).distances(turned), turned.distances(GRID), atol=1e-16)
