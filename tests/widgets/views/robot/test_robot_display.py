"""What the robot view shows, and when: frames, states, themes; nothing while nobody sees it."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton

from tactile_maps.core.errors import RobotError
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tests.widgets.support.robot_view_driver import BESIDE, LEFT, NONE, Heard, picture, pressed_frame, wheel
from tests.widgets.support.snapshots import pixels


@pytest.fixture
def pressed(prepared, view, skin):
    """A frame in which a finger has pressed for half a second at the skin pixel."""
    return pressed_frame(view, prepared, skin)


def test_the_pressed_pixel_has_the_colour_of_skin_not_of_a_link(view, skin):
    image = picture(view)
    colour = image.pixelColor(skin)
    assert min(colour.red(), colour.green(), colour.blue()) > 100
    assert image.pixelColor(BESIDE) != colour


def test_what_is_framed_stays_whole_when_the_view_is_resized(view, prepared):
    view.resize(240, 500)
    taxels = range(0, len(prepared.skin), 10)
    places = [view.display.pixel_of(prepared.skin.taxel_point(taxel)) for taxel in taxels]
    assert all(0 < place.x() < 240 and 0 < place.y() < 500 for place in places)
    wheel(view, 3)
    eye = view.display.scene.viewpoint.eye
    view.resize(480, 400)
    np.testing.assert_array_equal(view.display.scene.viewpoint.eye, eye)


def test_a_touch_is_drawn_where_it_is(view, skin, pressed):
    quiet = pixels(picture(view))
    view.display.show_frame(pressed)
    loud = pixels(picture(view))
    changed = np.abs(loud - quiet).max(axis=2) > 40
    near = np.zeros(changed.shape, dtype=bool)
    near[max(skin.y() - 12, 0) : skin.y() + 12, max(skin.x() - 12, 0) : skin.x() + 12] = True
    assert (changed & near).any()
    assert changed.mean() < 0.2


def test_frames_are_drawn_soon_and_only_when_something_changed(view, heard, pressed, qtbot):
    heard.drawn.clear()
    view.display.show_frame(pressed)
    assert heard.drawn == []  # not before the map had its turn
    qtbot.waitUntil(lambda: bool(heard.drawn) and not view.display._drawing.waiting)
    assert len(heard.drawn) in (1, 2)  # once live, and at rest once more where the machine is quick
    with qtbot.assertNotEmitted(view.display.drawn, wait=60):
        view.display.show_frame(pressed)


def test_a_hidden_view_draws_nothing_and_catches_up(view, pressed, qtbot):
    view.hide()
    with qtbot.assertNotEmitted(view.display.drawn, wait=60):
        view.display.show_frame(pressed)
    with qtbot.waitSignal(view.display.drawn):
        view.show()
    assert view.display.scene.shows(pressed)


def test_each_state_says_what_helps(empty, prepared, qtbot):
    button = empty.findChild(QPushButton)
    with qtbot.waitSignal(empty.card.open_requested):
        QTest.mouseClick(button, LEFT)
    empty.show_prepared(prepared)
    assert not button.isVisible()
    empty.card.show_loading("Flattening", 0.5)
    with qtbot.waitSignal(empty.card.cancel_requested):
        QTest.mouseClick(button, LEFT)
    empty.card.show_failed("The mesh has no surface.")
    with qtbot.waitSignal(empty.card.open_requested):
        QTest.mouseClick(button, LEFT)
    empty.card.show_last()
    assert not button.isVisible()


def test_without_a_robot_there_is_nothing_to_poke_or_find(empty, prepared):
    heard = Heard(empty)
    QTest.mouseClick(empty.display.canvas.widget, LEFT, NONE, QPoint(200, 200))
    empty.set_hover(prepared.skin.taxel_point(0))
    empty.card.show_last()
    assert heard.acts == []
    with pytest.raises(RobotError, match="no robot"):
        empty.display.pixel_of(prepared.skin.taxel_point(0))


def test_loading_ends_a_poke(view, heard, skin):
    QTest.mousePress(view.display.canvas.widget, LEFT, NONE, skin)
    view.card.show_loading("Flattening", 0.5)
    assert heard.kinds == ["pressed", "released"]
    QTest.mouseClick(view.display.canvas.widget, LEFT, NONE, skin)
    assert heard.kinds == ["pressed", "released"]


def test_replaying_has_an_edge_and_paused_a_word(view):
    live = picture(view)
    view.display.set_replaying(replaying=True)
    assert view.grab().toImage().pixelColor(1, 200) != live.pixelColor(1, 200)
    view.display.set_replaying(replaying=False)
    view.display.set_paused(paused=True)
    assert view.grab().toImage() != live
    view.display.set_paused(paused=False)
    assert view.grab().toImage() == live


def test_themes_scales_and_robots_change_while_it_is_open(view, prepared, pressed):
    view.show_prepared(prepared)  # no hover of a pointer that stands there by chance
    dark = picture(view)
    view.display.set_theme(LIGHT)
    assert picture(view).pixelColor(BESIDE).lightness() > 200
    view.display.set_theme(DARK)
    view.display.show_frame(pressed)
    touched = picture(view)
    view.display.set_scale(PressureScale(5.0))
    assert picture(view) != touched
    view.display.set_scale(PressureScale())
    view.show_prepared(prepared)
    assert picture(view) == dark
