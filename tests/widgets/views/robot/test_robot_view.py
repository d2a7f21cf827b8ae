"""The robot under a real hand: presses, strokes, turns and hovers on the real widget, with the real simulation."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit

from tactile_widgets.views.robot.caption_overlay import CUBE, cube_faces
from tests.widgets.support.robot_view_driver import BESIDE, LEFT, MIDDLE, NONE, SHIFT, picture, wheel
from tests.widgets.support.snapshots import pixels, shared_share


def test_a_press_is_the_body_point_under_the_pointer(view, heard, prepared):
    hits = 0
    for x in range(10, view.width(), 30):
        for y in range(10, view.height(), 30):
            heard.acts.clear()
            QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, QPoint(x, y))
            if heard.acts:
                assert heard.kinds == ["pressed", "released"]
                away = view.display.pixel_of(heard.acts[0][1]) - QPointF(x, y)
                assert np.hypot(away.x(), away.y()) < 0.5
                hits += 1
    assert hits >= 8


def test_a_drag_strokes_and_off_the_skin_it_stays(view, heard, skin):
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, skin)
    QTest.mouseMove(view.display.canvas.widget, skin + QPoint(3, 2))
    QTest.mouseMove(view.display.canvas.widget, BESIDE)
    assert heard.kinds == ["pressed", "moved"]
    away = view.display.pixel_of(heard.acts[1][1]) - QPointF(skin + QPoint(3, 2))
    assert np.hypot(away.x(), away.y()) < 0.5
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, BESIDE)
    assert heard.kinds == ["pressed", "moved", "released"]


def test_escape_ends_a_poke(view, heard, skin):
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, skin)
    QTest.keyClick(view, Qt.Key.Key_Escape)
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"]


def test_losing_the_focus_ends_a_poke(view, heard, skin, qtbot):
    other = QLineEdit(view)
    other.show()
    view.activateWindow()
    view.setFocus()
    qtbot.waitUntil(view.hasFocus)
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed"]
    other.setFocus()
    assert heard.kinds == ["pressed", "released"]


@pytest.mark.parametrize(
    ("button", "keys", "keeps"), [(LEFT, NONE, "focus"), (MIDDLE, NONE, "axes"), (LEFT, SHIFT, "axes")]
)
def test_a_drag_beside_the_skin_moves_the_eye_and_pokes_nothing(view, heard, button, keys, keeps):
    before = view.display.scene.viewpoint
    QTest.mousePress(view.display.canvas.widget, button, keys, BESIDE)
    QTest.mouseMove(view.display.canvas.widget, BESIDE + QPoint(40, 25))
    QTest.mouseRelease(view.display.canvas.widget, button, keys, BESIDE + QPoint(40, 25))
    after = view.display.scene.viewpoint
    assert heard.acts == []
    assert np.linalg.norm(after.eye - before.eye) > 0.01
    np.testing.assert_allclose(getattr(after, keeps), getattr(before, keeps), atol=1e-12)


def test_the_middle_button_pans_on_the_skin_too(view, heard, skin):
    before = view.display.scene.viewpoint
    QTest.mousePress(view.display.canvas.widget, MIDDLE, NONE, skin)
    QTest.mouseMove(view.display.canvas.widget, skin + QPoint(10, 0))
    QTest.mouseRelease(view.display.canvas.widget, MIDDLE, NONE, skin + QPoint(10, 0))
    assert heard.acts == []
    assert np.linalg.norm(view.display.scene.viewpoint.focus - before.focus) > 1e-3


def test_turning_changes_the_picture_and_the_wheel_comes_closer(view):
    before = picture(view)
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, BESIDE)
    QTest.mouseMove(view.display.canvas.widget, BESIDE + QPoint(60, 0))
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, BESIDE + QPoint(60, 0))
    assert shared_share(pixels(before), pixels(picture(view)), tolerance=8) < 0.95
    distance = view.display.scene.viewpoint.distance
    wheel(view, 2)
    assert view.display.scene.viewpoint.distance == pytest.approx(distance / 1.15**2)


def test_a_double_click_beside_the_skin_and_f_frame_the_robot(view, heard):
    framed = view.display.scene.viewpoint.eye
    for frame_all in (
        lambda: QTest.mouseDClick(view.display.canvas.widget, LEFT, NONE, BESIDE),
        lambda: QTest.keyClick(view, Qt.Key.Key_F),
    ):
        wheel(view, 3)
        assert np.linalg.norm(view.display.scene.viewpoint.eye - framed) > 0.1
        frame_all()
        np.testing.assert_allclose(view.display.scene.viewpoint.eye, framed)
    assert heard.acts == []


def test_a_double_click_on_the_skin_is_a_second_poke(view, heard, skin):
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    QTest.mouseDClick(view.display.canvas.widget, LEFT, NONE, skin)
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"] * 2


def test_hover_says_where_and_the_cursor_what_a_press_would_do(view, heard, skin):
    QTest.mouseMove(view.display.canvas.widget, BESIDE)
    assert view.display.canvas.widget.cursor().shape() == Qt.CursorShape.OpenHandCursor
    QTest.mouseMove(view.display.canvas.widget, skin)
    assert view.display.canvas.widget.cursor().shape() == Qt.CursorShape.CrossCursor
    away = view.display.pixel_of(heard.hovers[-1]) - QPointF(skin)
    assert np.hypot(away.x(), away.y()) < 0.5
    QTest.mouseMove(view.display.canvas.widget, BESIDE)
    assert heard.hovers[-1] is None
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, BESIDE)
    assert view.display.canvas.widget.cursor().shape() == Qt.CursorShape.ClosedHandCursor
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, BESIDE)


def test_a_hover_from_elsewhere_is_marked(view, prepared, heard, skin):
    QTest.mouseMove(view.display.canvas.widget, skin)
    at = heard.hovers[-1]
    QTest.mouseMove(view.display.canvas.widget, BESIDE)
    before = picture(view)
    view.set_hover(at)
    assert picture(view) != before
    view.set_hover(None)
    assert picture(view) == before


def cube_face(view, name):
    """The middle of a face of the orientation cube, and its direction; the face is in sight."""
    (face,) = [face for face in cube_faces(view.display.scene.viewpoint.axes) if face.name == name]
    middle = QPointF(view.width() - 3 * CUBE, view.height() - 3 * CUBE)
    x, y = (CUBE * face.corners.mean(axis=0)).tolist()
    return (middle + QPointF(x, y)).toPoint(), face.normal


@pytest.mark.parametrize("name", ["X", "Y", "Z"])
def test_a_click_on_the_cube_looks_from_that_side(view, heard, name):
    view.display.draw_now()
    place, normal = cube_face(view, name)
    focus = view.display.scene.viewpoint.focus
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.scene.viewpoint
    assert (looking.eye - focus) @ normal > 0.99 * looking.distance
    np.testing.assert_allclose(looking.focus, focus)
    assert heard.acts == []


@pytest.mark.parametrize("aside", [0, 9])
def test_a_second_quick_click_on_the_cube_frames_nothing(view, aside):
    view.display.draw_now()
    place, normal = cube_face(view, "Y")
    place += QPoint(aside, 0)  # the cube may have turned away from under the pointer
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, place)
    view.display.draw_now()
    QTest.mouseDClick(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.scene.viewpoint
    assert abs((looking.eye - looking.focus) @ normal) > 0.99 * looking.distance


def test_a_drag_from_the_cube_neither_turns_nor_pokes(view, heard):
    view.display.draw_now()
    place, _ = cube_face(view, "Y")
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.scene.viewpoint
    QTest.mouseMove(view.display.canvas.widget, place - QPoint(60, 60))
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, place - QPoint(60, 60))
    np.testing.assert_array_equal(view.display.scene.viewpoint.eye, looking.eye)
    assert heard.acts == []
