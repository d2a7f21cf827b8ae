"""The eye's arithmetic: rays and pixels undo each other, and framing is as near as it can be."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.robot_view.viewpoint import Viewpoint, framing

SIZE = (900, 700)


@pytest.fixture(params=range(6))
def view(request):
    rng = np.random.default_rng(request.param)
    return Viewpoint(rng.normal(size=3), rng.normal(size=3), rng.normal(size=3), rng.uniform(10, 90))


def test_axes_are_a_right_handed_frame_of_the_picture(view):
    right, up, forward = view.axes
    np.testing.assert_allclose(view.axes @ view.axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(right, up), -forward, atol=1e-12)
    assert up @ view.up > 0


def test_what_a_ray_meets_appears_at_its_pixel(view):
    rng = np.random.default_rng(1)
    for pixel in rng.uniform((0, 0), SIZE, size=(20, 2)):
        ray = view.ray(tuple(pixel), SIZE)
        assert np.linalg.norm(ray.direction) == pytest.approx(1.0)
        met = ray.origin + rng.uniform(0.1, 5.0) * ray.direction
        np.testing.assert_allclose(view.pixels(met, SIZE)[0], pixel, atol=1e-6)


def test_the_focus_is_in_the_middle_and_up_is_up(view):
    np.testing.assert_allclose(view.pixels(view.focus, SIZE)[0], (450, 350), atol=1e-9)
    above = view.focus + 0.01 * view.axes[1]
    right = view.focus + 0.01 * view.axes[0]
    assert view.pixels(above, SIZE)[0, 1] < 350
    assert view.pixels(right, SIZE)[0, 0] > 450


def test_what_is_behind_the_eye_has_no_pixel(view):
    assert np.isnan(view.pixels(2 * view.eye - view.focus, SIZE)).all()


@pytest.mark.parametrize("aspect", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_framing_takes_all_points_and_touches_the_border(aspect, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * rng.uniform(0.05, 2.0, size=3) + 10 * rng.normal(size=3)
    size = (round(1000 * aspect), 1000)
    view = framing(points, rng.normal(size=3), aspect, view_angle=30.0, fill=0.8)
    offset = np.abs(view.pixels(points, size) / size - 0.5).max(axis=0)
    assert (offset <= 0.4 + 1e-9).all()
    assert offset.max() == pytest.approx(0.4)


def test_one_point_can_be_framed():
    view = framing(np.ones((1, 3)), np.array([1.0, 0.0, 0.2]), 1.5, view_angle=30.0, fill=0.8)
    np.testing.assert_allclose(view.pixels(np.ones(3), SIZE)[0], (450, 350), atol=1e-6)
