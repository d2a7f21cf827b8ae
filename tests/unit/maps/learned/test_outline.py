"""One simple border around points."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.geometry.topology import boundary_loops, bow_tie_vertices, euler_characteristic
from app.maps.bijective import crossings, flipped
from app.maps.interpolation.triangles import LONGEST_SIDE
from app.maps.learned.outline import longest_side, outlined


def _lattice(keep):
    i, j = np.meshgrid(np.arange(16), np.arange(12), indexing="ij")
    points = np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=-1).reshape(-1, 2)
    points += 0.02 * np.random.default_rng(11).normal(size=points.shape)
    return points[keep(*points.T)]


SHAPES = {
    "whole": lambda x, y: x > -9,
    "an L": lambda x, y: (x < 5) | (y < 4),
    "a U": lambda x, y: (x < 4) | (x > 11) | (y < 3),
    "with a hole": lambda x, y: (x - 8) ** 2 + (y - 5) ** 2 > 9,
    "two pieces": lambda x, y: (x < 5) | (x > 11),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_it_is_one_disk_through_every_point(shape):
    points = _lattice(SHAPES[shape])
    faces = outlined(points).faces
    assert np.array_equal(np.unique(faces), np.arange(len(points)))
    assert euler_characteristic(faces) == 1
    assert not len(bow_tie_vertices(faces))
    (loop,) = boundary_loops(faces)
    assert not crossings(points[loop])
    assert not flipped(points, faces).any()


@pytest.mark.parametrize(
    ("shape", "bridged"), [("whole", 0), ("an L", 0), ("a U", 0), ("with a hole", 1), ("two pieces", 1)]
)
def test_gaps_open_to_the_outside_are_not_bridged(shape, bridged):
    points = _lattice(SHAPES[shape])
    shape = outlined(points)
    assert (shape.bridging > 0) == bridged
    sides = np.linalg.norm(points[shape.faces] - np.roll(points[shape.faces], 1, axis=1), axis=2)
    assert (sides.max(axis=1) > longest_side(points)).sum() == shape.bridging


def test_the_limit_is_in_spacings():
    assert longest_side(3 * np.stack([np.arange(5.0), np.zeros(5)], axis=1)) == pytest.approx(3 * LONGEST_SIDE)


@pytest.mark.parametrize("points", [np.eye(2), np.stack([np.arange(9.0), 2 * np.arange(9.0)], axis=1)])
def test_a_line_has_no_inside(points):
    with pytest.raises(MapError):
        outlined(points)
