"""A skin that is laid flat in the robot view is still the live one: it is poked, hovered and selected there."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests.widgets.hand_made import middle_taxel
from tests.widgets.window_acts import run
from widgets.robot_view.picture_skin import first_met
from widgets.robot_view.viewpoint import CameraRay
from widgets.tools import Tool

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def flat(window):
    """The window with the skin laid flat."""
    run(window, 0.1)
    window.robot_view.morph.slider.setValue(100)
    QApplication.processEvents()
    return window


def pixel(window, taxel):
    """Where a taxel is in the robot view, on the skin as it lies."""
    view = window.robot_view
    point, _ = view.scene._skin.point(window.live.prepared.skin.taxel_point(taxel), view.scene.poses, view.scene._plane)
    return QPointF(*view.scene.viewpoint.pixels(point[None], (view.width(), view.height()))[0])


def test_all_of_the_flat_skin_is_in_the_picture_before_the_eye(flat):
    view = flat.robot_view
    corners = np.concatenate([np.array(mesh.points) for mesh in view.scene._skin._worn._meshes])
    pixels = view.scene.viewpoint.pixels(corners, (view.width(), view.height()))
    assert (pixels > 0).all()
    assert (pixels < [view.width(), view.height()]).all()
    assert np.ptp(pixels, axis=0).max() > 0.4 * min(view.width(), view.height()), "not smaller than need be"


@pytest.mark.parametrize("patch", [0, 1, 2])
def test_a_press_on_the_flat_skin_pokes_there(flat, patch):
    skin, heard = flat.live.prepared.skin, []
    flat.views.poke_pressed.connect(heard.append)
    taxel = middle_taxel(flat.live.prepared.map, patch)
    QTest.mousePress(flat.robot_view.canvas.widget, LEFT, pos=pixel(flat, taxel).toPoint())
    assert len(heard) == 1
    assert heard[0].patch == patch
    assert np.linalg.norm(skin.position(heard[0]) - skin.position(skin.taxel_point(taxel))) < 5e-3
    view = flat.robot_view
    point, _ = view.scene._skin.point(heard[0], view.scene.poses, view.scene._plane)
    there = view.scene.viewpoint.pixels(point[None], (view.width(), view.height()))[0]
    np.testing.assert_allclose(there, pixel(flat, taxel).toPoint().toTuple(), atol=0.05)


def test_the_corners_of_chart_and_body_are_the_same_ones(flat):
    prepared = flat.live.prepared
    for patch, chart in zip(prepared.skin.patches, prepared.map.charts, strict=True):
        np.testing.assert_array_equal(chart.vertex_of[chart.faces], patch.surface.faces)


def test_the_hover_is_one_with_the_map(flat):
    taxel = middle_taxel(flat.live.prepared.map, 1)
    QTest.mouseMove(flat.robot_view.canvas.widget, pixel(flat, taxel).toPoint())
    assert flat.map_view._marks.hover is not None
    assert f"taxel {taxel}" in flat.readout.text()
    QTest.mouseMove(flat.robot_view.canvas.widget, QPoint(4, 4))
    assert flat.map_view._marks.hover is None


def test_a_box_on_the_flat_skin_selects_what_lies_in_it(flat):
    flat.seeing.set_tool(Tool.BOX)
    view, target = flat.robot_view, flat.robot_view.canvas.widget
    start = pixel(flat, middle_taxel(flat.live.prepared.map, 0)).toPoint()
    QTest.mousePress(target, LEFT, pos=start)
    QTest.mouseMove(target, start + QPoint(60, 40))
    QTest.mouseRelease(target, LEFT, pos=start + QPoint(60, 40))
    count = len(flat.live.prepared.skin)
    pixels = np.array([pixel(flat, taxel).toTuple() for taxel in range(count)])
    low = np.array(start.toTuple())
    inside = ((pixels > low) & (pixels < low + [60, 40])).all(axis=1)
    assert inside.sum() >= 2
    np.testing.assert_array_equal(flat.views.selection.mask, inside)
    np.testing.assert_allclose(view.taxel_pixels(), pixels, atol=1e-6)


def test_beside_the_flat_skin_the_view_turns(flat):
    heard = []
    flat.views.poke_pressed.connect(heard.append)
    before = flat.robot_view.scene.viewpoint.eye.copy()
    target = flat.robot_view.canvas.widget
    QTest.mousePress(target, LEFT, pos=QPoint(8, 40))
    QTest.mouseMove(target, QPoint(60, 60))
    QTest.mouseRelease(target, LEFT, pos=QPoint(60, 60))
    assert heard == []
    assert np.linalg.norm(flat.robot_view.scene.viewpoint.eye - before) > 0.01


def test_the_first_triangle_along_a_ray_is_met_from_either_side():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
    faces = np.array([[0, 1, 2], [3, 5, 4]])
    for height, way, expected in ((2.0, -1.0, 1), (-1.0, 1.0, 0), (0.5, 1.0, 1), (0.5, -1.0, 0)):
        ray = CameraRay(np.array([0.25, 0.5, height]), np.array([0.0, 0.0, way]))
        away, face, weights = first_met(points, faces, ray)
        assert face == expected
        np.testing.assert_allclose(weights @ points[faces[face]], ray.origin + away * ray.direction, atol=1e-12)
    beside = CameraRay(np.array([0.8, 0.8, 2.0]), np.array([0.0, 0.0, -1.0]))
    assert np.isinf(first_met(points, faces, beside)[0])
    behind = CameraRay(np.array([0.25, 0.25, 2.0]), np.array([0.0, 0.0, 1.0]))
    assert np.isinf(first_met(points, faces, behind)[0])
    along = CameraRay(np.array([-1.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))
    assert np.isinf(first_met(points, faces[:1], along)[0]), "edge on there is nothing to meet"
