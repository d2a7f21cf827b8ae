"""Selection of taxels shared by all views: effect of gestures, and colours of the selected taxels."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.taxel_selection import (
    REGION_COLOURS,
    TAXEL_COLOURS,
    SelectionUpdate,
    TaxelSelection,
    region_colour,
)


@pytest.fixture
def selection():
    selection = TaxelSelection()
    selection.reset(20)
    selection.heard = []
    selection.changed.connect(lambda: selection.heard.append(selection.taxels.tolist()))
    return selection


def take(selection, taxels, change=SelectionMode.REPLACE, *, begins=True):
    selection.take(SelectionUpdate(np.array(taxels, int), change, begins))
    return selection.taxels.tolist()


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (SelectionMode.REPLACE, [3, 4]),
        (SelectionMode.ADD, [2, 3, 4]),
        (SelectionMode.REMOVE, [2]),
        (SelectionMode.TOGGLE, [2, 4]),
    ],
)
def test_gesture_combines_with_the_previous_selection(selection, change, expected):
    take(selection, [2, 3])
    assert take(selection, [3, 4], change) == expected


def test_gesture_combines_with_the_selection_at_its_start(selection):
    take(selection, [1, 5])
    take(selection, [5], SelectionMode.TOGGLE)
    assert take(selection, [5, 6], SelectionMode.TOGGLE, begins=False) == [1, 6], "5 is toggled once, not twice"
    assert take(selection, [], SelectionMode.TOGGLE, begins=False) == [1, 5], "a box drawn small again gives back"
    selection.abandon()
    assert selection.taxels.tolist() == [1, 5]


def test_unchanged_selection_is_not_reported(selection):
    take(selection, [1])
    take(selection, [1])
    selection.clear()
    selection.clear()
    assert selection.heard == [[1], []]


def test_selection_can_be_cleared_inverted_and_set_to_all(selection):
    take(selection, [0, 19])
    selection.invert()
    assert selection.taxels.tolist() == list(range(1, 19))
    selection.select_all()
    assert selection.mask.all()
    selection.clear()
    assert not selection.mask.any()


def test_reset_clears_selection_and_gesture(selection):
    take(selection, [3])
    selection.select_region(7)
    selection.reset(4)
    assert selection.mask.tolist() == [False] * 4
    assert selection.region is None
    selection.abandon()
    assert selection.mask.tolist() == [False] * 4


def test_mask_is_read_only(selection):
    take(selection, [3])
    with pytest.raises(ValueError, match="read-only"):
        selection.mask[0] = True


def test_taxel_keeps_its_colour_while_others_change(selection):
    take(selection, [10])
    take(selection, [12], SelectionMode.ADD)
    assert selection.inks == TAXEL_COLOURS[:2]
    take(selection, [5], SelectionMode.ADD)
    assert dict(zip(selection.taxels.tolist(), selection.inks, strict=True)) == {
        5: TAXEL_COLOURS[2],
        10: TAXEL_COLOURS[0],
        12: TAXEL_COLOURS[1],
    }
    take(selection, [10], SelectionMode.REMOVE)
    take(selection, [19], SelectionMode.ADD)
    assert dict(zip(selection.taxels.tolist(), selection.inks, strict=True)) == {
        5: TAXEL_COLOURS[2],
        12: TAXEL_COLOURS[1],
        19: TAXEL_COLOURS[0],
    }


def test_few_taxels_have_different_colours_and_many_have_one(selection):
    take(selection, range(len(TAXEL_COLOURS)))
    assert len(set(selection.inks)) == len(TAXEL_COLOURS)
    take(selection, range(len(TAXEL_COLOURS) + 1))
    assert set(selection.inks) == {TAXEL_COLOURS[0]}
    take(selection, [3], SelectionMode.REMOVE)
    assert len(set(selection.inks)) == len(TAXEL_COLOURS)


def test_at_most_one_region_is_selected(selection):
    heard = []
    selection.region_changed.connect(heard.append)
    selection.select_region(3)
    selection.select_region(3)
    selection.forget_region(2)
    selection.forget_region(3)
    selection.select_region(4)
    selection.clear()
    assert heard == [3, None, 4, None]


def test_consecutive_regions_have_different_colours():
    inks = [region_colour(region) for region in range(1, len(REGION_COLOURS) + 1)]
    assert len(set(inks)) == len(REGION_COLOURS)
    assert region_colour(1) != TAXEL_COLOURS[0]
