"""Transitions continue the map over a seam like the surface of the body."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.seam_transitions import SeamTransitions, line_crossing
from tactile_maps.maps.model.tactile_map import TactileMap
from tests.support.references import unrolled
from tests.support.surfaces import frustum

TUBES = {
    "tube": lambda: frustum(0.03, 0.03, length=0.1, around=30, along=12),
    "cone": lambda: frustum(0.05, 0.02, length=0.1, around=30, along=12),
}


@pytest.fixture(scope="module", params=sorted(TUBES))
def rolled(request):
    return unrolled(TUBES[request.param](), taxels=60, angle=0.7)


def across(borders, segment, points):
    """Return points (k, 2) beyond segments (k,) behind the other side of their seams."""
    return np.einsum("kij,kj->ki", borders.linear[segment], points) + borders.offset[segment]


def test_every_seam_segment_has_a_partner_and_true_borders_have_none(three_patches):
    borders = SeamTransitions(three_patches).borders
    glued = np.flatnonzero(borders.partner >= 0)
    np.testing.assert_array_equal(borders.partner[borders.partner[glued]], glued)
    assert len(glued) == 2 * sum(len(chart.seams) for chart in three_patches.charts) > 0
    assert borders.turned[glued].all()
    assert not borders.turned[borders.partner < 0].any()
    for segment in glued:
        chart = three_patches.charts[borders.patch[segment]]
        surface = three_patches.skin.patches[borders.patch[segment]]
        corner = [int(borders.side[segment]), (int(borders.side[segment]) + 1) % 3]
        edge = surface.surface.faces[borders.face[segment], corner]
        assert np.sort(edge).tolist() in np.sort(chart.seams, axis=1).tolist()


def test_transition_maps_an_edge_onto_its_partner(three_patches):
    borders = SeamTransitions(three_patches).borders
    glued = np.flatnonzero(borders.partner >= 0)
    for end in (0, 1):
        met = across(borders, glued, borders.ends[glued, end])
        np.testing.assert_allclose(met, borders.ends[borders.partner[glued], 1 - end], atol=1e-15)


def test_transition_and_its_inverse_cancel(three_patches):
    borders = SeamTransitions(three_patches).borders
    glued = np.flatnonzero(borders.partner >= 0)
    points = np.random.default_rng(0).normal(size=(len(glued), 2))
    back = across(borders, borders.partner[glued], across(borders, glued, points))
    np.testing.assert_allclose(back, points, atol=1e-12)


def test_transition_of_an_unstretched_map_is_a_rotation(rolled):
    borders = SeamTransitions(rolled).borders
    turns = borders.linear[borders.partner >= 0]
    assert len(turns) == 2 * 12
    np.testing.assert_allclose(np.einsum("kij,klj->kil", turns, turns), np.tile(np.eye(2), (24, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(np.linalg.det(turns), 1, atol=1e-9)


def test_stretched_map_keeps_directions_on_the_body(rolled):
    """Stretching the map by a matrix must change each transition A to S A S⁻¹."""
    stretch = np.array([[1.4, 0.3], [0.0, 0.8]])
    (chart,) = rolled.charts
    plain = TactileMap(rolled.skin, rolled.charts, MapLayout((Placement(),)))
    changed = TactileMap(
        rolled.skin,
        (type(chart)(chart.faces, chart.plane @ stretch.T, chart.vertex_of, chart.seams, ""),),
        MapLayout((Placement(),)),
    )
    expected = stretch @ SeamTransitions(plain).borders.linear @ np.linalg.inv(stretch)
    np.testing.assert_allclose(SeamTransitions(changed).borders.linear, expected, atol=1e-9)


def test_crossings_of_lines_are_found():
    s, t = line_crossing(np.zeros(2), np.array([2.0, 0]), np.array([[[1, -1], [1, 3]], [[0, 1], [5, 1]]], dtype=float))
    assert (s[0], t[0]) == (0.5, 0.25)
    assert np.isnan(s[1])
