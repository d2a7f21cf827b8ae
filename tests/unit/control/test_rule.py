"""What rules share: rows of a contact, and the answer of an arm whose joints end."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.levels import Level
from app.control.reference import PostureReference
from app.control.rule import in_space, one_level, solve_freely
from tests.touch import arm
from tests.unit.control.touched import contact


def limits_of_joints() -> PostureReference:
    return PostureReference(arm().robot, np.ones(7))


def test_a_contact_that_may_slide_has_one_row():
    rows, speed = in_space(contact(), np.array([1.0, 2.0, 3.0]))
    assert (rows.shape, speed) == ((1, 4), [3.0])
    rows, speed = in_space(contact(np.zeros(2)), np.array([1.0, 2.0, 3.0]))
    assert rows.shape == (3, 4)
    assert speed == pytest.approx([1, 2, 3])
    [level] = one_level([in_space(contact(), np.ones(3)), in_space(contact(np.zeros(2)), np.ones(3))])
    assert level.rows.shape == (4, 4)


def test_a_joint_at_its_limit_leaves_the_work_to_the_others():
    robot = arm().robot
    joint = next(k for k, j in enumerate(robot.joints) if np.isfinite(j.upper))
    start, limits = robot.home.copy(), []
    start[joint] = robot.joints[joint].upper
    level = Level(np.full((1, 7), 0.5), np.array([0.2]))
    speed = solve_freely([level], limits_of_joints(), start, limits)
    assert speed[joint] == 0
    assert level.rows @ speed == pytest.approx([0.2])
    assert limits == ["joint limit"]


def test_when_no_joint_is_left_nothing_moves():
    robot, limits = arm().robot, []
    start = np.array([j.upper for j in robot.joints])
    assert np.isfinite(start).all()
    assert not solve_freely([Level(np.ones((1, 7)), np.array([0.2]))], limits_of_joints(), start, limits).any()
    assert "joint limit" in limits


def test_what_hardly_moves_anything_is_said():
    limits: list[str] = []
    solve_freely([Level(np.full((1, 7), 0.01), np.array([0.2]))], limits_of_joints(), arm().robot.home, limits)
    assert "the arm can hardly move along this contact" in limits
