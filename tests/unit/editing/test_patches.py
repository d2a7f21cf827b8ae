"""Names, visibility and order of the patch tree."""

from __future__ import annotations

import pytest

from app.editing.patches import LONGEST, rename, reorder, show
from app.errors import MapError


def test_a_name_is_given_without_its_spaces(document):
    named = rename(document, 1, "  Upper arm ")
    assert [patch.name for patch in named.patches][1] == "Upper arm"
    assert named.skin is document.skin
    assert rename(named, 1, "Upper arm") is named


@pytest.mark.parametrize("name", ["", "   ", "two\nlines", "x" * (LONGEST + 1), "\ud800"])
def test_what_is_no_name_is_refused(document, name):
    with pytest.raises(MapError, match="no name"):
        rename(document, 0, name)


def test_no_two_patches_have_one_name(document):
    with pytest.raises(MapError, match="another patch"):
        rename(document, 0, document.patches[1].name)


def test_hiding_changes_no_map(document):
    hidden = show(document, [0, 2], visible=False)
    assert [patch.visible for patch in hidden.patches] == [False, True, False]
    assert hidden.map is document.map
    assert show(document, [0, 1]) is document


@pytest.mark.parametrize(("number", "to", "order"), [(0, 2, (1, 2, 0)), (2, 0, (2, 0, 1)), (1, 2, (0, 2, 1))])
def test_a_patch_moves_in_the_tree(document, number, to, order):
    assert reorder(document, number, to).order == order
    assert reorder(document, number, number) is document


def test_there_is_no_place_outside_the_tree(document):
    for to in (-1, 3):
        with pytest.raises(MapError, match="no such place"):
            reorder(document, 0, to)
