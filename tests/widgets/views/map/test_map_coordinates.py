"""Coordinates of the map view: scene points and map points, numbers as text, and the bounds of the camera."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.map.items.map_coordinates import (
    HIGHEST_ZOOM,
    LOWEST_ZOOM,
    SCENE_SIZE,
    MapCamera,
    SceneTransform,
    format_three_digits,
)


@pytest.mark.parametrize("bounds", [[[0, 0], [0.5, 0.2]], [[-3, 1], [-2.9, 4]], [[0, 0], [1e-3, 1e-3]]])
def test_scene_and_map_points_convert_back(bounds):
    frame = SceneTransform.around(np.array(bounds, dtype=float))
    assert max(frame.size) == pytest.approx(SCENE_SIZE)
    points = np.random.default_rng(0).uniform(bounds[0], bounds[1], (50, 2))
    assert np.abs(frame.to_map(frame.to_scene(points)) - points).max() < 1e-12


def test_upper_left_corner_of_the_map_is_the_origin():
    frame = SceneTransform.around(np.array([[1.0, 2.0], [1.5, 2.2]]))
    assert frame.to_scene(np.array([1.0, 2.2])) == pytest.approx([0, 0])
    assert frame.to_scene(np.array([1.5, 2.0])) == pytest.approx([1000, 400])


def test_map_without_size_has_a_scale():
    assert SceneTransform.around(np.zeros((2, 2))).scale > 0


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0.00"), (0.123, "0.12"), (7.4, "7.40"), (12.34, "12.3"), (99.96, "100"), (431.4, "431")]
)
def test_lengths_are_formatted_with_three_digits(value, text):
    assert format_three_digits(value) == text


VIEW = (700.0, 500.0)


def test_zoom_is_limited():
    camera = MapCamera.framing((1000.0, 700.0))
    assert camera.zoomed(1e9, (350.0, 250.0), VIEW).zoom == HIGHEST_ZOOM
    assert camera.zoomed(1e-9, (350.0, 250.0), VIEW).zoom == LOWEST_ZOOM


def test_centre_stays_on_the_map():
    camera = MapCamera.framing((1000.0, 700.0)).panned(1e6, -1e6, VIEW)
    assert camera.centre == (0.0, 700.0)


def test_empty_viewport_has_a_scale():
    assert MapCamera.framing((1000.0, 700.0)).scale((0.0, 0.0)) > 0


def test_camera_shows_the_same_part_of_changed_content():
    camera = MapCamera((100.0, 50.0), (20.0, 30.0), 2.0)
    room = (640.0, 480.0)
    other = camera.over((400.0, 700.0), (-80.0, 5.0), room)
    assert other.to_scene((17.0, 400.0), room) == pytest.approx(camera.to_scene((17.0, 400.0), room))
    framed = MapCamera.framing(other.content, other.origin)
    assert framed.to_scene((320.0, 240.0), room) == pytest.approx((120.0, 355.0))
    far = other.over((10.0, 10.0), (900.0, 900.0), room)
    assert far.panned(1.0, 1.0, room).centre == pytest.approx(far.centre, abs=1.0)
