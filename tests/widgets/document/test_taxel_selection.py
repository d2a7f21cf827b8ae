"""One selection for every view: what gestures make of it, and which colours its taxels keep."""

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
def test_what_a_gesture_does_to_those_selected_before(selection, change, expected):
    take(selection, [2, 3])
    assert take(selection, [3, 4], change) == expected


def test_a_gesture_that_goes_on_counts_from_where_it_began(selection):
    take(selection, [1, 5])
    take(selection, [5], SelectionMode.TOGGLE)
    assert take(selection, [5, 6], SelectionMode.TOGGLE, begins=False) == [1, 6], "5 is toggled once, not twice"
    assert take(selection, [], SelectionMode.TOGGLE, begins=False) == [1, 5], "a box drawn small again gives back"
    selection.abandon()
    assert selection.taxels.tolist() == [1, 5]


def test_it_tells_only_what_changes(selection):
    take(selection, [1])
    take(selection, [1])
    selection.clear()
    selection.clear()
    assert selection.heard == [[1], []]


def test_all_none_and_inverse(selection):
    take(selection, [0, 19])
    selection.invert()
    assert selection.taxels.tolist() == list(range(1, 19))
    selection.select_all()
    assert selection.mask.all()
    selection.clear()
    assert not selection.mask.any()


def test_another_skin_has_nothing_selected_and_nothing_to_go_back_to(selection):
    take(selection, [3])
    selection.select_region(7)
    selection.reset(4)
    assert selection.mask.tolist() == [False] * 4
    assert selection.region is None
    selection.abandon()
    assert selection.mask.tolist() == [False] * 4


def test_the_set_can_not_be_written_into(selection):
    take(selection, [3])
    with pytest.raises(ValueError, match="read-only"):
        selection.mask[0] = True


def test_a_taxel_keeps_its_ink_while_others_come_and_go(selection):
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


def test_few_have_different_inks_and_many_one(selection):
    take(selection, range(len(TAXEL_COLOURS)))
    assert len(set(selection.inks)) == len(TAXEL_COLOURS)
    take(selection, range(len(TAXEL_COLOURS) + 1))
    assert set(selection.inks) == {TAXEL_COLOURS[0]}
    take(selection, [3], SelectionMode.REMOVE)
    assert len(set(selection.inks)) == len(TAXEL_COLOURS)


def test_one_region_is_selected_or_none(selection):
    heard = []
    selection.region_changed.connect(heard.append)
    selection.select_region(3)
    selection.select_region(3)
    selection.forget_region(2)
    selection.forget_region(3)
    selection.select_region(4)
    selection.clear()
    assert heard == [3, None, 4, None]


def test_regions_that_follow_each_other_differ():
    inks = [region_colour(region) for region in range(1, len(REGION_COLOURS) + 1)]
    assert len(set(inks)) == len(REGION_COLOURS)
    assert region_colour(1) != TAXEL_COLOURS[0]
