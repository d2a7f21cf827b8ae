"""The robot's actors on a plain plotter: in place from frame to frame, replaced whole from robot to robot."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.robot.actors.robot_actors import RobotActors
from tests.widgets.support.robot_view_driver import PICTURE


@pytest.fixture(scope="module")
def pressed(prepared):
    """A session in which a finger has pressed for half a second, and the arm has yielded."""
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(0, prepared.skin.taxel_point(70)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session.frame


def skin_actors(plotter):
    """Actors of the skin and the data of their vertices."""
    shown = [(actor, actor.mapper.GetInput().point_data) for actor in plotter.actors.values()]
    return [(actor, data) for actor, data in shown if "touch" in data]


def skin_colours(plotter):
    """Colours of all skin vertices, as drawn."""
    return np.concatenate([np.array(data["touch"]) for _, data in skin_actors(plotter)])


@pytest.mark.long
def test_touch_colours_only_the_skin_around_it(plotter, scene, prepared, pressed):
    scene.show_frame(pressed)
    colours = skin_colours(plotter).astype(int)
    touched = np.abs(colours - PressureScale().table[0]).max(axis=1) > 2
    vertices = np.concatenate([patch.surface.vertices for patch in prepared.skin.patches])
    patch = np.repeat(np.arange(len(prepared.skin.patches)), [len(p.surface.vertices) for p in prepared.skin.patches])
    region = pressed.regions[0]
    assert touched.any()
    assert (patch[touched] == region.at.patch).all()
    assert np.linalg.norm(vertices[touched] - region.link_position, axis=1).max() < 0.1


def test_hidden_link_has_no_actors_and_can_be_shown_again(plotter, scene, prepared, pressed):
    scene.show_frame(pressed)
    link = prepared.robot.link_index[pressed.regions[0].link]
    renderer = plotter.renderer
    whole = len(scene._corners())
    before = renderer.GetViewProps().GetNumberOfItems()
    scene.hide(frozenset({link}))
    gone = [actor for number, actor in [*scene.links.placed, *scene.skin.link_actors] if number == link]
    assert gone
    assert not any(renderer.HasViewProp(actor) for actor in gone)
    assert len(scene._corners()) < whole, "what is framed"
    assert not scene.forces, "an arrow would float in the air"
    scene.show_frame(pressed)
    assert not any(renderer.HasViewProp(actor) for actor in gone)
    scene.show_prepared(prepared)
    assert scene.hidden == {link}, "another start of the same scene"
    scene.hide(frozenset())
    assert renderer.GetViewProps().GetNumberOfItems() == before
    scene.hide(frozenset(range(len(prepared.robot.links))))
    assert len(scene._corners()) == whole, "of nothing no view can be framed"


def test_links_have_the_poses_of_the_posture(plotter, scene, prepared, pressed):
    scene.show_frame(pressed)
    configuration = Configuration(prepared.robot)
    assert np.abs(pressed.posture - prepared.robot.home).max() > 1e-4
    configuration.update(pressed.posture)
    np.testing.assert_allclose(scene.poses, configuration.poses())
    drawn = [actor.user_matrix for actor, _ in skin_actors(plotter)]
    expected = [configuration.pose(patch.link).matrix for patch in prepared.skin.patches]
    np.testing.assert_allclose(drawn, expected)


def test_arrow_length_shows_the_force(scene, pressed):
    scene.show_frame(pressed)
    ((arrow, region),) = scene.forces
    assert region is pressed.regions[0]
    assert np.linalg.norm(arrow[0] - arrow[1]) == pytest.approx(0.012 * region.force)


def test_finger_is_a_ball_on_the_skin(scene, pressed):
    scene.show_frame(pressed)
    (poke,) = pressed.pokes
    (ball,) = (actor for actor in scene._marks._balls if actor.visibility)
    middle = np.mean(np.reshape(ball.bounds, (3, 2)), axis=1)
    assert middle == pytest.approx(poke.world_position + poke.radius * poke.world_normal, abs=1e-6)


def test_showing_frames_creates_no_actors(plotter, scene, pressed, prepared):
    names = list(plotter.actors)
    for _ in range(3):
        scene.show_frame(pressed)
        scene.set_hover(prepared.skin.taxel_point(0))
        scene.set_hover(None)
    assert list(plotter.actors) == names


def test_shows_is_true_only_for_the_frame_drawn_last(scene, prepared, pressed):
    assert not scene.shows(pressed)
    scene.show_frame(pressed)
    assert scene.shows(pressed)
    rest = Session(prepared, scripted=False).frame
    assert not scene.shows(rest)


def test_theme_changes_background_and_keeps_skin_colours(plotter, scene):
    colours = skin_colours(plotter)
    count = len(plotter.actors)
    scene.set_theme(LIGHT)
    assert plotter.background_color.hex_rgb == LIGHT.window
    np.testing.assert_array_equal(skin_colours(plotter), colours)
    assert len(plotter.actors) == count


def test_frame_all_shows_the_whole_robot(plotter, scene, prepared):
    poses = dict(zip(prepared.robot.link_index, scene.poses, strict=True))
    points = [
        link.mesh.vertices @ poses[link.name][:3, :3].T + poses[link.name][:3, 3]
        for link in prepared.robot.links
        if link.mesh is not None
    ]
    pixels = scene.viewpoint.pixels(np.concatenate(points), PICTURE)
    assert (pixels > 0).all()
    assert (pixels < PICTURE).all()
    assert (np.ptp(pixels, axis=0) / PICTURE).max() > 0.6


@pytest.mark.long
def test_viewpoint_agrees_with_vtk(plotter, scene, prepared):
    """VTK projects a point where ``Viewpoint`` does."""
    scene.fit_depth()
    plotter.render_window.Render()
    point = prepared.skin.patches[0].surface.vertices[0]
    plotter.renderer.SetWorldPoint(*point, 1.0)
    plotter.renderer.WorldToDisplay()
    x, y, _ = plotter.renderer.GetDisplayPoint()
    np.testing.assert_allclose(scene.viewpoint.pixels(point, PICTURE)[0], (x, PICTURE[1] - y), atol=0.6)


def test_scene_without_a_robot_draws_nothing(plotter):
    scene = RobotActors(plotter, DARK, PressureScale())
    scene.set_hover(None)
    scene.set_theme(LIGHT)
    scene.set_scale(PressureScale(5.0))
    scene.frame_all()
    assert scene.forces == []
    assert len(plotter.actors) == 0


@pytest.mark.long
@pytest.mark.parametrize("direction", [(1, 1, 0.5), (-1, 0.3, 0.2), (0.1, -1, -0.4), (0, 0.1, 1)])
def test_culled_back_faces_are_never_visible(plotter, scene, prepared, direction):
    drawn = [actor for actor in plotter.actors.values() if actor.visibility and actor.prop.opacity == 1.0]
    culled = [actor for actor in drawn if actor.prop.culling == "back"]
    assert len(culled) >= len(prepared.robot.links) + len(prepared.skin.patches) - 1
    plotter.view_vector(direction)
    without = plotter.screenshot(return_img=True)
    for actor in culled:
        actor.prop.culling = "none"
    everything = plotter.screenshot(return_img=True)
    assert np.ptp(everything) > 50
    # A pixel on the rim may be the back's or the front's.
    assert (np.abs(everything.astype(int) - without).max(axis=2) > 8).mean() < 1e-3
