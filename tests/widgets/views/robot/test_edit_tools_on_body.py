"""Edit tools on the robot view: presses and the marks that are drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.editing.seams import draw_seam
from tactile_maps.maps.model.layout import MapLayout
from tactile_widgets.tools.map_editing.interest_tool import InterestTool
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.tools.registry import PINS
from tactile_widgets.views.overlays.body_overlays import MarkRole, PointMark, SkinTexture, ToolMarks
from tests.widgets.support.executors import HeldJobs
from tests.widgets.support.heard import Heard
from tests.widgets.support.map_view_driver import open_editor
from tests.widgets.support.robot_view_driver import BESIDE, LEFT, NONE, open_view, picture, skin_pixel
from tests.widgets.support.snapshots import pixels

pytestmark = pytest.mark.long

FAR = QPoint(24, -18)
_PIXELS = np.full((8, 8), 0xFF8080FF, np.uint32)


@pytest.fixture
def view(qtbot, prepared):
    made = open_view(qtbot)
    made.show_prepared(prepared)
    made.display.draw_now()
    made.set_tool(PINS)
    yield made
    made.close_view()


@pytest.fixture
def worker():
    return HeldJobs()


@pytest.fixture
def editor(worker, prepared):
    return open_editor(worker, MapDocument.of(prepared.map))


@pytest.fixture
def skin(view, prepared):
    return skin_pixel(view, prepared)


def take(view, tool):
    view.set_view_tool(tool)
    return tool


def move(view, pixel):
    QTest.mouseMove(view.display.canvas.widget, pixel)
    QApplication.processEvents()


def stroke(view, start, end):
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, start)
    for share in (0.25, 0.5, 0.75, 1.0):
        move(view, start + (end - start) * share)
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, end)


def changed(before, after):
    """(h, w) which pixels differ much."""
    return np.abs(pixels(after) - pixels(before)).max(axis=2) > 40


def test_click_on_the_body_adds_a_pin(view, editor, skin):
    heard = Heard(view)
    tool = take(view, PinTool(editor))
    before = picture(view)
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    ((pin,),) = [patch.pins for patch in editor.document.patches if patch.pins]
    away = view.display.pixel_of(pin.at) - QPointF(skin)
    assert np.hypot(away.x(), away.y()) < 0.5
    assert heard.acts == []
    move(view, BESIDE)
    shown = changed(before, picture(view))
    assert shown[skin.y() - 3 : skin.y() + 4, skin.x() - 3 : skin.x() + 4].any()
    assert shown.sum() < 400
    move(view, skin)
    assert view.display.canvas.widget.cursor().shape() == Qt.CursorShape.PointingHandCursor
    tool.remove()


def test_press_on_a_pin_selects_it_without_moving_it(view, editor, skin):
    tool = take(view, PinTool(editor))
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    tool._choose([])
    stroke(view, skin, skin + FAR)
    assert list(tool.chosen.values()) == [[0]]
    assert editor.history.names == ("Open", "Add a pin")


def test_drag_on_the_body_requests_a_seam_along_edges(view, editor, worker, skin):
    tool = take(view, SeamTool(editor))
    stroke(view, skin, skin + FAR)
    (requested,) = worker.held
    assert requested.name == "Draw a seam"
    (job,) = requested.jobs
    ends = job.edit.seams.drawn
    places = view.display.prepared.skin.patches[job.number].surface.vertices[np.unique(ends)]
    assert len(ends) > 2
    assert np.ptp(places, axis=0).max() > 0.01
    assert [line.role for line in tool.body_marks().lines][-1] is MarkRole.OFFERED
    worker.release()


def test_path_to_the_pointer_is_drawn_on_the_body(view, editor, skin):
    tool = take(view, SeamTool(editor))
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    before = picture(view)
    move(view, skin + FAR)
    shown = changed(before, picture(view))
    half = skin + FAR / 2
    assert shown[half.y() - 14 : half.y() + 15, half.x() - 14 : half.x() + 15].any()
    assert tool.body_marks().lines[-1].role is MarkRole.HELD


def test_stroke_on_the_body_paints_one_side_only(view, editor, worker, skin):
    tool = take(view, InterestTool(editor))
    tool.set_radius(30)
    before = picture(view)
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, skin)
    move(view, skin + FAR / 2)
    (tint,) = tool.body_marks().tints
    surface = view.display.prepared.skin.patches[tint.patch].surface
    normals = surface.vertex_normals[tint.vertices]
    assert len(normals) > 20
    assert (normals @ normals.mean(axis=0) > 0).mean() > 0.95
    shown = changed(before, picture(view))
    assert shown[skin.y() - 6 : skin.y() + 7, skin.x() - 6 : skin.x() + 7].mean() > 0.5
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, skin + FAR / 2)
    assert [requested.name for requested in worker.held] == ["Paint an area of interest"]


def test_marks_are_hidden_without_the_tool_and_off_the_body(view, editor):
    bare = picture(view)
    take(view, SeamTool(editor))
    marked = picture(view)
    assert changed(bare, marked).any()
    view.morph.slider.setValue(50)
    assert not any(actor.visibility for _, actor in view.display.actors._edit_marks.link_actors)
    view.morph.slider.setValue(0)
    assert picture(view) == marked
    view.set_view_tool(None)
    assert picture(view) == bare


def test_marks_behind_the_body_are_hidden(view, prepared):
    eye = view.display.actors.viewpoint.eye
    poses = view.display.actors.poses
    faces = []
    for taxel in range(len(prepared.skin)):
        at = prepared.skin.taxel_point(taxel)
        pose = poses[prepared.robot.link_index[prepared.skin.link(at)]]
        towards = eye - (pose[:3, :3] @ prepared.skin.position(at) + pose[:3, 3])
        faces.append(pose[:3, :3] @ prepared.skin.normal(at) @ towards / np.linalg.norm(towards))
    bare = picture(view)
    for taxel, seen in ((int(np.argmax(faces)), True), (int(np.argmin(faces)), False)):
        view.display.set_marks(
            ToolMarks(prepared.skin, spots=(PointMark(prepared.skin.taxel_point(taxel), MarkRole.HELD),))
        )
        assert bool(changed(bare, picture(view)).any()) == seen


def test_changed_map_is_shown_on_the_skin(view, editor, prepared):
    number = 2
    surface = prepared.skin.patches[number].surface
    ends = [int(surface.faces[0, 0]), int(surface.faces[len(surface.faces) // 2, 0])]
    document = apply_result(editor.document, reflatten(draw_seam(editor.document, number, ends)))
    assert len(document.charts[number].vertex_of) != len(prepared.map.charts[number].vertex_of)
    view.display.set_picture(SkinTexture(_PIXELS, prepared.map.bounds, prepared.map.uv), textured=False)
    view.display.show_map(document.map)
    view.morph.slider.setValue(30)  # the old map's picture does not fit the new one; it is not textured any more
    assert view.display.actors.skin._textured is None
    picture_of = SkinTexture(_PIXELS, document.map.bounds, document.map.uv)
    view.display.set_picture(picture_of, textured=True)
    view.morph.slider.setValue(100)
    at = prepared.skin.taxel_point(len(prepared.skin) - 1)
    there = view.display.actors.skin.point(at, view.display.actors.poses, view.display.actors._plane)[0]
    first = document.layout.placements[number]
    moved = replace(first, offset=(first.offset[0] + 0.1, first.offset[1]))
    layout = MapLayout((*document.layout.placements[:number], moved))
    before = picture(view)
    view.display.show_map(replace(document.map, layout=layout))
    assert changed(before, picture(view)).any()
    after = view.display.actors.skin.point(at, view.display.actors.poses, view.display.actors._plane)[0]
    assert np.linalg.norm(after - there) == pytest.approx(0.1)
