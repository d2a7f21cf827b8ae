"""The hand on the map: what each press, move and release means."""

from __future__ import annotations

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.views.interaction.poke_gesture import Moved, Panned, PokeGesture, PokeState, Pressed, Released

HERE = SurfacePoint(0, 3, (0.2, 0.3, 0.5))
THERE = SurfacePoint(0, 4, (0.2, 0.3, 0.5))


def test_press_stroke_release():
    hand = PokeGesture()
    assert hand.press((1, 1), HERE) == Pressed(HERE)
    assert hand.mode is PokeState.POKING
    assert hand.move((2, 1), THERE) == Moved(THERE)
    assert hand.release() == Released()
    assert hand.mode is PokeState.IDLE


def test_a_stroke_off_the_patches_stays_at_its_last_point():
    hand = PokeGesture()
    hand.press((1, 1), HERE)
    assert hand.move((9, 9), None) is None
    assert hand.move((9, 9), HERE) is None
    assert hand.move((8, 8), THERE) == Moved(THERE)


def test_a_press_beside_the_patches_pans():
    hand = PokeGesture()
    assert hand.press((5, 5), None) is None
    assert hand.move((8, 3), HERE) == Panned(3, -2)
    assert hand.move((9, 3), HERE) == Panned(1, 0)
    assert hand.release() is None


def test_panning_can_be_asked_for_on_a_patch():
    hand = PokeGesture()
    assert hand.press((5, 5), HERE, pan=True) is None
    assert hand.mode is PokeState.PANNING


def test_only_the_button_that_began_ends():
    hand = PokeGesture()
    hand.press((1, 1), HERE, button="left")
    assert hand.press((1, 1), HERE, button="middle", pan=True) is None
    assert hand.release("middle") is None
    assert hand.mode is PokeState.POKING
    assert hand.release("left") == Released()


def test_cancel_ends_everything_once():
    hand = PokeGesture()
    hand.press((1, 1), HERE)
    assert hand.cancel() == Released()
    assert hand.cancel() is None
    assert hand.move((2, 2), THERE) is None
    assert hand.release() is None
