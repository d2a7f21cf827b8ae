"""The skin on its way from the body to the map: where it lies, what it wears, and that the live touch goes with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests.widgets.hand_made import middle_taxel, touched
from tests.widgets.pictures import pixels, shared_share
from tests.widgets.window_acts import run, visible_skin
from widgets.robot_view.picture_skin import between
from widgets.selection import Choice
from widgets.tools import Change

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def still(window):
    """The window while time stands still, after a moment of life."""
    run(window, 0.1)
    window.live.set_paused(paused=True)
    return window


def lay(window, share):
    """Move the slider."""
    slider = window.robot_view.morph.slider
    slider.setValue(round(share * slider.maximum()))
    QApplication.processEvents()
    assert window.robot_view.morph.share == share


def points(window):
    """For each patch the corners (k, 3) of the skin as they lie now, world frame."""
    return [np.array(mesh.points) for mesh in window.robot_view.scene._skin._worn._meshes]


def on_body(window):
    """For each patch the corners (k, 3) of its chart on the body, world frame."""
    prepared, poses = window.live.prepared, window.robot_view.scene.poses
    places = []
    for patch, chart in zip(prepared.skin.patches, prepared.map.charts, strict=True):
        pose = poses[prepared.robot.link_index[patch.link]]
        places.append(patch.surface.vertices[chart.vertex_of] @ pose[:3, :3].T + pose[:3, 3])
    return places


def look(window, qtbot):
    """The robot view's pixels, once it has drawn."""
    with qtbot.waitSignal(window.robot_view.drawn, timeout=5000):
        window.robot_view.request()
    QApplication.processEvents()
    return pixels(window.robot_view.grab().toImage())


def show(window, taxels, *, kilopascals=25.0):
    """Both views with the robot as it stands, touched around these taxels by hand."""
    felt, stands = touched(window.live.prepared.map, taxels, kilopascals=kilopascals), window.live.runner.session.frame
    window.views.show_frame(replace(stands, pressures=felt.pressures, regions=felt.regions, pokes=()))
    QApplication.processEvents()


def test_at_the_end_the_skin_lies_as_on_the_map_facing_the_eye(still):
    lay(still, 1.0)
    plane = still.robot_view.scene._plane
    np.testing.assert_allclose(plane[:3, :3].T @ plane[:3, :3], np.eye(3), atol=1e-9)
    for flat, places in zip(points(still), still.live.prepared.map.uv, strict=True):
        local = (flat - plane[:3, 3]) @ plane[:3, :3]
        np.testing.assert_allclose(local[:, :2], places, atol=1e-6)
        np.testing.assert_allclose(local[:, 2], 0, atol=1e-6)
    right, up, forward = still.robot_view.scene.viewpoint.axes
    np.testing.assert_allclose(plane[:3, 2], -forward, atol=1e-9)
    np.testing.assert_allclose(plane[:3, :2].T, [right, up], atol=1e-9)


def test_half_way_each_corner_is_half_way_between_body_and_map(still):
    bodies = on_body(still)
    lay(still, 1.0)
    flats = points(still)
    lay(still, 0.5)
    for half, flat, there in zip(points(still), flats, bodies, strict=True):
        np.testing.assert_allclose(half, 0.5 * (flat + there), atol=1e-6)


def test_at_the_start_the_skin_is_the_body_again(still, qtbot):
    before = look(still, qtbot)
    lay(still, 0.01)
    for near, there in zip(points(still), on_body(still), strict=True):
        assert np.linalg.norm(near - there, axis=1).max() < 0.02
    lay(still, 1.0)
    assert shared_share(look(still, qtbot), before, tolerance=8) < 0.9
    lay(still, 0.0)
    assert still.robot_view.scene._skin._worn is None
    assert shared_share(look(still, qtbot), before, tolerance=8) > 0.995


