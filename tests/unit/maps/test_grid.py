"""Coarse search finds every box that an exact one would."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.grid import BoxGrid, ranges


@pytest.fixture
def boxes():
    rng = np.random.default_rng(0)
    low = rng.uniform(-1, 1, (80, 2))
    return low, low + rng.uniform(0, 0.3, (80, 2))


def test_every_box_that_holds_a_point_is_a_candidate(boxes):
    low, high = boxes
    points = np.concatenate([np.random.default_rng(1).uniform(-1.5, 1.5, (500, 2)), low, high])
    row, box = BoxGrid(low, high, 0.1).candidates(points)
    found = set(zip(row.tolist(), box.tolist(), strict=True))
    holds = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
    assert holds.sum() > 300
    assert set(zip(*(part.tolist() for part in np.nonzero(holds)), strict=True)) <= found
    assert len(found) == len(row), "no pair twice"


def test_points_outside_or_not_finite_have_no_candidates(boxes):
    row, _ = BoxGrid(*boxes, 0.1).candidates(np.array([[9, 0], [-9, 0], [0, 1e300], [np.nan, 0], [0, np.inf]]))
    assert len(row) == 0


def test_pairs_hold_every_overlap_once(boxes):
    low, high = boxes
    i, j = BoxGrid(low, high, 0.1).pairs()
    found = set(zip(i.tolist(), j.tolist(), strict=True))
    meets = ((low[:, None] <= high) & (high[:, None] >= low)).all(axis=2)
    assert {(a, b) for a, b in zip(*np.nonzero(meets), strict=True) if a < b} <= found
    assert len(found) == len(i)
    assert (i < j).all()


def test_a_tiny_cell_does_not_take_all_memory():
    low = np.array([[0.0, 0.0], [1e6, 1e6], [0, 1e6]])
    row, box = BoxGrid(low, low + 1e-9, 1e-9).candidates(low)
    assert (row == box).sum() == 3


def test_boxes_without_extent_are_held():
    low = np.zeros((3, 2))
    assert len(BoxGrid(low, low, 0.0).pairs()[0]) == 3


def test_ranges_count_up_within_each_owner():
    owner, step = ranges(np.array([2, 0, 3]))
    assert owner.tolist() == [0, 0, 2, 2, 2]
    assert step.tolist() == [0, 1, 0, 1, 2]
