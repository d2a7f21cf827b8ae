"""Drawn path: picking and dragging handles of each kind, and a path while it is being drawn."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.maps.paths import draw_path
from tactile_widgets.tools.control.drawn_path import DrawnPath, HandleKind, PathHandle, PathSketch
from tactile_widgets.views.interaction.polyline import simplify_polyline

BENT = ((0.0, 0.0), (0.1, 0.0), (0.1, 0.06))
RING = (*BENT, BENT[0])
REACH = 0.004


def moved(points, number, by):
    changed = np.array(points)
    changed[number] += by
    return changed


@pytest.mark.parametrize("kind", ["polyline", "spline"])
def test_each_corner_of_a_free_path_moves_independently(kind):
    shape = DrawnPath(kind, BENT)
    assert len(shape.handles) == 3
    for number, corner in enumerate(BENT):
        held = shape.held_at(np.array(corner) + [0.003, 0.0], REACH)
        assert held == PathHandle(HandleKind.CORNER, number)
        dragged = shape.dragged(held, np.array([0.01, -0.02]))
        np.testing.assert_allclose(dragged.points, moved(BENT, number, [0.01, -0.02]))
        assert dragged.kind == kind


@pytest.mark.parametrize("kind", ["polyline", "spline"])
def test_dragging_a_middle_on_the_curve_adds_a_corner(kind):
    shape = DrawnPath(kind, (*BENT, (0.02, 0.09)))
    line = draw_path(kind, shape.points).points
    for number, middle in enumerate(shape.middles):
        if kind == "spline":
            assert np.linalg.norm(line - middle, axis=1).min() < 1e-12
        held = shape.held_at(middle, REACH)
        assert held == PathHandle(HandleKind.MIDDLE, number)
        dragged = shape.dragged(held, np.array([0.0, 0.01]))
        np.testing.assert_allclose(dragged.points[number + 1], middle + [0.0, 0.01])
        assert [*dragged.points[: number + 1], *dragged.points[number + 2 :]] == list(shape.points)


def test_dragging_the_line_moves_the_whole_path():
    shape = DrawnPath("polyline", BENT)
    assert shape.held_at(np.array([0.03, 0.003]), REACH) == PathHandle(HandleKind.LINE)
    np.testing.assert_allclose(
        shape.dragged(PathHandle(HandleKind.LINE), np.array([0.01, 0.02])).points, np.array(BENT) + [0.01, 0.02]
    )


def test_no_handle_is_found_off_the_path():
    assert DrawnPath("polyline", BENT).held_at(np.array([0.03, 0.01]), REACH) is None


def test_closed_path_has_its_first_corner_once_and_stays_closed():
    shape = DrawnPath("polyline", RING)
    assert shape.closed
    assert len(shape.handles) == 3
    assert len(shape.middles) == 3
    dragged = shape.dragged(PathHandle(HandleKind.CORNER, 0), np.array([-0.01, 0.0]))
    assert dragged.closed
    np.testing.assert_allclose(dragged.points[0], [-0.01, 0.0])


def test_corner_can_be_removed_while_two_remain():
    shape = DrawnPath("polyline", BENT)
    assert shape.without(1).points == (BENT[0], BENT[2])
    assert shape.without(1).without(0) is None


def test_removing_a_corner_opens_a_triangle_and_keeps_a_larger_path_closed():
    assert DrawnPath("polyline", RING).without(0).points == BENT[1:]
    four = DrawnPath("spline", (*BENT, (0.0, 0.06), BENT[0]))
    left = four.without(0)
    assert left.closed
    assert left.points == (*BENT[1:], (0.0, 0.06), BENT[1])


@pytest.mark.parametrize("number", range(4))
def test_dragging_a_corner_of_a_box_keeps_the_opposite_corner(number):
    shape = DrawnPath("raster", ((0.1, 0.02), (0.0, 0.06)))  # drawn from right to left
    handles = shape.handles
    dragged = shape.dragged(PathHandle(HandleKind.CORNER, number), np.array([0.003, 0.004])).handles
    np.testing.assert_allclose(dragged[number], handles[number] + [0.003, 0.004])
    np.testing.assert_allclose(dragged[(number + 2) % 4], handles[(number + 2) % 4])


@pytest.mark.parametrize("kind", ["raster", "lemniscate"])
def test_path_between_two_points_has_no_corners_to_add_or_remove(kind):
    shape = DrawnPath(kind, BENT)
    assert not shape.closed
    assert len(shape.middles) == 0
    assert shape.without(0) is None
    assert len(shape.handles) == (4 if kind == "raster" else 2)


def test_figure_of_eight_is_dragged_by_its_ends():
    shape = DrawnPath("lemniscate", ((0.0, 0.0), (0.1, 0.0)))
    dragged = shape.dragged(PathHandle(HandleKind.CORNER, 1), np.array([0.0, 0.02]))
    np.testing.assert_allclose(dragged.points, [(0.0, 0.0), (0.1, 0.02)])


FAR = 0.004
FINE = 0.001
CLOSING_DISTANCE = 0.008
CORNERS = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.06]])


def click(sketch, point):
    sketch.press(np.array(point), CLOSING_DISTANCE)
    return sketch.release(FINE, CLOSING_DISTANCE)


def begun(kind="polyline", start=CORNERS[0]):
    sketch = PathSketch(kind, np.array(start))
    assert not sketch.release(FINE, CLOSING_DISTANCE)
    return sketch


def stroke(sketch, points):
    for point in points:
        sketch.move(np.array(point), FAR)
    return sketch.release(FINE, CLOSING_DISTANCE)


def clicked():
    sketch = begun()
    for corner in CORNERS[1:]:
        assert not click(sketch, corner)
    return sketch


def test_clicks_add_corners():
    sketch = clicked()
    assert sketch.can_end
    np.testing.assert_array_equal(sketch.shape.points, CORNERS)


def test_one_corner_or_two_at_one_position_are_not_a_path():
    sketch = begun()
    assert not sketch.can_end
    assert sketch.preview is None
    click(sketch, CORNERS[0])
    assert not sketch.can_end


def test_preview_ends_at_the_pointer():
    sketch = clicked()
    sketch.move(np.array([0.0, 0.06]), FAR)
    np.testing.assert_allclose(sketch.preview.points, [*CORNERS, (0.0, 0.06)])
    assert len(sketch.shape.points) == 3


def test_click_on_the_first_corner_closes_the_path():
    sketch = clicked()
    assert click(sketch, CORNERS[0] + [0.005, 0.003])
    assert sketch.shape.closed
    assert sketch.shape.points[-1] == sketch.shape.points[0]


def test_two_corners_cannot_be_closed():
    sketch = begun()
    click(sketch, CORNERS[1])
    assert not click(sketch, CORNERS[0])


def test_single_stroke_completes_a_path_with_few_corners():
    sketch = PathSketch("polyline", CORNERS[0])
    line = np.concatenate([np.linspace(CORNERS[0], CORNERS[1], 40)[1:], np.linspace(CORNERS[1], CORNERS[2], 30)[1:]])
    assert stroke(sketch, line)
    np.testing.assert_allclose(sketch.shape.points, CORNERS)


def test_stroke_after_clicks_extends_the_path():
    sketch = clicked()
    sketch.press(np.array([0.05, 0.06]), CLOSING_DISTANCE)
    assert not stroke(sketch, np.linspace([0.05, 0.06], [0.0, 0.03], 20))
    np.testing.assert_allclose(sketch.shape.points, [*CORNERS, (0.05, 0.06), (0.0, 0.03)])


def test_stroke_back_to_its_start_is_closed():
    turn = np.linspace(0, 2 * np.pi, 60)[:, None]
    ring = 0.04 * np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
    sketch = PathSketch("spline", ring[0])
    assert stroke(sketch, ring[1:] + [0.001, 0.0])
    assert sketch.shape.closed
    assert sketch.shape.points[0] == tuple(ring[0])


def test_small_tremor_does_not_count_as_a_stroke():
    sketch = PathSketch("polyline", CORNERS[0])
    sketch.move(CORNERS[0] + [FAR / 2, 0.0], FAR)
    assert not sketch.release(FINE, CLOSING_DISTANCE)
    assert not sketch.can_end


@pytest.mark.parametrize("kind", ["lemniscate", "raster"])
def test_two_points_are_set_by_a_drag_or_by_clicks(kind):
    sketch = PathSketch(kind, CORNERS[0])
    assert stroke(sketch, np.linspace(CORNERS[0], CORNERS[2], 9))
    np.testing.assert_allclose(sketch.shape.points, CORNERS[[0, 2]])
    dragged = PathSketch(kind, CORNERS[0])
    dragged.move(CORNERS[2], FAR)
    assert dragged.preview == sketch.shape, "the shape is shown while it is dragged"
    sketch = begun(kind)
    sketch.move(CORNERS[2], FAR)
    np.testing.assert_allclose(sketch.preview.points, CORNERS[[0, 2]])
    assert click(sketch, CORNERS[2])
    np.testing.assert_allclose(sketch.shape.points, CORNERS[[0, 2]])


def test_corners_are_removed_one_by_one_until_the_path_is_empty():
    sketch = clicked()
    assert sketch.remove_last()
    np.testing.assert_array_equal(sketch.shape.points, CORNERS[:2])
    assert sketch.remove_last()
    assert not sketch.remove_last()


@pytest.mark.long
def test_long_stroke_has_a_bounded_number_of_corners():
    sketch = PathSketch("polyline", CORNERS[0])
    wild = np.cumsum(np.random.default_rng(0).normal(0, 0.004, (3000, 2)), axis=0)
    assert len(simplify_polyline(wild, FINE)) > 1000
    assert stroke(sketch, wild)
    assert 20 < len(sketch.shape.points) <= 201
