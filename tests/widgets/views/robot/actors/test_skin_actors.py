"""The skin between body and map: location, texture, pokes, selection and touch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.common.tool_kinds import SELECT_BOX, SelectionMode
from tactile_widgets.document.taxel_selection import SelectionUpdate
from tactile_widgets.views.robot.actors.camera import CameraRay
from tactile_widgets.views.robot.actors.skin_actors import PEELED, morphed, ray_mesh_intersection
from tests.widgets.support.mouse import left_drag, left_press
from tests.widgets.support.samples import middle_taxel, touched
from tests.widgets.support.snapshots import pixels, shared_share
from tests.widgets.support.window_driver import run, visible_skin


@pytest.fixture
def window(window_again):
    """The skin is on the body again where a scene is shown."""
    return window_again


@pytest.fixture
def still(window):
    """The paused window, after it has run for a moment."""
    run(window, 0.1)
    window.live.set_paused(paused=True)
    window.robot_view.display.draw_now()
    return window


def lay(window, share):
    """Move the slider."""
    slider = window.robot_view.morph.slider
    slider.setValue(round(share * slider.maximum()))
    QApplication.processEvents()
    assert window.robot_view.morph.share == share


def points(window):
    """For each patch the corners (k, 3) of the skin at present, world frame."""
    return [np.array(mesh.points) for mesh in window.robot_view.display.actors.skin._textured._meshes]


def on_body(window):
    """For each patch the corners (k, 3) of its chart on the body, world frame."""
    prepared = window.live.prepared
    poses = window.robot_view.display.actors.poses
    places = []
    for patch, chart in zip(prepared.skin.patches, prepared.map.charts, strict=True):
        pose = poses[prepared.robot.link_index[patch.link]]
        places.append(patch.surface.vertices[chart.vertex_of] @ pose[:3, :3].T + pose[:3, 3])
    return places


def look(window):
    """Return the pixels of the robot view after drawing."""
    window.robot_view.display.draw_now()
    QApplication.processEvents()
    return pixels(window.robot_view.grab().toImage())


def show(window, taxels, *, kilopascals=25.0):
    """Show the current frame in both views, with a touch around these taxels."""
    felt = touched(window.live.prepared.map, taxels, kilopascals=kilopascals)
    frame = window.live.runner.session.frame
    window.views.show_frame(replace(frame, pressures=felt.pressures, regions=felt.regions, pokes=()))
    QApplication.processEvents()


@pytest.mark.long
def test_flat_skin_equals_the_map_and_faces_the_camera(still):
    lay(still, 1.0)
    plane = still.robot_view.display.actors._plane
    np.testing.assert_allclose(plane[:3, :3].T @ plane[:3, :3], np.eye(3), atol=1e-9)
    for flat, places in zip(points(still), still.live.prepared.map.uv, strict=True):
        local = (flat - plane[:3, 3]) @ plane[:3, :3]
        np.testing.assert_allclose(local[:, :2], places, atol=1e-6)
        np.testing.assert_allclose(local[:, 2], 0, atol=1e-6)
    right, up, forward = still.robot_view.display.actors.viewpoint.axes
    np.testing.assert_allclose(plane[:3, 2], -forward, atol=1e-9)
    np.testing.assert_allclose(plane[:3, :2].T, [right, up], atol=1e-9)


@pytest.mark.long
def test_skin_leaves_the_body_before_it_is_flattened(still):
    """The skin never enters a visible link: it moves out along its normals, the links fade, then it flattens."""
    scene = still.robot_view.display.actors
    bodies = on_body(still)
    outward = []
    prepared = still.live.prepared
    for patch, chart in zip(prepared.skin.patches, prepared.map.charts, strict=True):
        pose = scene.poses[prepared.robot.link_index[patch.link]]
        outward.append(patch.surface.vertex_normals[chart.vertex_of] @ pose[:3, :3].T)
    for share in (0.01, 0.03, PEELED):
        lay(still, share)
        for near, there, normal in zip(points(still), bodies, outward, strict=True):
            height = np.einsum("kd,kd->k", near - there, normal)
            assert height.min() > 0.0005
            np.testing.assert_allclose(near, there + height[:, None] * normal, atol=1e-6)
    assert all(actor.prop.opacity < 0.1 for _, actor in scene.links.placed), "from here on it may go through them"
    peeled = points(still)
    lay(still, 1.0)
    flats = points(still)
    lay(still, 0.55)
    for half, flat, there in zip(points(still), flats, peeled, strict=True):
        np.testing.assert_allclose(half, 0.5 * (flat + there), atol=1e-6)


@pytest.mark.long
def test_skin_returns_to_the_body(still):
    before = look(still)
    lay(still, 0.01)
    for near, there in zip(points(still), on_body(still), strict=True):
        assert np.linalg.norm(near - there, axis=1).max() < 0.02
    lay(still, 1.0)
    assert shared_share(look(still), before, tolerance=8) < 0.9
    lay(still, 0.0)
    assert still.robot_view.display.actors.skin._textured is None
    assert shared_share(look(still), before, tolerance=8) > 0.995


@pytest.mark.long
def test_normals_have_length_one(still):
    prepared = still.live.prepared
    patch = prepared.skin.patches[0]
    chart = prepared.map.charts[0]
    places = patch.surface.vertices[chart.vertex_of]
    normals = patch.surface.vertex_normals[chart.vertex_of]
    for share in (0.0, 0.3, 1.0):
        _, turned = morphed(places, normals, prepared.map.uv[0], np.eye(4), np.eye(4), share, 0.01)
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1, atol=1e-9)
    assert np.allclose(turned, [0, 0, 1])


@pytest.mark.long
@pytest.mark.parametrize("share", [0.5, 1.0])
def test_touch_follows_the_skin(still, share):
    show(still, [])
    lay(still, share)
    bare = look(still).astype(int)
    taxel = middle_taxel(still.live.prepared.map, 0)
    show(still, [taxel])
    hot = look(still).astype(int)
    ruddier = (hot[..., 0] - hot[..., 2]) - (bare[..., 0] - bare[..., 2]) > 60
    assert ruddier.sum() > 30
    scene = still.robot_view.display.actors
    point, _ = scene.skin.point(still.live.prepared.skin.taxel_point(taxel), scene.poses, scene._plane)
    size = (still.robot_view.width(), still.robot_view.height())
    x, y = scene.viewpoint.pixels(point[None], size)[0]
    rows, columns = np.nonzero(ruddier)
    if share == 1.0:  # half way it may look aside
        assert np.hypot(columns.mean() - x, rows.mean() - y) < 20
    show(still, [])
    assert shared_share(look(still), bare, tolerance=8) > 0.995


@pytest.mark.long
def test_half_flat_skin_follows_the_robot(still):
    """Each posture is drawn at once, because an earlier frame may still be pending."""
    window = still
    frame = still.live.shown

    def at(posture, share):
        window.views.show_frame(replace(frame, posture=posture))
        lay(window, share)
        window.robot_view.display.draw_now()
        return points(window)

    peeled = at(frame.posture, PEELED)
    halves = at(frame.posture, 0.55)
    after = at(frame.posture + 0.2, 0.55)
    lay(window, PEELED)
    moved = [now - then for now, then in zip(points(window), peeled, strict=True)]
    assert max(np.abs(step).max() for step in moved) > 0.01
    for now, then, step in zip(after, halves, moved, strict=True):
        np.testing.assert_allclose(now - then, 0.5 * step, atol=1e-6)


@pytest.mark.long
def test_selection_rings_follow_the_skin(still):
    prepared = still.live.prepared
    taxel = middle_taxel(prepared.map, 0)
    still.views.selection.take(SelectionUpdate(np.array([taxel]), SelectionMode.REPLACE))
    scene = still.robot_view.display.actors
    for share in (1.0, 0.5, 0.0):
        lay(still, share)
        point, normal = scene.skin.point(prepared.skin.taxel_point(taxel), scene.poses, scene._plane)
        actor = scene.skin._rings.actors[0]
        ring = np.array(actor.mapper.GetInput().points)
        matrix = np.array(actor.user_matrix)
        middle = (ring @ matrix[:3, :3].T + matrix[:3, 3]).mean(axis=0)
        assert np.linalg.norm(middle - point) < 3e-3
        assert (middle - point) @ normal > 0, "above the skin"


@pytest.mark.long
def test_contacts_are_hidden_while_the_skin_is_off_the_body(still):
    show(still, [middle_taxel(still.live.prepared.map, 0)])
    still.robot_view.display.draw_now()
    assert still.robot_view.display.actors.forces
    lay(still, 0.5)
    assert not still.robot_view.display.actors.forces
    lay(still, 0.0)
    assert still.robot_view.display.actors.forces


@pytest.mark.long
def test_force_behind_the_camera_has_no_caption(still):
    display = still.robot_view.display
    show(still, [middle_taxel(still.live.prepared.map, 0)])
    display.draw_now()
    assert display._captions.forces
    view = display.actors.viewpoint
    display.look(replace(view, focus=2 * view.eye - view.focus))
    display.draw_now()
    assert display.actors.forces
    assert not display._captions.forces


@pytest.mark.long
def test_flattening_ends_a_poke(window):
    run(window, 0.1)
    heard = []
    for gestures in window.views.interactions:
        gestures.poke_pressed.connect(heard.append)
        gestures.poke_released.connect(lambda: heard.append("released"))
    _, pixel = visible_skin(window)
    left_press(window.robot_view.display.canvas.widget, pixel)
    assert len(heard) == 1
    lay(window, 0.5)
    assert heard[-1] == "released"


@pytest.mark.long
def test_key_toggles_between_body_and_map(still, qtbot):
    still.activateWindow()
    still.map_view.setFocus()
    morph = still.robot_view.morph
    QTest.keyClick(still.map_view, Qt.Key.Key_M)
    qtbot.waitUntil(lambda: morph.share == 1.0)
    QTest.keyClick(still.map_view, Qt.Key.Key_M)
    qtbot.waitUntil(lambda: morph.share == 0.0)


@pytest.mark.long
def test_another_robot_starts_on_the_body(still, prepared):
    lay(still, 1.0)
    still.live.show_prepared(prepared)
    assert still.robot_view.morph.share == 0
    assert not still.robot_view.display.actors.morphed


@pytest.fixture
def flat(window):
    """The window with the skin flattened."""
    run(window, 0.1)
    window.robot_view.morph.slider.setValue(100)
    QApplication.processEvents()
    return window


def pixel(window, taxel):
    """Return the pixel of a taxel in the robot view, on the skin as displayed."""
    view = window.robot_view
    point, _ = view.display.actors.skin.point(
        window.live.prepared.skin.taxel_point(taxel), view.display.actors.poses, view.display.actors._plane
    )
    return QPointF(*view.display.actors.viewpoint.pixels(point[None], (view.width(), view.height()))[0])


@pytest.mark.long
def test_whole_flat_skin_is_in_the_picture(flat):
    view = flat.robot_view
    corners = np.concatenate([np.array(mesh.points) for mesh in view.display.actors.skin._textured._meshes])
    pixels = view.display.actors.viewpoint.pixels(corners, (view.width(), view.height()))
    assert (pixels > 0).all()
    assert (pixels < [view.width(), view.height()]).all()
    assert np.ptp(pixels, axis=0).max() > 0.4 * min(view.width(), view.height()), "not smaller than need be"


@pytest.mark.long
@pytest.mark.parametrize("patch", [0, 1, 2])
def test_press_on_flat_skin_pokes(flat, patch):
    skin = flat.live.prepared.skin
    heard = []
    for gestures in flat.views.interactions:
        gestures.poke_pressed.connect(heard.append)
    taxel = middle_taxel(flat.live.prepared.map, patch)
    left_press(flat.robot_view.display.canvas.widget, pixel(flat, taxel).toPoint())
    assert len(heard) == 1
    assert heard[0].patch == patch
    assert np.linalg.norm(skin.position(heard[0]) - skin.position(skin.taxel_point(taxel))) < 5e-3
    view = flat.robot_view
    point, _ = view.display.actors.skin.point(heard[0], view.display.actors.poses, view.display.actors._plane)
    there = view.display.actors.viewpoint.pixels(point[None], (view.width(), view.height()))[0]
    np.testing.assert_allclose(there, pixel(flat, taxel).toPoint().toTuple(), atol=0.05)


def test_box_on_flat_skin_selects_enclosed_taxels(flat):
    flat.presenters.view.set_tool(SELECT_BOX)
    view = flat.robot_view
    target = flat.robot_view.display.canvas.widget
    start = pixel(flat, middle_taxel(flat.live.prepared.map, 0)).toPoint()
    left_drag(target, start, start + QPoint(60, 40))
    count = len(flat.live.prepared.skin)
    pixels = np.array([pixel(flat, taxel).toTuple() for taxel in range(count)])
    low = np.array(start.toTuple())
    inside = ((pixels > low) & (pixels < low + [60, 40])).all(axis=1)
    assert inside.sum() >= 2
    np.testing.assert_array_equal(flat.views.selection.mask, inside)
    np.testing.assert_allclose(view.taxel_pixels(), pixels, atol=1e-6)


def test_first_triangle_along_a_ray_is_found_from_either_side():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
    faces = np.array([[0, 1, 2], [3, 5, 4]])
    for height, way, expected in ((2.0, -1.0, 1), (-1.0, 1.0, 0), (0.5, 1.0, 1), (0.5, -1.0, 0)):
        ray = CameraRay(np.array([0.25, 0.5, height]), np.array([0.0, 0.0, way]))
        away, face, weights = ray_mesh_intersection(points, faces, ray)
        assert face == expected
        np.testing.assert_allclose(weights @ points[faces[face]], ray.origin + away * ray.direction, atol=1e-12)
    missing = CameraRay(np.array([0.8, 0.8, 2.0]), np.array([0.0, 0.0, -1.0]))
    assert np.isinf(ray_mesh_intersection(points, faces, missing)[0])
    behind = CameraRay(np.array([0.25, 0.25, 2.0]), np.array([0.0, 0.0, 1.0]))
    assert np.isinf(ray_mesh_intersection(points, faces, behind)[0])
    along = CameraRay(np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
    assert np.isinf(ray_mesh_intersection(points, faces[:1], along)[0]), "edge on there is nothing to meet"
