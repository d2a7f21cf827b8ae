"""One selection for every view: what gestures make of it, and which colours its taxels keep."""

from __future__ import annotations

import numpy as np
import pytest

from widgets.selection import INKS, REGION_INKS, Choice, Selection, region_ink
from widgets.tools import Change


@pytest.fixture
def selection():
    selection = Selection()
    selection.reset(20)
    selection.heard = []
    selection.changed.connect(lambda: selection.heard.append(selection.taxels.tolist()))
    return selection


def take(selection, taxels, change=Change.REPLACE, *, begins=True):
    selection.take(Choice(np.array(taxels, int), change, begins))
    return selection.taxels.tolist()


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (Change.REPLACE, [3, 4]),
        (Change.ADD, [2, 3, 4]),
        (Change.REMOVE, [2]),
        (Change.TOGGLE, [2, 4]),
    ],
)
def test_what_a_gesture_does_to_those_selected_before(selection, change, expected):
    take(selection, [2, 3])
    assert take(selection, [3, 4], change) == expected


def test_a_gesture_that_goes_on_counts_from_where_it_began(selection):
    take(selection, [1, 5])
    take(selection, [5], Change.TOGGLE)
    assert take(selection, [5, 6], Change.TOGGLE, begins=False) == [1, 6], "5 is toggled once, not twice"
    assert take(selection, [], Change.TOGGLE, begins=False) == [1, 5], "a box drawn small again gives back"
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
    take(selection, [12], Change.ADD)
    assert selection.inks == INKS[:2]
    take(selection, [5], Change.ADD)
    assert dict(zip(selection.taxels.tolist(), selection.inks, strict=True)) == {5: INKS[2], 10: INKS[0], 12: INKS[1]}
    take(selection, [10], Change.REMOVE)
    take(selection, [19], Change.ADD)
    assert dict(zip(selection.taxels.tolist(), selection.inks, strict=True)) == {5: INKS[2], 12: INKS[1], 19: INKS[0]}


def test_few_have_different_inks_and_many_one(selection):
    take(selection, range(len(INKS)))
    assert len(set(selection.inks)) == len(INKS)
    take(selection, range(len(INKS) + 1))
    assert set(selection.inks) == {INKS[0]}
    take(selection, [3], Change.REMOVE)
    assert len(set(selection.inks)) == len(INKS)


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
    inks = [region_ink(region) for region in range(1, len(REGION_INKS) + 1)]
    assert len(set(inks)) == len(REGION_INKS)
    assert region_ink(1) != INKS[0]
