"""A pull spread over the map: exact at the pins, never more than theirs, and rigid where all agree."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.pull import spread

PLANE = np.random.default_rng(0).uniform(-0.5, 0.5, (200, 2))


def test_each_pin_makes_its_own_move():
    places, moves = PLANE[[3, 50, 120]], np.array([[0.1, 0.0], [0.0, -0.2], [0.0, 0.0]])
    np.testing.assert_allclose(spread(PLANE, places, moves)[[3, 50, 120]], moves, atol=1e-9)


def test_what_all_pins_do_everything_does():
    np.testing.assert_allclose(spread(PLANE, PLANE[:4], np.full((4, 2), 0.3)), 0.3)


def test_nothing_goes_farther_than_the_farthest_pin():
    moves = np.random.default_rng(1).normal(size=(5, 2))
    gone = spread(PLANE, PLANE[:5], moves)
    assert (gone <= moves.max(axis=0) + 1e-12).all()
    assert (gone >= moves.min(axis=0) - 1e-12).all()


def test_near_a_pin_the_map_moves_rigidly():
    near = PLANE[3] + [[1e-3, 0.0], [0.0, -1e-3]]
    gone = spread(near, PLANE[[3, 50]], np.array([[0.1, 0.0], [0.0, 0.0]]))
    np.testing.assert_allclose(gone, [[0.1, 0.0]] * 2, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("turn", [0.3, 2.0])
def test_a_turned_map_is_moved_alike(turn):
    rotation = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    moves = np.array([[0.1, 0.2], [-0.1, 0.0]])
    straight = spread(PLANE, PLANE[:2], moves) @ rotation
    np.testing.assert_allclose(spread(PLANE @ rotation, PLANE[:2] @ rotation, moves @ rotation), straight, atol=1e-12)