def test_normals_stay_of_length_one_all_the_way(still):
    prepared = still.live.prepared
    patch, chart = prepared.skin.patches[0], prepared.map.charts[0]
    places, normals = patch.surface.vertices[chart.vertex_of], patch.surface.vertex_normals[chart.vertex_of]
    for share in (0.0, 0.3, 1.0):
        _, turned = between(places, normals, prepared.map.uv[0], np.eye(4), np.eye(4), share)
        np.testing.assert_allclose(np.linalg.norm(turned, axis=1), 1, atol=1e-9)
    assert np.allclose(turned, [0, 0, 1])


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_live_touch_goes_with_the_skin(still, qtbot, share):
    show(still, [])
    lay(still, share)
    bare = look(still, qtbot).astype(int)
    taxel = middle_taxel(still.live.prepared.map, 0)
    show(still, [taxel])
    hot = look(still, qtbot).astype(int)
    ruddier = (hot[..., 0] - hot[..., 2]) - (bare[..., 0] - bare[..., 2]) > 60
    assert ruddier.sum() > 30
    scene = still.robot_view.scene
    point, _ = scene._skin.point(still.live.prepared.skin.taxel_point(taxel), scene.poses, scene._plane)
    size = (still.robot_view.width(), still.robot_view.height())
    x, y = scene.viewpoint.pixels(point[None], size)[0]
    rows, columns = np.nonzero(ruddier)
    if share == 1.0:  # half way it may look aside
        assert np.hypot(columns.mean() - x, rows.mean() - y) < 20
    show(still, [])
    assert shared_share(look(still, qtbot), bare, tolerance=8) > 0.995


def test_the_robot_that_moves_takes_the_half_laid_skin_along(window, qtbot):
    run(window, 0.1)
    lay(window, 0.5)
    frame = window.live.runner.session.frame
    bodies, halves = on_body(window), points(window)
    with qtbot.waitSignal(window.robot_view.drawn, timeout=5000):
        window.views.show_frame(replace(frame, posture=frame.posture + 0.2))
    moved = [now - then for now, then in zip(on_body(window), bodies, strict=True)]
    assert max(np.abs(step).max() for step in moved) > 0.01
    for now, then, step in zip(points(window), halves, moved, strict=True):
        np.testing.assert_allclose(now - then, 0.5 * step, atol=1e-6)


def test_rings_of_selected_taxels_go_along(still):
    prepared = still.live.prepared
    taxel = middle_taxel(prepared.map, 0)
    still.views.selection.take(Choice(np.array([taxel]), Change.REPLACE))
    scene = still.robot_view.scene
    for share in (1.0, 0.5, 0.0):
        lay(still, share)
        point, normal = scene._skin.point(prepared.skin.taxel_point(taxel), scene.poses, scene._plane)
        actor = scene._skin._rings.actors[0]
        ring = np.array(actor.mapper.dataset.points)
        matrix = np.array(actor.user_matrix)
        middle = (ring @ matrix[:3, :3].T + matrix[:3, 3]).mean(axis=0)
        assert np.linalg.norm(middle - point) < 3e-3
        assert (middle - point) @ normal > 0, "above the skin"


def test_no_contact_is_drawn_on_the_bare_body_meanwhile(still, qtbot):
    with qtbot.waitSignal(still.robot_view.drawn, timeout=5000):
        show(still, [middle_taxel(still.live.prepared.map, 0)])
    assert still.robot_view.scene.forces
    lay(still, 0.5)
    assert not still.robot_view.scene.forces
    lay(still, 0.0)
    assert still.robot_view.scene.forces


def test_laying_the_skin_flat_lifts_the_finger(window):
    run(window, 0.1)
    heard = []
    window.views.poke_pressed.connect(heard.append)
    window.views.poke_released.connect(lambda: heard.append("released"))
    _, pixel = visible_skin(window)
    QTest.mousePress(window.robot_view.canvas.widget, LEFT, pos=pixel)
    assert len(heard) == 1
    lay(window, 0.5)
    assert heard[-1] == "released"


def test_the_key_goes_to_the_other_end_and_back(still, qtbot):
    still.activateWindow()
    still.map_view.setFocus()
    morph = still.robot_view.morph
    QTest.keyClick(still.map_view, Qt.Key.Key_M)
    qtbot.waitUntil(lambda: morph.share == 1.0, timeout=3000)
    QTest.keyClick(still.map_view, Qt.Key.Key_M)
    qtbot.waitUntil(lambda: morph.share == 0.0, timeout=3000)


def test_another_robot_begins_on_its_body(still, prepared):
    lay(still, 1.0)
    still.live.show_prepared(prepared)
    assert still.robot_view.morph.share == 0
    assert not still.robot_view.scene.morphed
