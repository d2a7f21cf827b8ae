"""Documents share what they did not change; the patch tree's names, visibility and order."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import LONGEST_NAME, MapDocument, rename_patch, reorder_patch, show_patches


def test_first_document_has_the_settings_of_the_map(document):
    assert [patch.method for patch in document.patches] == [chart.method for chart in document.charts]
    assert [patch.name for patch in document.patches] == [patch.name for patch in document.skin.patches]
    assert document.order == (0, 1, 2)
    assert all(patch.visible and not patch.pins for patch in document.patches)


def test_layout_edit_shares_all_charts_with_the_previous_document(document):
    moved = move(document, [1], (0.1, 0.0))
    assert all(a is b for a, b in zip(moved.charts, document.charts, strict=True))
    assert moved.skin is document.skin
    assert moved.map is not document.map


def test_tree_edit_shares_the_whole_map_with_the_previous_document(document):
    assert rename_patch(document, 0, "Forearm").map is document.map


def test_tree_with_patches_of_another_map_is_rejected(document):
    for change in ({"order": (0, 1)}, {"order": (0, 1, 1)}, {"patches": document.patches[:2]}):
        with pytest.raises(MapError, match="patch tree"):
            replace(document, **change)


def test_choosing_an_unknown_patch_is_rejected(document):
    assert document.chosen([2, 0, 2]) == [0, 2]
    for number in (-1, 3):
        with pytest.raises(MapError, match="unknown patch"):
            document.chosen([number])


def test_document_with_released_caches_keeps_its_fields_and_recomputes_caches(document):
    other = move(document, [1], (0.1, 0.0))
    before = other.map.taxel_points
    shared = document.charts[0].border
    assert "taxel_points" in vars(other.map)
    other.release_caches(document)
    assert set(vars(other.map)) == {"skin", "charts", "layout"}
    assert document.charts[0].border is shared, "what the present uses stays"
    assert (other.map.taxel_points == before).all()


def test_release_caches_keeps_values_of_the_shared_map(document):
    points = document.map.taxel_points
    document.release_caches(rename_patch(document, 0, "Forearm"))
    assert document.map.taxel_points is points


def test_documents_compare_by_identity(document):
    assert document != MapDocument.of(document.map)


def test_name_is_stored_without_surrounding_spaces(document):
    named = rename_patch(document, 1, "  Upper arm ")
    assert [patch.name for patch in named.patches][1] == "Upper arm"
    assert named.skin is document.skin
    assert rename_patch(named, 1, "Upper arm") is named


@pytest.mark.parametrize("name", ["", "   ", "two\nlines", "x" * (LONGEST_NAME + 1), "\ud800"])
def test_invalid_patch_name_is_rejected(document, name):
    with pytest.raises(MapError, match="not a valid patch name"):
        rename_patch(document, 0, name)


def test_patch_names_are_unique(document):
    with pytest.raises(MapError, match="another patch"):
        rename_patch(document, 0, document.patches[1].name)


def test_hiding_a_patch_does_not_change_the_map(document):
    hidden = show_patches(document, [0, 2], visible=False)
    assert [patch.visible for patch in hidden.patches] == [False, True, False]
    assert hidden.map is document.map
    assert show_patches(document, [0, 1]) is document


@pytest.mark.parametrize(("number", "to", "order"), [(0, 2, (1, 2, 0)), (2, 0, (2, 0, 1)), (1, 2, (0, 2, 1))])
def test_patch_can_be_moved_in_the_tree(document, number, to, order):
    assert reorder_patch(document, number, to).order == order
    assert reorder_patch(document, number, number) is document


def test_position_outside_the_list_is_rejected(document):
    for to in (-1, 3):
        with pytest.raises(MapError, match="invalid position"):
            reorder_patch(document, 0, to)
