"""The scene's objects in the robot view: where the frame says, in place, in the picture, and nothing without any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtGui import QColor
from scipy import ndimage

from tactile_maps.scene.object_meshes import make_objects
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.session.session import Session
from tactile_widgets.common.colours import DARK, LIGHT

BALL = ObjectSpec("ball", "sphere", size=(0.06,), at=(0.2, 0.5, 0.4), mass=0.2)
CRATE = ObjectSpec("crate", "box", size=(0.2, 0.1, 0.1), at=(0.5, -0.1, 0.05), turn=(0.0, 0.0, 30.0))
PROBE = ObjectSpec("finger", "probe", size=(0.02,), at=(0.4, 0.2, 0.5))
FLOOR = ObjectSpec("floor", "plane")
FAR = ObjectSpec("far", "box", size=(0.2, 0.2, 0.2), at=(9.0, 0.0, 0.1))


def among(prepared, *specs):
    """The small arm among these objects, with weight."""
    scene = replace(prepared.scene, objects=specs, task="push", overrides={"gravity": "on"})
    return replace(prepared, scene=scene, objects=make_objects(scene))


@pytest.mark.long
def test_scene_without_objects_has_no_object_actors(scene, plotter, prepared):
    scene.show_prepared(prepared)
    bare = len(plotter.actors)
    assert scene._objects._solids == []
    scene.show_prepared(among(prepared, BALL))
    assert len(plotter.actors) == bare + 1
    scene.show_prepared(prepared)
    assert len(plotter.actors) == bare


@pytest.mark.long
def test_objects_have_the_poses_of_scene_and_frame(scene, plotter, prepared):
    prepared = among(prepared, BALL, CRATE)
    scene.show_prepared(prepared)
    start = [spec.pose.matrix for spec in (BALL, CRATE)]
    np.testing.assert_allclose([actor.user_matrix for actor in scene._objects._solids], start)
    session = Session(prepared, scripted=False)
    for _ in range(20):
        session.tick()
    assert session.frame.objects[0, 2, 3] < BALL.at[2] - 0.01, "the ball falls"
    names = list(plotter.actors)
    scene.show_frame(session.frame)
    np.testing.assert_allclose([actor.user_matrix for actor in scene._objects._solids], session.frame.objects)
    assert list(plotter.actors) == names, "nothing is created while frames flow"


@pytest.mark.long
def test_moved_object_changes_the_picture(scene, prepared):
    prepared = among(prepared, BALL)
    scene.show_prepared(prepared)
    frame = Session(prepared, scripted=False).frame
    scene.show_frame(frame)
    moved = frame.objects.copy()
    moved[0, 0, 3] += 0.01
    assert scene.shows(replace(frame, tick=1))
    assert not scene.shows(replace(frame, objects=moved))


def corners(body):
    return body.spec.pose.points(body.mesh.vertices)


@pytest.mark.long
def test_view_is_fitted_only_to_near_objects(scene, prepared):
    size = (240, 200)
    bodies = among(prepared, BALL, CRATE).objects
    scene.show_prepared(among(prepared, BALL, CRATE))
    for body in bodies:
        pixels = scene.viewpoint.pixels(corners(body), size)
        assert (pixels > 0).all()
        assert (pixels < size).all()
    scene.show_prepared(prepared)
    alone = scene.viewpoint.eye
    scene.show_prepared(among(prepared, FAR, FLOOR))
    np.testing.assert_allclose(scene.viewpoint.eye, alone)


def test_floor_of_the_scene_replaces_the_floor_grid(scene, plotter, prepared):
    scene.show_prepared(prepared)
    assert "ground" in plotter.actors
    scene.show_prepared(among(prepared, FLOOR))
    assert "ground" not in plotter.actors
    wall = replace(FLOOR, turn=(90.0, 0.0, 0.0), at=(0.0, 1.0, 0.0))
    scene.show_prepared(among(prepared, wall))
    assert "ground" in plotter.actors, "a wall is no floor"


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_lines_of_the_floor_do_not_cross_the_robot(scene, plotter, prepared, theme):
    scene.set_theme(theme)
    scene.show_prepared(prepared)
    scene.show_frame(Session(prepared, scripted=False).frame)
    plotter.window_size = (1100, 1000)

    def picture():
        plotter.render()
        return plotter.screenshot(return_img=True).astype(int)

    with_lines = picture()
    plotter.actors["ground"].SetVisibility(False)
    without = picture()
    background = np.array(QColor(theme.window).getRgb()[:3])
    robot = np.abs(without - background).max(axis=2) > 3
    inner = robot & ndimage.binary_erosion(robot, iterations=2)
    assert inner.sum() > 10_000
    assert (with_lines[~robot] != without[~robot]).any(), "lines are drawn next to the robot"
    assert np.abs(with_lines - without)[inner].max() <= 1


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_objects_differ_from_the_robot_and_a_probe_resembles_a_finger(scene, prepared, theme):
    scene.show_prepared(among(prepared, CRATE, PROBE))
    scene.set_theme(theme)
    crate, probe = scene._objects._solids
    assert probe.prop.color.hex_rgb == theme.text
    assert probe.prop.opacity < 1
    link = scene.links.placed[0][1]
    assert np.abs(np.subtract(crate.prop.color.float_rgb, link.prop.color.float_rgb)).max() > 0.1
    assert crate.prop.specular > 0 == link.prop.specular


def test_objects_fade_while_the_skin_is_flat(scene, prepared):
    scene.show_prepared(among(prepared, CRATE, PROBE, FLOOR))
    before = [actor.prop.opacity for actor in scene._objects._solids]
    scene.morph(1.0)
    assert all(actor.prop.opacity < 0.1 for actor in scene._objects._solids)
    scene.morph(0.0)
    assert [actor.prop.opacity for actor in scene._objects._solids] == before
