"""A path while it is drawn: clicks, strokes, closing, what the pointer adds, and what is taken back."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.control_tools.path_sketch import PathSketch
from widgets.simplify import simplified

FAR, FINE, REACH = 0.004, 0.001, 0.008
CORNERS = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.06]])


def click(sketch, point):
    sketch.press(np.array(point), REACH)
    return sketch.release(FINE, REACH)


def begun(kind="polyline", start=CORNERS[0]):
    sketch = PathSketch(kind, np.array(start))
    assert not sketch.release(FINE, REACH)
    return sketch


def stroke(sketch, points):
    for point in points:
        sketch.move(np.array(point), FAR)
    return sketch.release(FINE, REACH)


def clicked():
    sketch = begun()
    for corner in CORNERS[1:]:
        assert not click(sketch, corner)
    return sketch


def test_clicks_are_corners():
    sketch = clicked()
    assert sketch.can_end
    np.testing.assert_array_equal(sketch.shape.points, CORNERS)


def test_one_corner_is_no_path_and_neither_are_two_at_one_place():
    sketch = begun()
    assert not sketch.can_end
    assert sketch.preview is None
    click(sketch, CORNERS[0])
    assert not sketch.can_end


def test_the_pointer_would_be_the_next_corner():
    sketch = clicked()
    sketch.move(np.array([0.0, 0.06]), FAR)
    np.testing.assert_allclose(sketch.preview.points, [*CORNERS, (0.0, 0.06)])
    assert len(sketch.shape.points) == 3


def test_the_first_corner_closes():
    sketch = clicked()
    assert click(sketch, CORNERS[0] + [0.005, 0.003])
    assert sketch.shape.closed
    assert sketch.shape.points[-1] == sketch.shape.points[0]


def test_two_corners_close_to_nothing():
    sketch = begun()
    click(sketch, CORNERS[1])
    assert not click(sketch, CORNERS[0])


def test_a_stroke_alone_is_a_path_at_once_with_few_corners():
    sketch = PathSketch("polyline", CORNERS[0])
    line = np.concatenate([np.linspace(CORNERS[0], CORNERS[1], 40)[1:], np.linspace(CORNERS[1], CORNERS[2], 30)[1:]])
    assert stroke(sketch, line)
    np.testing.assert_allclose(sketch.shape.points, CORNERS)


def test_a_stroke_after_clicks_is_a_part_of_the_path():
    sketch = clicked()
    sketch.press(np.array([0.05, 0.06]), REACH)
    assert not stroke(sketch, np.linspace([0.05, 0.06], [0.0, 0.03], 20))
    np.testing.assert_allclose(sketch.shape.points, [*CORNERS, (0.05, 0.06), (0.0, 0.03)])


def test_a_stroke_back_to_its_start_is_closed():
    turn = np.linspace(0, 2 * np.pi, 60)[:, None]
    ring = 0.04 * np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
    sketch = PathSketch("spline", ring[0])
    assert stroke(sketch, ring[1:] + [0.001, 0.0])
    assert sketch.shape.closed
    assert sketch.shape.points[0] == tuple(ring[0])


def test_a_tremor_is_no_stroke():
    sketch = PathSketch("polyline", CORNERS[0])
    sketch.move(CORNERS[0] + [FAR / 2, 0.0], FAR)
    assert not sketch.release(FINE, REACH)
    assert not sketch.can_end


@pytest.mark.parametrize("kind", ["lemniscate", "raster"])
def test_two_points_are_dragged_or_clicked(kind):
    sketch = PathSketch(kind, CORNERS[0])
    assert stroke(sketch, np.linspace(CORNERS[0], CORNERS[2], 9))
    np.testing.assert_allclose(sketch.shape.points, CORNERS[[0, 2]])
    sketch = begun(kind)
    sketch.move(CORNERS[2], FAR)
    np.testing.assert_allclose(sketch.preview.points, CORNERS[[0, 2]])
    assert click(sketch, CORNERS[2])
    np.testing.assert_allclose(sketch.shape.points, CORNERS[[0, 2]])


def test_the_last_corner_is_taken_back_until_none_is_left():
    sketch = clicked()
    assert sketch.take_back()
    np.testing.assert_array_equal(sketch.shape.points, CORNERS[:2])
    assert sketch.take_back()
    assert not sketch.take_back()


def test_a_wild_stroke_has_no_more_corners_than_a_hand_can_hold():
    sketch = PathSketch("polyline", CORNERS[0])
    wild = np.cumsum(np.random.default_rng(0).normal(0, 0.004, (3000, 2)), axis=0)
    assert len(simplified(wild, FINE)) > 1000
    assert stroke(sketch, wild)
    assert 20 < len(sketch.shape.points) <= 201
