"""The controller's task and contact ellipses on the body: locations, motion with the link, and updates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale, rgb
from tactile_widgets.views.layers import LAYERS, body_layers
from tactile_widgets.views.overlays.task_overlay import ContactTrail
from tactile_widgets.views.overlays.task_overlay_builder import TaskOverlayBuilder
from tactile_widgets.views.robot.actors.robot_actors import RobotActors
from tactile_widgets.views.robot.actors.tool_and_task_marks import TaskMarks
from tests.widgets.support.snapshots import shared_share


@pytest.fixture(scope="module")
def led(prepared):
    """Overlay and frame while the arm follows a path around a fingertip."""
    session = Session(prepared, scripted=False)
    settings = ControlSettings(controller="hybrid", task="follow_path", path_speed=0.03)
    builder = TaskOverlayBuilder()
    builder.show_map(prepared.map)
    builder.show_settings(settings)
    session.submit(ControlChanged(settings))
    session.submit(PokePressed(0, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    for _ in range(200):
        builder.show_frame(session.tick())
    assert builder.shown.path
    assert builder.shown.target is not None
    return builder.shown, session.frame


@pytest.fixture
def plotter():
    made = pv.Plotter(off_screen=True, window_size=(320, 260))
    yield made
    made.close()


@pytest.fixture
def marks(plotter, prepared):
    return TaskMarks(plotter, DARK, prepared)


def look(plotter):
    """(h, w, 3) what the plotter draws now."""
    plotter.render()
    return plotter.screenshot(return_img=True).astype(np.int16)


def shown(marks, kind):
    """(k, 3) corners of all that is drawn of a kind, link frames, and the inks (t, 3) of its triangles."""
    flats = [flat for flat in marks._kinds[kind] if flat.actor.visibility]
    if not flats:
        return np.zeros((0, 3)), np.zeros((0, 3))
    return (
        np.concatenate([np.array(flat._mesh.points) for flat in flats]),
        np.concatenate([np.array(flat._mesh.cell_data["ink"]) for flat in flats]),
    )


def way(task, age):
    """A contact's way along the first piece of the path."""
    line = task.path.lines[0]
    count = len(line.on_map)
    return ContactTrail(
        np.full(count, line.patch), line.on_map, line.on_body, line.normals, np.full(count, age), np.zeros(count, bool)
    )


@pytest.mark.long
def test_path_is_on_the_skin_in_the_controller_colour(marks, led):
    task, _ = led
    marks.show(task)
    corners, inks = shown(marks, "path")
    expected = np.concatenate([line.on_body for line in task.path.lines])
    away = np.linalg.norm(corners[:, None] - expected[None], axis=2)
    assert away.min(axis=1).max() < 0.012
    assert away.min(axis=0).max() < 0.012
    violet = (255 * np.array(rgb(DARK.intent))).round()
    assert 0.3 < (inks == violet).all(axis=1).mean() < 0.9


def test_target_mark_leaves_its_centre_free(marks, led, prepared):
    task, _ = led
    marks.show(task)
    corners, _ = shown(marks, "target")
    away = np.linalg.norm(corners - prepared.skin.position(task.target), axis=1)
    width = away.max()
    assert away.min() > 0.25 * width
    np.testing.assert_allclose(corners.mean(axis=0), prepared.skin.position(task.target), atol=0.2 * width)


def test_contact_path_becomes_thinner_as_it_fades(marks, led):
    task, _ = led
    areas = []
    for age in (0.0, 0.95):
        marks.show(replace(task, tail=way(task, age)))
        corners, _ = shown(marks, "tail")
        sides = corners.reshape(-1, 3, 3)
        areas.append(np.linalg.norm(np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0]), axis=1).sum())
    assert 0.1 * areas[0] < areas[1] < 0.7 * areas[0]


def test_only_changed_marks_are_rebuilt(marks, led, monkeypatch):
    task, _ = led
    marks.show(task)
    filled = []
    kinds = {id(flat): kind for kind, flats in marks._kinds.items() for flat in flats}
    kind_of_flat = type(marks._kinds["path"][0])
    fill = kind_of_flat.fill
    monkeypatch.setattr(
        kind_of_flat, "fill", lambda flat, pieces: (filled.append(kinds[id(flat)]), fill(flat, pieces))[1]
    )
    marks.show(replace(task, goal=9.0))
    assert filled == []
    marks.show(replace(task, target=None))
    assert set(filled) == {"target"}
    assert len(shown(marks, "target")[0]) == 0


def test_marks_are_hidden_while_the_skin_is_flat(marks, led):
    task, _ = led
    marks.hide(hidden=True)
    marks.show(task)
    assert not any(actor.visibility for _, actor in marks.link_actors)
    marks.hide(hidden=False)
    assert len(shown(marks, "path")[0])


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_task_is_visible_in_the_picture(plotter, prepared, led, theme):
    task, frame = led
    scene = RobotActors(plotter, theme, PressureScale())
    scene.show_prepared(prepared)
    scene.show_frame(frame)
    skin = prepared.skin
    pose = scene.poses[prepared.robot.link_index[frame.regions[0].link]]
    focus = pose[:3, :3] @ skin.position(task.target) + pose[:3, 3]
    away = pose[:3, :3] @ skin.normal(task.target)
    scene.look(replace(scene.viewpoint, eye=focus + 0.5 * away, focus=focus))
    before = look(plotter)
    scene.show_task(task)
    after = look(plotter)
    assert shared_share(after, before, tolerance=24) < 0.9995
    scene.show_task(type(task)())
    again = look(plotter)
    np.testing.assert_array_equal(again, before)


def test_contact_ellipse_has_its_axes_and_can_be_hidden(plotter, prepared, led):
    _, frame = led
    region = frame.regions[0]
    scene = RobotActors(plotter, DARK, PressureScale(), body_layers(LAYERS))
    scene.show_prepared(prepared)
    scene.show_layers(frozenset({"shapes"}))
    scene.show_frame(frame)
    (ellipse, *_), (error, *_) = scene.layers["shapes"].ellipses, scene.layers["shapes"].errors
    turn = scene.poses[prepared.robot.link_index[region.link]][:3, :3]
    np.testing.assert_allclose(ellipse.user_matrix[:3, :2].T, region.link_axes @ turn.T, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(error.user_matrix[:3, :2], axis=0), region.place_error)
    scene.show_layers(frozenset())
    assert not ellipse.visibility
    scene.show_frame(replace(frame, tick=frame.tick + 1))
    assert not ellipse.visibility
    scene.show_layers(frozenset({"shapes"}))
    assert ellipse.visibility, "at once: no other frame may come"
