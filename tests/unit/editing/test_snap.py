"""Snapping brings a gesture to what it nearly met, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from app.editing.arrange import move, rotate
from app.editing.patches import show
from app.editing.snap import snap_angle, snap_move


def _near(document, gap):
    """A move of patch 1 that brings its left side to ``gap`` right of patch 0's right side."""
    boxes = document.map.boxes
    return np.array([boxes[0, 1, 0] - boxes[1, 0, 0] + gap, 1.0])


def test_a_side_snaps_to_a_side_and_says_where(document):
    snap = snap_move(document, [1], _near(document, 0.001), reach=0.002)
    moved = move(document, [1], snap.by)
    assert moved.map.boxes[1, 0, 0] == pytest.approx(document.map.boxes[0, 1, 0], abs=1e-12)
    assert snap.x == (pytest.approx(document.map.boxes[0, 1, 0]),)
    assert (snap.by[1], snap.y) == (1.0, ()), "one coordinate snaps without the other"


def test_what_is_not_near_is_left_alone(document):
    by = _near(document, 0.001)
    assert snap_move(document, [1], by, reach=0.0).by == tuple(by)
    assert snap_move(document, [1], (3.0, 3.0), reach=0.002).by == (3.0, 3.0)


def test_hidden_patches_and_those_that_move_along_are_not_met(document):
    by = _near(document, 0.0001)
    only = show(document, [0, 2], visible=False)
    assert snap_move(only, [1], by, reach=0.002).by == tuple(by)
    assert snap_move(document, [0, 1, 2], by, reach=0.002).by == tuple(by)
    assert snap_move(document, [], by, reach=0.002).by == tuple(by)


@pytest.mark.parametrize(
    ("turned", "angle", "degrees"), [(0.0, 0.3, 15), (0.1, 0.3, 30), (0.2, -0.1, 0), (3.0, 0.2, 180)]
)
def test_a_turn_ends_at_a_multiple_of_15_degrees(document, turned, angle, degrees):
    start = rotate(document, [1], turned)
    by = snap_angle(start, 1, angle)
    assert abs(by - angle) <= np.radians(7.5) + 1e-12
    after = rotate(start, [1], by).layout.placements[1].angle
    assert np.cos(after - np.radians(degrees)) == pytest.approx(1)
