"""A document shares what an edit did not change."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.editing.arrange import move
from app.editing.document import MapDocument
from app.editing.patches import rename
from app.errors import MapError


def test_a_first_document_wants_what_the_map_is(document):
    assert [patch.method for patch in document.patches] == [chart.method for chart in document.charts]
    assert [patch.name for patch in document.patches] == [patch.name for patch in document.skin.patches]
    assert document.order == (0, 1, 2)
    assert all(patch.visible and not patch.pins for patch in document.patches)


def test_an_edit_of_the_layout_shares_every_chart(document):
    moved = move(document, [1], (0.1, 0.0))
    assert all(a is b for a, b in zip(moved.charts, document.charts, strict=True))
    assert moved.skin is document.skin
    assert moved.map is not document.map


def test_an_edit_of_the_tree_shares_the_whole_map(document):
    assert rename(document, 0, "Forearm").map is document.map


def test_a_tree_of_other_patches_is_refused(document):
    for change in ({"order": (0, 1)}, {"order": (0, 1, 1)}, {"patches": document.patches[:2]}):
        with pytest.raises(MapError, match="patch tree"):
            replace(document, **change)


def test_only_patches_that_exist_can_be_chosen(document):
    assert document.chosen([2, 0, 2]) == [0, 2]
    for number in (-1, 3):
        with pytest.raises(MapError, match="no such patch"):
            document.chosen([number])


def test_a_resting_document_keeps_its_fields_and_computes_the_rest_again(document):
    other = move(document, [1], (0.1, 0.0))
    before = other.map.taxel_points
    shared = document.charts[0].border
    assert "taxel_points" in vars(other.map)
    other.rest(document)
    assert set(vars(other.map)) == {"skin", "charts", "layout"}
    assert document.charts[0].border is shared, "what the present uses stays"
    assert (other.map.taxel_points == before).all()


def test_resting_beside_itself_forgets_nothing(document):
    points = document.map.taxel_points
    document.rest(rename(document, 0, "Forearm"))
    assert document.map.taxel_points is points


def test_documents_compare_by_who_they_are(document):
    assert document != MapDocument.of(document.map)
