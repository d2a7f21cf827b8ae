"""The robot under a real hand: presses, strokes, turns and hovers on the real widget, with the real simulation."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QWidget

from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, THEMES, PressureScale
from tactile_widgets.views.robot.caption_overlay import CUBE, cube_faces
from tactile_widgets.views.robot.robot_view import RobotView
from tests.widgets.support.robot_view_driver import BESIDE, LEFT, MIDDLE, NONE, SHIFT


@pytest.fixture(scope="module")
def shown(qapp, prepared):
    """A view of the small arm, which the tests only look at from elsewhere."""
    view = RobotView(DARK, PressureScale())
    view.resize(480, 400)
    view.show()
    assert QTest.qWaitForWindowExposed(view)
    view.show_prepared(prepared)
    yield view
    view.close_view()
    view.close()
    view.deleteLater()


@pytest.fixture
def view(shown):
    """That view, with the robot fitted to it."""
    shown.display.frame_all()
    shown.display.draw_now()
    return shown


@pytest.mark.parametrize(
    ("button", "keys", "keeps"), [(LEFT, NONE, "focus"), (MIDDLE, NONE, "axes"), (LEFT, SHIFT, "axes")]
)
def test_drag_off_skin_turns_or_pans(view, heard, button, keys, keeps):
    before = view.display.actors.viewpoint
    QTest.mousePress(view.display.canvas.widget, button, keys, BESIDE)
    QTest.mouseMove(view.display.canvas.widget, BESIDE + QPoint(40, 25))
    QTest.mouseRelease(view.display.canvas.widget, button, keys, BESIDE + QPoint(40, 25))
    after = view.display.actors.viewpoint
    assert heard.acts == []
    assert np.linalg.norm(after.eye - before.eye) > 0.01
    np.testing.assert_allclose(getattr(after, keeps), getattr(before, keeps), atol=1e-12)


@pytest.mark.parametrize("width", [200, 230, 480])
def test_slider_to_the_map_is_whole_in_a_narrow_view(view, qapp, width):
    apply_theme(qapp, DARK)  # with the small font of captions
    view.resize(width, 300)
    QApplication.processEvents()
    slider = view.morph
    assert view.rect().contains(slider.geometry())
    for label in slider.findChildren(QLabel):
        assert slider.rect().contains(label.geometry()), label.text()
        assert label.width() >= label.sizeHint().width(), label.text()
    assert slider.slider.width() >= 40
    view.resize(480, 400)


@pytest.mark.parametrize("theme", THEMES.values(), ids=THEMES)
def test_slider_to_the_map_has_a_background(view, qapp, theme):
    apply_theme(qapp, theme)
    picture = QImage(view.morph.size(), QImage.Format.Format_RGB32)
    picture.fill("#ff00ff")  # the robot behind it
    view.morph.render(picture, QPoint(), renderFlags=QWidget.RenderFlag.DrawChildren)
    assert picture.pixelColor(picture.width() // 2, 2).name() == theme.panel
    apply_theme(qapp, DARK)


def cube_face(view, name):
    """The middle of a face of the orientation cube, and its direction; the face is in sight."""
    (face,) = [face for face in cube_faces(view.display.actors.viewpoint.axes) if face.name == name]
    middle = QPointF(view.width() - 3 * CUBE, view.height() - 3 * CUBE)
    x, y = (CUBE * face.corners.mean(axis=0)).tolist()
    return (middle + QPointF(x, y)).toPoint(), face.normal


@pytest.mark.parametrize("name", ["X", "Y", "Z"])
def test_click_on_the_cube_shows_that_side(view, heard, name):
    view.display.draw_now()
    place, normal = cube_face(view, name)
    focus = view.display.actors.viewpoint.focus
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.actors.viewpoint
    assert (looking.eye - focus) @ normal > 0.99 * looking.distance
    np.testing.assert_allclose(looking.focus, focus)
    assert heard.acts == []


@pytest.mark.parametrize("aside", [0, 9])
def test_double_click_on_the_cube_does_not_fit_the_view(view, aside):
    view.display.draw_now()
    place, normal = cube_face(view, "Y")
    place += QPoint(aside, 0)  # the cube may have turned away from under the pointer
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, place)
    view.display.draw_now()
    QTest.mouseDClick(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.actors.viewpoint
    assert abs((looking.eye - looking.focus) @ normal) > 0.99 * looking.distance


def test_drag_from_the_cube_has_no_effect(view, heard):
    view.display.draw_now()
    place, _ = cube_face(view, "Y")
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, place)
    looking = view.display.actors.viewpoint
    QTest.mouseMove(view.display.canvas.widget, place - QPoint(60, 60))
    QTest.mouseRelease(view.display.canvas.widget, LEFT, NONE, place - QPoint(60, 60))
    np.testing.assert_array_equal(view.display.actors.viewpoint.eye, looking.eye)
    assert heard.acts == []
