"""The eye moved by hand: each move keeps what it promises to keep."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.robot_view.orbit import orbit, pan, zoom
from widgets.robot_view.viewpoint import Viewpoint

UP = np.array([0.0, 0.0, 1.0])
VIEW = Viewpoint(np.array([1.0, -2.0, 0.8]), np.array([0.1, 0.2, 0.3]), UP, 30.0)
SIZE = (900, 700)


@pytest.mark.parametrize(("dx", "dy"), [(30, 0), (0, 40), (-25, -60), (700, 5000), (3, -5000)])
def test_an_orbit_keeps_focus_and_distance_and_never_tips_over(dx, dy):
    turned = orbit(VIEW, dx, dy, 700)
    assert turned.distance == pytest.approx(VIEW.distance)
    np.testing.assert_array_equal(turned.focus, VIEW.focus)
    assert np.linalg.norm(turned.eye - VIEW.eye) > 1e-3
    assert turned.axes[1] @ UP > 0.0


def test_a_drag_to_the_right_turns_the_front_to_the_right():
    front = VIEW.focus + 0.1 * (VIEW.eye - VIEW.focus) / VIEW.distance
    before, after = (view.pixels(front, SIZE)[0] for view in (VIEW, orbit(VIEW, 20, 20, 700)))
    assert (after > before).all()


def test_an_orbit_and_back_is_where_it_was():
    there = orbit(orbit(VIEW, 35, -20, 700), -35, 20, 700)
    np.testing.assert_allclose(there.eye, VIEW.eye, atol=1e-12)


def test_panning_moves_the_focus_with_the_pointer():
    moved = pan(VIEW, 40, -25, 700)
    np.testing.assert_allclose(moved.pixels(VIEW.focus, SIZE)[0], (490, 325), atol=1e-9)
    np.testing.assert_allclose(moved.axes, VIEW.axes, atol=1e-12)


def test_zooming_keeps_the_line_of_sight():
    near = zoom(VIEW, 2.0)
    assert near.distance == pytest.approx(VIEW.distance / 2)
    np.testing.assert_allclose(near.axes, VIEW.axes, atol=1e-12)
    np.testing.assert_allclose(zoom(near, 0.5).eye, VIEW.eye, atol=1e-12)


@pytest.mark.parametrize(("factor", "distance"), [(1e9, 0.02), (1e-9, 100.0)])
def test_zooming_has_ends(factor, distance):
    assert zoom(VIEW, factor).distance == pytest.approx(distance)
