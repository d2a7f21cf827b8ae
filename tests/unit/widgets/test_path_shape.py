"""A drawn path under the hand: which handle a place means, and what dragging it does, for each kind of path."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.map_path import draw_path
from widgets.control_tools.path_shape import Grip, Held, PathShape

BENT = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.06))
RING = (*BENT, BENT[0])
REACH = 0.004


def moved(points, number, by):
    changed = np.array(points)
    changed[number] += by
    return changed


@pytest.mark.parametrize("kind", ["polyline", "spline"])
def test_each_corner_of_a_free_path_is_a_handle_and_moves_alone(kind):
    shape = PathShape(kind, BENT)
    assert len(shape.handles) == 3
    for number, corner in enumerate(BENT):
        held = shape.held_at(np.array(corner) + [0.003, 0.0], REACH)
        assert held == Held(Grip.CORNER, number)
        dragged = shape.dragged(held, np.array([0.01, -0.02]))
        np.testing.assert_allclose(dragged.points, moved(BENT, number, [0.01, -0.02]))
        assert dragged.kind == kind


@pytest.mark.parametrize("kind", ["polyline", "spline"])
def test_a_corner_is_pulled_from_the_middle_of_a_side_which_lies_on_the_curve(kind):
    shape = PathShape(kind, (*BENT, (0.02, 0.09)))
    line = draw_path(kind, shape.points).points
    for number, middle in enumerate(shape.middles):
        if kind == "spline":
            assert np.linalg.norm(line - middle, axis=1).min() < 1e-12
        held = shape.held_at(middle, REACH)
        assert held == Held(Grip.MIDDLE, number)
        dragged = shape.dragged(held, np.array([0.0, 0.01]))
        np.testing.assert_allclose(dragged.points[number + 1], middle + [0.0, 0.01])
        assert [*dragged.points[: number + 1], *dragged.points[number + 2 :]] == list(shape.points)


def test_the_line_moves_all_of_it():
    shape = PathShape("polyline", BENT)
    assert shape.held_at(np.array([0.03, 0.003]), REACH) == Held(Grip.LINE)
    np.testing.assert_allclose(
        shape.dragged(Held(Grip.LINE), np.array([0.01, 0.02])).points, np.array(BENT) + [0.01, 0.02]
    )


def test_beside_the_path_nothing_is_meant():
    assert PathShape("polyline", BENT).held_at(np.array([0.03, 0.01]), REACH) is None


def test_a_ring_has_its_first_corner_once_and_stays_closed():
    shape = PathShape("polyline", RING)
    assert shape.closed
    assert len(shape.handles) == 3
    assert len(shape.middles) == 3
    dragged = shape.dragged(Held(Grip.CORNER, 0), np.array([-0.01, 0.0]))
    assert dragged.closed
    np.testing.assert_allclose(dragged.points[0], [-0.01, 0.0])


def test_a_corner_is_taken_out_as_long_as_two_are_left():
    shape = PathShape("polyline", BENT)
    assert shape.without(1).points == (BENT[0], BENT[2])
    assert shape.without(1).without(0) is None


def test_a_ring_of_three_without_one_is_a_line_there_and_a_larger_one_stays_closed():
    assert PathShape("polyline", RING).without(0).points == BENT[1:]
    four = PathShape("spline", (*BENT, (0.0, 0.06), BENT[0]))
    left = four.without(0)
    assert left.closed
    assert left.points == (*BENT[1:], (0.0, 0.06), BENT[1])


@pytest.mark.parametrize("number", range(4))
def test_a_box_is_dragged_by_any_of_its_corners_and_the_opposite_one_stays(number):
    shape = PathShape("raster", ((0.1, 0.02), (0.0, 0.06)))  # drawn from right to left
    handles = shape.handles
    dragged = shape.dragged(Held(Grip.CORNER, number), np.array([0.003, 0.004])).handles
    np.testing.assert_allclose(dragged[number], handles[number] + [0.003, 0.004])
    np.testing.assert_allclose(dragged[(number + 2) % 4], handles[(number + 2) % 4])


@pytest.mark.parametrize("kind", ["raster", "lemniscate"])
def test_what_lies_between_two_points_has_nothing_to_add_or_remove(kind):
    shape = PathShape(kind, BENT)
    assert not shape.closed
    assert len(shape.middles) == 0
    assert shape.without(0) is None
    assert len(shape.handles) == (4 if kind == "raster" else 2)


def test_a_figure_of_eight_is_dragged_by_its_ends():
    shape = PathShape("lemniscate", ((0.0, 0.0), (0.1, 0.0)))
    dragged = shape.dragged(Held(Grip.CORNER, 1), np.array([0.0, 0.02]))
    np.testing.assert_allclose(dragged.points, [(0.0, 0.0), (0.1, 0.02)])
