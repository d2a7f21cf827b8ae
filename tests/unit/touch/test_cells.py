"""Boxes of points: none is lost, and none is closer than its box says."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.pose import Pose
from app.touch.cells import Cells
from app.touch.load import Load
from app.touch.shapes import Box

POSITIONS = np.random.default_rng(0).uniform(-0.1, 0.1, size=(700, 3)) * [1, 1, 0.2]


@pytest.mark.parametrize("size", [1e-4, 0.01, 0.05, 10.0])
def test_every_point_is_in_one_cell_and_no_closer_to_a_body_than_its_cell(size):
    cells = Cells(POSITIONS, size)
    turned = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])
    load = Load("link", np.zeros(3), np.array([0.0, 0, 1]), 1.0, Box((0.02, 0.01, 0.03)), Pose(turned, [0.05, 0, 0.01]))
    lowest = cells.lowest(load)
    members = [cells.order[cells.members(np.array([cell]))] for cell in range(len(lowest))]
    np.testing.assert_array_equal(np.sort(np.concatenate(members)), np.arange(len(POSITIONS)))
    distances = load.distances(POSITIONS)
    assert all(distances[points].min() >= low - 1e-12 for points, low in zip(members, lowest, strict=True))
    np.testing.assert_array_equal(cells.members(np.arange(len(lowest))), np.arange(len(POSITIONS)))


def test_no_cells_have_no_members():
    assert Cells(POSITIONS[:1], 0.01).members(np.zeros(0, dtype=int)).size == 0
