"""The hand that chooses: clicks pick, drags sweep, and a press that moved is never a pick."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.common.tool_kinds import (
    BRUSH,
    LARGEST_BRUSH,
    SELECT_BOX,
    SELECT_BRUSH,
    SELECT_LASSO,
    SMALLEST_BRUSH,
    SelectionMode,
    resized_brush,
)
from tactile_widgets.views.interaction.select_gesture import (
    CLICK_PX,
    Picked,
    SelectGesture,
    Swept,
    points_in_polygon,
    points_near_segment,
)

SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
PLAIN = SelectionMode.REPLACE
ADD = SelectionMode.ADD


@pytest.fixture
def hand():
    return SelectGesture()


def held(tool):
    hand = SelectGesture()
    hand.tool = tool
    return hand


def test_a_press_and_release_in_place_picks(hand):
    assert hand.press((5, 5), PLAIN) is None
    assert hand.busy
    assert hand.move((5 + CLICK_PX, 5)) is None, "a hand trembles"
    assert hand.release() == Picked((5, 5), PLAIN)
    assert not hand.busy


@pytest.mark.parametrize("tool", [SELECT_BOX, SELECT_LASSO, SELECT_BRUSH])
def test_a_press_that_moved_is_never_a_pick_even_if_it_came_back(tool):
    hand = held(tool)
    hand.press((5, 5), PLAIN)
    assert isinstance(hand.move((30, 5)), Swept)
    hand.move((5, 5))
    assert hand.release() is None


@pytest.mark.parametrize(
    ("pressed", "released"),
    [(ADD, SelectionMode.TOGGLE), (SelectionMode.REMOVE, SelectionMode.REMOVE), (PLAIN, PLAIN)],
)
def test_a_click_that_adds_takes_out_what_is_in(hand, pressed, released):
    hand.press((1, 1), pressed)
    assert hand.release() == Picked((1, 1), released)


def test_a_box_spans_from_press_to_pointer_and_only_its_first_act_begins(hand):
    hand.press((10, 20), ADD)
    first = hand.move((40, 60))
    second = hand.move((5, 30))
    assert (first.begins, second.begins) == (True, False)
    assert first.change is second.change is ADD
    assert first.line.tolist() == [[10, 20], [40, 20], [40, 60], [10, 60]]
    assert second.line.tolist() == hand.outline.tolist() == [[10, 20], [5, 20], [5, 30], [10, 30]]


def test_a_lasso_follows_the_hand():
    hand = held(SELECT_LASSO)
    hand.press((0, 0), PLAIN)
    for place in ((10, 0), (10.5, 0), (10, 10)):
        act = hand.move(place)
    assert act.line.tolist() == hand.outline.tolist() == [[0, 0], [10, 0], [10, 10]], "steps below two pixels are none"


def test_a_brush_chooses_from_the_press_on_and_sweeps_stretch_by_stretch():
    hand = held(SELECT_BRUSH)
    dab = hand.press((3, 3), PLAIN)
    assert dab.begins
    assert dab.line.tolist() == [[3, 3], [3, 3]]
    assert hand.move((9, 3)).line.tolist() == [[3, 3], [9, 3]]
    assert hand.move((9, 8)).line.tolist() == [[9, 3], [9, 8]]
    assert hand.outline is None
    assert hand.release() is None


def test_only_the_button_that_began_the_hold_ends_it(hand):
    hand.press((5, 5), PLAIN, button="left")
    assert hand.press((9, 9), ADD, button="right") is None
    assert hand.release(button="right") is None
    assert hand.busy
    assert hand.release(button="left") == Picked((5, 5), PLAIN)
    assert hand.release(button="left") is None


def test_giving_up_says_whether_anything_was_drawn(hand):
    assert hand.cancel() is False
    hand.press((5, 5), PLAIN)
    assert hand.cancel() is False
    assert hand.release() is None, "a press given up is no click"
    hand.press((5, 5), PLAIN)
    hand.move((50, 50))
    assert hand.cancel() is True
    assert hand.outline is None
    assert hand.move((60, 60)) is None


@pytest.mark.parametrize("turn", [1, -1])
def test_inside_a_square_whichever_way_round(turn):
    points = np.array([[5, 5], [-1, 5], [11, 5], [5, -1], [5, 11], [np.nan, 5], [5, np.nan]])
    assert points_in_polygon(SQUARE[::turn], points).tolist() == [True] + 6 * [False]


def test_a_lasso_that_crosses_itself_encloses_by_the_even_odd_rule():
    star = np.array([[np.sin(4 * np.pi * k / 5), np.cos(4 * np.pi * k / 5)] for k in range(5)])
    tips = 0.8 * star
    assert not points_in_polygon(star, np.zeros((1, 2)))[0]
    assert points_in_polygon(star, tips).all()


def test_inside_agrees_with_winding_for_random_simple_outlines():
    rng = np.random.default_rng(3)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 60))
    reach = rng.uniform(0.5, 1.5, 60)
    outline = reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = rng.uniform(-1.6, 1.6, (400, 2))
    corner = outline[None] - points[:, None]
    following = np.roll(corner, -1, axis=1)
    cross = corner[..., 0] * following[..., 1] - corner[..., 1] * following[..., 0]
    turned = np.arctan2(cross, (corner * following).sum(axis=2)).sum(axis=1)
    around = np.abs(turned) > np.pi
    assert 50 < around.sum() < 350
    np.testing.assert_array_equal(points_in_polygon(outline, points), around)


def test_an_outline_without_area_encloses_nothing():
    points = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
    assert not points_in_polygon(np.array([[1.0, 1.0]]), points).any()
    assert not points_in_polygon(np.array([[0.0, 1.0], [3.0, 1.0]]), points).any()


def test_near_a_stretch_and_its_ends():
    stretch = np.array([[0.0, 0.0], [10.0, 0.0]])
    points = np.array([[5, 2.9], [5, 3.1], [-2.9, 0], [-3.1, 0], [12, 2], [12.5, 2.5], [np.nan, 0]])
    assert points_near_segment(stretch, points, 3.0).tolist() == [True, False, True, False, True, False, False]
    assert points_near_segment(stretch[[0, 0]], points, 3.0).tolist() == [
        False,
        False,
        True,
        False,
        False,
        False,
        False,
    ]


def test_brushes_grow_and_shrink_in_steps_within_limits():
    assert resized_brush(BRUSH, 1) > BRUSH > resized_brush(BRUSH, -1)
    assert resized_brush(resized_brush(BRUSH, 1), -1) == pytest.approx(BRUSH)
    assert resized_brush(BRUSH, 99) == LARGEST_BRUSH
    assert resized_brush(BRUSH, -99) == SMALLEST_BRUSH
