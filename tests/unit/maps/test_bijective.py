"""Flips and crossings are found, and only those."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.bijective import crossings, flipped, signed_areas

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])


def test_areas_have_a_sign():
    faces = np.array([[0, 1, 2], [0, 2, 1], [0, 0, 1]])
    np.testing.assert_allclose(signed_areas(SQUARE, faces), [0.5, -0.5, 0])
    assert flipped(SQUARE, faces).tolist() == [False, True, True]


def test_a_number_that_is_none_counts_as_flipped():
    assert flipped(np.full((3, 2), np.nan), np.array([[0, 1, 2]])).all()


def test_simple_loops_do_not_cross():
    turn = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    star = (1 + 0.5 * np.cos(9 * turn))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    assert crossings(SQUARE) == 0
    assert crossings(star) == 0
    assert crossings(1e-9 * star + 1) == 0
    assert crossings(np.zeros((0, 2))) == 0


def test_each_crossing_counts_once():
    turn = np.linspace(0, 2 * np.pi, 201, endpoint=False)
    eight = np.stack([np.sin(turn + 0.01), np.sin(2 * turn + 0.02)], axis=1)
    assert crossings(eight) == 1
    assert crossings(SQUARE[[0, 2, 1, 3]]) == 1


def test_touching_counts_as_crossing():
    assert crossings(np.array([[0, 0], [2, 0], [2, 1], [1, 0], [0, 1.0]])) > 0


@pytest.mark.parametrize("gap", [1e-15, 1e-3])
def test_two_loops_side_by_side_do_not_cross(gap):
    assert crossings(SQUARE, SQUARE + [1 + gap, 0]) == 0


def test_two_loops_that_overlap_cross():
    assert crossings(SQUARE, SQUARE + [0.5, 0.5]) == 2


def test_the_count_is_that_of_comparing_all_pairs():
    loop = np.random.default_rng(3).normal(size=(60, 2))
    expected = 0
    for i in range(60):
        for j in range(i + 2, 60 - (i == 0)):
            a, b, c, d = loop[i], loop[(i + 1) % 60], loop[j], loop[(j + 1) % 60]
            sides = [np.linalg.det([q - p, r - p]) for p, q, r in ((a, b, c), (a, b, d), (c, d, a), (c, d, b))]
            expected += sides[0] * sides[1] < 0 and sides[2] * sides[3] < 0
    assert expected > 100
    assert crossings(loop) == expected
