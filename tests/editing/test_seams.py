"""Seams drawn, erased and proposed; areas of interest painted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.editing.seams import (
    SeamCutsPatch,
    SeamInInterest,
    draw_seam,
    erase_seams,
    extra_seams,
    paint_areas,
    paint_interest,
    propose_seam,
)
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.distortion import distortion
from tests.support.surfaces import named, skin_of

ROWS = 7  # vertices of a column of the sheet, which is 9 columns wide


def _vertex(column, row):
    return column * ROWS + row


def _done(document, asked):
    return apply_result(document, reflatten(asked))


def _pairs(edges):
    return {tuple(edge) for edge in np.sort(edges, axis=1).tolist()}


def test_drawn_seam_is_cut(document):
    asked = draw_seam(document, 1, [_vertex(4, 0), _vertex(4, 4)])
    new = _done(document, asked)
    expected = {(_vertex(4, k), _vertex(4, k + 1)) for k in range(4)}
    assert _pairs(new.charts[1].seams) == expected
    assert len(new.charts[1].vertex_of) == len(document.charts[1].vertex_of) + 4
    assert not len(document.charts[1].seams)


def test_second_seam_is_added_to_the_first(document):
    new = _done(document, draw_seam(document, 1, [_vertex(2, 0), _vertex(2, 3)]))
    new = _done(new, draw_seam(new, 1, [_vertex(6, 6), _vertex(6, 3)]))
    assert len(new.charts[1].seams) == 6


def test_seam_that_would_cut_the_patch_in_two_is_rejected(document):
    with pytest.raises(SeamCutsPatch, match="in two"):
        draw_seam(document, 1, [_vertex(4, 0), _vertex(4, 6)])
    half = _done(document, draw_seam(document, 1, [_vertex(4, 0), _vertex(4, 3)]))
    with pytest.raises(SeamCutsPatch):
        draw_seam(half, 1, [_vertex(4, 6), _vertex(4, 3)])
    with pytest.raises(SeamCutsPatch):
        draw_seam(document, 1, [_vertex(*c) for c in ((2, 2), (5, 2), (5, 4), (2, 4), (2, 2))])


def test_erasing_an_edge_without_seam_is_rejected(document):
    for through in ([_vertex(4, 0)], [], [3, 3]):
        with pytest.raises(MapError, match="two ends"):
            draw_seam(document, 1, through)
    for vertex in (-1, 10_000):
        with pytest.raises(MapError, match="no such vertex") as error:
            draw_seam(document, 1, [0, vertex])
        assert error.value.value == vertex
    with pytest.raises(MapError, match="unknown patch"):
        draw_seam(document, 9, [0, 1])


def test_erased_seam_is_closed_and_others_remain(document):
    new = _done(document, draw_seam(document, 1, [_vertex(2, 0), _vertex(2, 3)]))
    new = _done(new, draw_seam(new, 1, [_vertex(6, 6), _vertex(6, 3)]))
    first = [(_vertex(2, k), _vertex(2, k + 1)) for k in range(3)]
    left = _done(new, erase_seams(new, 1, np.array(first)[:, ::-1]))
    assert _pairs(left.charts[1].seams) == _pairs(new.charts[1].seams) - set(first)
    back = _done(left, erase_seams(left, 1, left.charts[1].seams))
    np.testing.assert_allclose(back.charts[1].plane, document.charts[1].plane, atol=1e-12)


def test_tube_keeps_one_seam_with_a_finding(document):
    new = _done(document, erase_seams(document, 0, document.charts[0].seams))
    assert len(new.charts[0].seams) == len(document.charts[0].seams)
    assert [found.kind for found in new.charts[0].findings] == ["seam-needed"]


def test_only_seams_can_be_erased(document):
    for edges in ([[_vertex(1, 1), _vertex(1, 2)]], np.zeros((0, 2), dtype=int)):
        with pytest.raises(MapError, match="no seam to erase"):
            erase_seams(document, 1, edges)


@pytest.fixture(scope="module")
def deep():
    return MapDocument.of(build_map(skin_of(named("nearly closed"))))


@pytest.mark.long
def test_proposal_has_a_gain_and_is_accepted_unchanged(deep):
    before = extra_seams(deep, 0)
    assert before == sum(found.count for found in deep.charts[0].findings if found.kind == "seam-added") > 0
    shown = reflatten(propose_seam(deep, 0))
    new = apply_result(deep, shown)
    assert extra_seams(new, 0) == before + 1
    energies = [distortion(document.map).mean_energy for document in (deep, new)]
    assert shown.gains[0] == pytest.approx(energies[0] - energies[1], rel=0.2)
    assert shown.gains[0] > 0


def test_seam_goes_around_an_area_of_interest(document):
    inside = [_vertex(column, row) for column in (3, 4, 5) for row in (0, 1, 2, 3)]
    painted = _done(document, paint_interest(document, 1, inside))
    drawn = draw_seam(painted, 1, [_vertex(2, 0), _vertex(6, 1)]).jobs[0].edit.seams.drawn
    assert not set(drawn.ravel().tolist()) & set(inside)
    with pytest.raises(SeamInInterest, match="area of interest"):
        draw_seam(painted, 1, [_vertex(4, 0), _vertex(4, 3)])
    clear = _done(painted, paint_interest(painted, 1, inside, importance=0.0))
    assert clear.patches[1].seams.importance is None
    assert len(draw_seam(clear, 1, [_vertex(4, 0), _vertex(4, 3)]).jobs) == 1


def test_tube_is_cut_outside_the_area_of_interest(document):
    along = np.unique(document.charts[0].seams)
    new = _done(document, paint_interest(document, 0, along))
    assert not set(new.charts[0].seams.ravel().tolist()) & set(along.tolist())
    whole = _done(document, paint_interest(document, 0, range(len(document.skin.patches[0].surface.vertices))))
    assert [found.kind for found in whole.charts[0].findings] == ["seam-in-interest"]


def test_invalid_area_of_interest_is_rejected(document):
    for vertices in ([-1], [10_000]):
        with pytest.raises(MapError, match="no such vertex"):
            paint_interest(document, 1, vertices)
    with pytest.raises(MapError, match="negative or not finite"):
        paint_interest(document, 1, [1], importance=np.nan)
    assert paint_interest(document, 1, []).jobs == ()


def test_proposals_start_from_the_plan_of_the_user(document):
    planned = document.with_patch(1, replace(document.patches[1], seams=replace(document.patches[1].seams, extra=2)))
    assert extra_seams(planned, 1) == 2
    assert propose_seam(planned, 1).jobs[0].edit.seams.extra == 3


def test_areas_of_several_patches_are_painted_in_one_step(document):
    asked = paint_areas(document, {0: [3, 4], 1: [_vertex(4, 3)]})
    assert asked.name == paint_interest(document, 0, [3]).name
    new = _done(document, asked)
    painted = [patch.seams.importance for patch in new.patches]
    assert [None if values is None else np.flatnonzero(values).tolist() for values in painted] == [
        [3, 4],
        [_vertex(4, 3)],
        None,
    ]
    erased = _done(new, paint_areas(new, {0: [3, 4]}, importance=0.0))
    assert erased.patches[0].seams.importance is None
    assert paint_areas(document, {}).jobs == ()
