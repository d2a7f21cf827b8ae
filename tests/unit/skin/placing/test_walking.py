"""Steps over a surface: as long as asked for, and told where they leave it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from app.geometry.closest import ClosestPoint
from app.skin.placing.walking import carried, some_directions, walk
from tests.numerics.map_surfaces import frustum, sheet, sphere


def test_a_step_on_a_ball_is_as_long_as_asked_for():
    ball = sphere(subdivisions=4)
    faces = np.arange(0, len(ball.faces), 50)
    starts = ball.vertices[ball.faces[faces]].mean(axis=1)
    steps = some_directions(ball.face_normals[faces], np.linspace(0, 6, len(faces)))
    ends, at, sound = walk(ball, ClosestPoint(ball), starts, faces, steps, 0.01)
    assert sound.all()
    assert np.linalg.norm(ends - starts, axis=1) == pytest.approx(0.01, rel=0.02)
    assert np.linalg.norm(ends, axis=1) == pytest.approx(0.05, rel=1e-2)
    assert ((ends - starts) * steps).sum(axis=1).min() > 0.0098
    assert ClosestPoint(ball).query(ends)[2] == pytest.approx(0, abs=1e-12)
    assert len(at) == len(faces)


def test_a_step_over_the_border_is_not_sound():
    flat = sheet()
    starts, faces = np.tile(flat.vertices[flat.faces[0]].mean(axis=0), (2, 1)), np.zeros(2, dtype=int)
    steps = np.array([[-1.0, 0, 0], [1.0, 0, 0]])
    assert walk(flat, ClosestPoint(flat), starts, faces, steps, 0.02)[2].tolist() == [False, True]


def test_a_step_through_a_thin_wall_is_not_sound():
    tube = frustum(0.004, 0.004, length=0.1)
    start = tube.vertices[tube.faces[700]].mean(axis=0)[None]
    across = -(start * [[1, 1, 0]]) / np.linalg.norm(start[0, :2])
    assert not walk(tube, ClosestPoint(tube), start, np.array([700]), across, np.array([0.008]))[2][0]


def test_directions_are_unit_and_level():
    normals = np.random.default_rng(1).normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    some = some_directions(normals, np.zeros(50))
    quarter = some_directions(normals, np.full(50, np.pi / 2))
    assert (some * normals).sum(axis=1) == pytest.approx(0, abs=1e-12)
    assert np.cross(some, quarter) == pytest.approx(normals)


def test_a_direction_carried_around_a_tube_keeps_its_slope():
    turn = np.linspace(0, 2 * np.pi, 25)
    normals = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    direction = np.array([[0.0, 0.8, 0.6]])
    for before, after in pairwise(normals):
        direction = carried(direction, before[None], after[None])
        assert direction[0, 2] == pytest.approx(0.6)
        assert direction[0] @ after == pytest.approx(0, abs=1e-12)
    assert direction == pytest.approx(np.array([[0.0, 0.8, 0.6]]))
