"""The camera's arithmetic: rays and pixels are inverse, moves keep what they promise, the first side shows enough."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import load_scene
from tactile_widgets.views.robot.actors.camera import Viewpoint, framing, orbit, pan, zoom
from tactile_widgets.views.robot.actors.opening_view import DEFAULT_DIRECTION, initial_direction, places_of_interest
from tests.support.touch import arm

pytestmark = pytest.mark.usefixtures("scene_cache")
SIZE = (900, 700)


@pytest.fixture(params=range(6))
def view(request):
    rng = np.random.default_rng(request.param)
    return Viewpoint(rng.normal(size=3), rng.normal(size=3), rng.normal(size=3), rng.uniform(10, 90))


def test_point_on_a_ray_has_its_pixel(view):
    rng = np.random.default_rng(1)
    for pixel in rng.uniform((0, 0), SIZE, size=(20, 2)):
        ray = view.ray(tuple(pixel), SIZE)
        assert np.linalg.norm(ray.direction) == pytest.approx(1.0)
        met = ray.origin + rng.uniform(0.1, 5.0) * ray.direction
        np.testing.assert_allclose(view.pixels(met, SIZE)[0], pixel, atol=1e-6)


def test_point_behind_the_eye_has_no_pixel(view):
    points = np.stack([view.focus, 2 * view.eye - view.focus, view.eye])
    assert view.in_front(points).tolist() == [True, False, False]
    assert np.isnan(view.pixels(points, SIZE)).all(axis=1).tolist() == [False, True, True]


@pytest.mark.parametrize("aspect", [0.3, 1.0, 3.0])
@pytest.mark.parametrize("seed", range(4))
def test_framing_shows_all_points_and_touches_the_border(aspect, seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3)) * rng.uniform(0.05, 2.0, size=3) + 10 * rng.normal(size=3)
    size = (round(1000 * aspect), 1000)
    view = framing(points, rng.normal(size=3), aspect, view_angle=30.0, fill=0.8)
    offset = np.abs(view.pixels(points, size) / size - 0.5).max(axis=0)
    assert (offset <= 0.4 + 1e-9).all()
    assert offset.max() == pytest.approx(0.4)


UP = np.array([0.0, 0.0, 1.0])
VIEW = Viewpoint(np.array([1.0, -2.0, 0.8]), np.array([0.1, 0.2, 0.3]), UP, 30.0)


@pytest.mark.parametrize(("dx", "dy"), [(30, 0), (0, 40), (-25, -60), (700, 5000), (3, -5000)])
def test_orbit_keeps_focus_distance_and_upright_view(dx, dy):
    turned = orbit(VIEW, dx, dy, 700)
    assert turned.distance == pytest.approx(VIEW.distance)
    np.testing.assert_array_equal(turned.focus, VIEW.focus)
    assert np.linalg.norm(turned.eye - VIEW.eye) > 1e-3
    assert turned.axes[1] @ UP > 0.0


def test_drag_to_the_right_turns_the_front_to_the_right():
    front = VIEW.focus + 0.1 * (VIEW.eye - VIEW.focus) / VIEW.distance
    before, after = (view.pixels(front, SIZE)[0] for view in (VIEW, orbit(VIEW, 20, 20, 700)))
    assert (after > before).all()


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
def test_zoom_is_limited(factor, distance):
    assert zoom(VIEW, factor).distance == pytest.approx(distance)


def side_with(*things: ObjectSpec) -> np.ndarray:
    prepared = arm()
    scene = replace(prepared.scene, objects=things, task="slide", outputs=("force",))
    made = replace(prepared, scene=scene, objects=make_objects(scene))
    poses = Configuration(prepared.robot).poses()
    return initial_direction(made, poses, places_of_interest(made, poses))


def ball(name: str, *at: float) -> ObjectSpec:
    return ObjectSpec(name, "sphere", (0.03,), at=at)


def test_scene_without_objects_has_the_default_direction():
    assert side_with() == pytest.approx(DEFAULT_DIRECTION)


def test_visible_object_keeps_the_default_direction():
    assert side_with(ball("free", 0.5, 0.4, 0.4)) == pytest.approx(DEFAULT_DIRECTION)


def test_hidden_object_changes_the_direction():
    """A ball behind the forearm is hidden from the default viewpoint by the arm at home."""
    hidden = ball("hidden", 0.2142, -0.0008, 0.5822)
    side = side_with(hidden)
    assert side != pytest.approx(DEFAULT_DIRECTION)
    assert np.abs(side) == pytest.approx(np.abs(DEFAULT_DIRECTION)), "one of the four quarters"


def test_direction_shows_most_objects():
    hidden = ball("hidden", 0.2142, -0.0008, 0.5822)
    free = [ball(f"free {k}", 0.5, 0.3 + 0.1 * k, 0.4) for k in range(9)]
    assert side_with(hidden, *free) == pytest.approx(DEFAULT_DIRECTION)


@pytest.mark.parametrize("name", ["arm", "follow_path", "poke"])
def test_scene_opens_with_its_first_contact_in_the_centre(name):
    """Wherever on the robot that is; and all of the robot is in the picture."""
    prepared = arm()
    scene = load_scene(name)
    made = replace(prepared, scene=scene, objects=make_objects(scene))
    poses = Configuration(prepared.robot).poses()
    places = places_of_interest(made, poses)
    assert len(places)
    robot = np.concatenate(
        [
            link.mesh.vertices[::50] @ poses[k][:3, :3].T + poses[k][:3, 3]
            for k, link in enumerate(prepared.robot.links)
            if link.mesh is not None
        ]
    )
    away = initial_direction(made, poses, places)
    size = (536, 600)
    view = framing(robot, away, size[0] / size[1], view_angle=30.0, fill=0.92, central=places.points)
    middle = view.pixels(0.5 * (places.points.min(axis=0) + places.points.max(axis=0)), size)[0] / size
    assert (np.abs(middle - 0.5) < 1 / 6).all()
    assert ((view.pixels(robot, size) > 0) & (view.pixels(robot, size) < size)).all()
