"""The robot under a real hand: presses, strokes, turns and hovers on the real widget, with the real simulation."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton

from app.errors import RobotError
from app.session.session import Session
from app.simulation.poke import PokePressed
from tests.widgets.pictures import pixels, shared_share
from widgets.colours import DARK, LIGHT, PressureScale
from widgets.robot_view.robot_view import RobotView

LEFT, MIDDLE, NONE = Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton, Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
BESIDE = QPoint(4, 4)


class Heard:
    """Remembers what a view emitted."""

    def __init__(self, view):
        self.acts, self.hovers, self.drawn = [], [], []
        view.poke_pressed.connect(self._on_pressed)
        view.poke_moved.connect(self._on_moved)
        view.poke_released.connect(self._on_released)
        view.hovered.connect(self.hovers.append)
        view.drawn.connect(self.drawn.append)

    def _on_pressed(self, at):
        self.acts.append(("pressed", at))

    def _on_moved(self, at):
        self.acts.append(("moved", at))

    def _on_released(self):
        self.acts.append(("released", None))

    @property
    def kinds(self):
        return [kind for kind, _ in self.acts]


@pytest.fixture
def empty(qtbot):
    view = RobotView(DARK, PressureScale())
    qtbot.addWidget(view)
    view.resize(480, 400)
    view.show()
    qtbot.waitExposed(view)
    yield view
    view.close_view()


@pytest.fixture
def view(empty, prepared):
    empty.show_prepared(prepared)
    empty.draw_now()
    return empty


@pytest.fixture
def heard(view):
    return Heard(view)


@pytest.fixture
def skin(view, prepared):
    """A pixel on the skin with skin all around it, and what is there."""
    eye = view.scene.viewpoint.eye
    poses = view.scene.poses
    for taxel in range(len(prepared.skin)):
        at = prepared.skin.taxel_point(taxel)
        pose = poses[prepared.robot.link_index[prepared.skin.link(at)]]
        towards = eye - (pose[:3, :3] @ prepared.skin.position(at) + pose[:3, 3])
        if pose[:3, :3] @ prepared.skin.normal(at) @ towards > 0.9 * np.linalg.norm(towards):
            return view.pixel_of(at).toPoint()
    pytest.fail("no taxel faces the eye")


@pytest.fixture
def pressed(prepared, view, skin):
    """A frame in which a finger has pressed for half a second at the skin pixel."""
    heard = Heard(view)
    QTest.mouseClick(view.canvas.widget, LEFT, NONE, skin)
    session = Session(prepared, scripted=False)
    session.submit(PokePressed(0, heard.acts[0][1]))
    for _ in range(100):
        session.tick()
    assert session.frame.regions
    return session.frame


def picture(view):
    view.draw_now()
    return view.grab().toImage()


def wheel(view, notches):
    place = QPointF(view.rect().center())
    event = QWheelEvent(place, view.mapToGlobal(place), QPoint(), QPoint(0, 120 * notches),
                        Qt.MouseButton.NoButton, NONE, Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(view.canvas.widget, event)


def test_a_press_is_the_body_point_under_the_pointer(view, heard, prepared):
    hits = 0
    for x in range(10, view.width(), 30):
        for y in range(10, view.height(), 30):
            heard.acts.clear()
            QTest.mouseClick(view.canvas.widget, LEFT, NONE, QPoint(x, y))
            if heard.acts:
                assert heard.kinds == ["pressed", "released"]
                away = view.pixel_of(heard.acts[0][1]) - QPointF(x, y)
                assert np.hypot(away.x(), away.y()) < 0.5
                hits += 1
    assert hits >= 8


def test_the_pressed_pixel_has_the_colour_of_skin_not_of_a_link(view, skin):
    image = picture(view)
    colour = image.pixelColor(skin)
    assert min(colour.red(), colour.green(), colour.blue()) > 100
    assert image.pixelColor(BESIDE) != colour


def test_a_drag_strokes_and_off_the_skin_it_stays(view, heard, skin):
    QTest.mousePress(view.canvas.widget, LEFT, NONE, skin)
    QTest.mouseMove(view.canvas.widget, skin + QPoint(3, 2))
    QTest.mouseMove(view.canvas.widget, BESIDE)
    assert heard.kinds == ["pressed", "moved"]
    away = view.pixel_of(heard.acts[1][1]) - QPointF(skin + QPoint(3, 2))
    assert np.hypot(away.x(), away.y()) < 0.5
    QTest.mouseRelease(view.canvas.widget, LEFT, NONE, BESIDE)
    assert heard.kinds == ["pressed", "moved", "released"]


def test_escape_ends_a_poke(view, heard, skin):
    QTest.mousePress(view.canvas.widget, LEFT, NONE, skin)
    QTest.keyClick(view, Qt.Key.Key_Escape)
    QTest.mouseRelease(view.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"]


def test_losing_the_focus_ends_a_poke(view, heard, skin, qtbot):
    other = QLineEdit(view)
    other.show()
    view.activateWindow()
    view.setFocus()
    qtbot.waitUntil(view.hasFocus)
    QTest.mousePress(view.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed"]
    other.setFocus()
    assert heard.kinds == ["pressed", "released"]


@pytest.mark.parametrize(
    ("button", "keys", "keeps"), [(LEFT, NONE, "focus"), (MIDDLE, NONE, "axes"), (LEFT, SHIFT, "axes")]
)
def test_a_drag_beside_the_skin_moves_the_eye_and_pokes_nothing(view, heard, button, keys, keeps):
    before = view.scene.viewpoint
    QTest.mousePress(view.canvas.widget, button, keys, BESIDE)
    QTest.mouseMove(view.canvas.widget, BESIDE + QPoint(40, 25))
    QTest.mouseRelease(view.canvas.widget, button, keys, BESIDE + QPoint(40, 25))
    after = view.scene.viewpoint
    assert heard.acts == []
    assert np.linalg.norm(after.eye - before.eye) > 0.01
    np.testing.assert_allclose(getattr(after, keeps), getattr(before, keeps), atol=1e-12)


def test_the_middle_button_pans_on_the_skin_too(view, heard, skin):
    before = view.scene.viewpoint
    QTest.mousePress(view.canvas.widget, MIDDLE, NONE, skin)
    QTest.mouseMove(view.canvas.widget, skin + QPoint(10, 0))
    QTest.mouseRelease(view.canvas.widget, MIDDLE, NONE, skin + QPoint(10, 0))
    assert heard.acts == []
    assert np.linalg.norm(view.scene.viewpoint.focus - before.focus) > 1e-3


def test_turning_changes_the_picture_and_the_wheel_comes_closer(view):
    before = picture(view)
    QTest.mousePress(view.canvas.widget, LEFT, NONE, BESIDE)
    QTest.mouseMove(view.canvas.widget, BESIDE + QPoint(60, 0))
    QTest.mouseRelease(view.canvas.widget, LEFT, NONE, BESIDE + QPoint(60, 0))
    assert shared_share(pixels(before), pixels(picture(view)), tolerance=8) < 0.95
    distance = view.scene.viewpoint.distance
    wheel(view, 2)
    assert view.scene.viewpoint.distance == pytest.approx(distance / 1.15**2)


def test_a_double_click_beside_the_skin_and_f_frame_the_robot(view, heard):
    framed = view.scene.viewpoint.eye
    for frame_all in (
        lambda: QTest.mouseDClick(view.canvas.widget, LEFT, NONE, BESIDE),
        lambda: QTest.keyClick(view, Qt.Key.Key_F),
    ):
        wheel(view, 3)
        assert np.linalg.norm(view.scene.viewpoint.eye - framed) > 0.1
        frame_all()
        np.testing.assert_allclose(view.scene.viewpoint.eye, framed)
    assert heard.acts == []


def test_a_double_click_on_the_skin_is_a_second_poke(view, heard, skin):
    QTest.mouseClick(view.canvas.widget, LEFT, NONE, skin)
    QTest.mouseDClick(view.canvas.widget, LEFT, NONE, skin)
    QTest.mouseRelease(view.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"] * 2


def test_what_is_framed_stays_whole_when_the_view_is_resized(view, prepared):
    view.resize(240, 500)
    taxels = range(0, len(prepared.skin), 10)
    places = [view.pixel_of(prepared.skin.taxel_point(taxel)) for taxel in taxels]
    assert all(0 < place.x() < 240 and 0 < place.y() < 500 for place in places)
    wheel(view, 3)
    eye = view.scene.viewpoint.eye
    view.resize(480, 400)
    np.testing.assert_array_equal(view.scene.viewpoint.eye, eye)


def test_hover_says_where_and_the_cursor_what_a_press_would_do(view, heard, skin):
    QTest.mouseMove(view.canvas.widget, BESIDE)
    assert view.canvas.widget.cursor().shape() == Qt.CursorShape.OpenHandCursor
    QTest.mouseMove(view.canvas.widget, skin)
    assert view.canvas.widget.cursor().shape() == Qt.CursorShape.CrossCursor
    away = view.pixel_of(heard.hovers[-1]) - QPointF(skin)
    assert np.hypot(away.x(), away.y()) < 0.5
    QTest.mouseMove(view.canvas.widget, BESIDE)
    assert heard.hovers[-1] is None
    QTest.mousePress(view.canvas.widget, LEFT, NONE, BESIDE)
    assert view.canvas.widget.cursor().shape() == Qt.CursorShape.ClosedHandCursor
    QTest.mouseRelease(view.canvas.widget, LEFT, NONE, BESIDE)


def test_a_hover_from_elsewhere_is_marked(view, prepared, heard, skin):
    QTest.mouseMove(view.canvas.widget, skin)
    at = heard.hovers[-1]
    QTest.mouseMove(view.canvas.widget, BESIDE)
    before = picture(view)
    view.set_hover(at)
    assert picture(view) != before
    view.set_hover(None)
    assert picture(view) == before


def test_a_touch_is_drawn_where_it_is(view, skin, pressed):
    quiet = pixels(picture(view))
    view.show_frame(pressed)
    loud = pixels(picture(view))
    changed = np.abs(loud - quiet).max(axis=2) > 40
    near = np.zeros(changed.shape, dtype=bool)
    near[max(skin.y() - 12, 0) : skin.y() + 12, max(skin.x() - 12, 0) : skin.x() + 12] = True
    assert (changed & near).any()
    assert changed.mean() < 0.2


def test_frames_are_drawn_soon_and_only_when_something_changed(view, heard, pressed, qtbot):
    heard.drawn.clear()
    view.show_frame(pressed)
    assert heard.drawn == []  # not before the map had its turn
    qtbot.waitUntil(lambda: bool(heard.drawn) and not view._drawing.waiting)
    assert len(heard.drawn) in (1, 2)  # once live, and at rest once more where the machine is quick
    with qtbot.assertNotEmitted(view.drawn, wait=60):
        view.show_frame(pressed)


def test_a_hidden_view_draws_nothing_and_catches_up(view, pressed, qtbot):
    view.hide()
    with qtbot.assertNotEmitted(view.drawn, wait=60):
        view.show_frame(pressed)
    with qtbot.waitSignal(view.drawn):
        view.show()
    assert view.scene.shows(pressed)


def test_each_state_says_what_helps(empty, prepared, qtbot):
    button = empty.findChild(QPushButton)
    with qtbot.waitSignal(empty.open_requested):
        QTest.mouseClick(button, LEFT)
    empty.show_prepared(prepared)
    assert not button.isVisible()
    empty.show_loading("Flattening", 0.5)
    with qtbot.waitSignal(empty.cancel_requested):
        QTest.mouseClick(button, LEFT)
    empty.show_failed("The mesh has no surface.")
    with qtbot.waitSignal(empty.open_requested):
        QTest.mouseClick(button, LEFT)
    empty.show_last()
    assert not button.isVisible()


def test_without_a_robot_there_is_nothing_to_poke_or_find(empty, prepared):
    heard = Heard(empty)
    QTest.mouseClick(empty.canvas.widget, LEFT, NONE, QPoint(200, 200))
    empty.set_hover(prepared.skin.taxel_point(0))
    empty.show_last()
    assert heard.acts == []
    with pytest.raises(RobotError, match="no robot"):
        empty.pixel_of(prepared.skin.taxel_point(0))


def test_loading_ends_a_poke(view, heard, skin):
    QTest.mousePress(view.canvas.widget, LEFT, NONE, skin)
    view.show_loading("Flattening", 0.5)
    assert heard.kinds == ["pressed", "released"]
    QTest.mouseClick(view.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"]


def test_replaying_has_an_edge_and_paused_a_word(view):
    live = picture(view)
    view.set_replaying(replaying=True)
    assert view.grab().toImage().pixelColor(1, 200) != live.pixelColor(1, 200)
    view.set_replaying(replaying=False)
    view.set_paused(paused=True)
    assert view.grab().toImage() != live
    view.set_paused(paused=False)
    assert view.grab().toImage() == live


def test_themes_scales_and_robots_change_while_it_is_open(view, prepared, pressed):
    dark = picture(view)
    view.set_theme(LIGHT)
    assert picture(view).pixelColor(BESIDE).lightness() > 200
    view.set_theme(DARK)
    view.show_frame(pressed)
    touched = picture(view)
    view.set_scale(PressureScale(5.0))
    assert picture(view) != touched
    view.set_scale(PressureScale())
    view.show_prepared(prepared)
    assert picture(view) == dark
