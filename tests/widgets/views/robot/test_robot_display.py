"""Pictures of the robot view: fitted robot, frames drawn soon, nothing while it is hidden."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.views.robot.robot_view import _WHEEL_STEP
from tests.widgets.support.mouse import turn_wheel
from tests.widgets.support.robot_view_driver import BESIDE, picture, pressed_frame


@pytest.fixture
def pressed(prepared, view, skin):
    """A frame in which a finger has pressed for half a second at the skin pixel."""
    return pressed_frame(view, prepared, skin)


@pytest.mark.long
def test_pressed_pixel_has_the_colour_of_skin(view, skin):
    image = picture(view)
    colour = image.pixelColor(skin)
    assert min(colour.red(), colour.green(), colour.blue()) > 100
    assert image.pixelColor(BESIDE) != colour


def test_fitted_robot_stays_completely_visible_after_a_resize(view, prepared):
    view.resize(240, 500)
    taxels = range(0, len(prepared.skin), 10)
    places = [view.display.pixel_of(prepared.skin.taxel_point(taxel)) for taxel in taxels]
    assert all(0 < place.x() < 240 and 0 < place.y() < 500 for place in places)
    far = view.display.actors.viewpoint.distance
    turn_wheel(view.display.canvas.widget, notches=3)
    near = view.display.actors.viewpoint.distance
    assert near == pytest.approx(far / _WHEEL_STEP**3)
    assert near < far
    eye = view.display.actors.viewpoint.eye
    view.resize(480, 400)
    np.testing.assert_array_equal(view.display.actors.viewpoint.eye, eye)


@pytest.mark.long
def test_frames_are_drawn_soon_and_only_if_something_changed(view, heard, pressed, qtbot):
    heard.drawn.clear()
    view.display.show_frame(pressed)
    assert heard.drawn == []  # not before the map had its turn
    qtbot.waitUntil(lambda: bool(heard.drawn) and not view.display._drawing.waiting)
    assert len(heard.drawn) in (1, 2)  # once live, and at rest once more where the machine is quick
    with qtbot.assertNotEmitted(view.display.drawn, wait=60):
        view.display.show_frame(pressed)


@pytest.mark.long
def test_hidden_view_draws_the_newest_frame_when_shown(view, pressed, qtbot):
    view.hide()
    with qtbot.assertNotEmitted(view.display.drawn, wait=60):
        view.display.show_frame(pressed)
    with qtbot.waitSignal(view.display.drawn):
        view.show()
    assert view.display.actors.shows(pressed)
