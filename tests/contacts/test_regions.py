"""A contact region owns its arrays; touched taxels are gathered on the body and torn by seams on the map."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.centre_of_pressure import taxel_positions
from tactile_maps.contacts.detection.regions import ContactRegion, SeamCrossings, TaxelGraph, TaxelGroup
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tests.support.sensors import row
from tests.support.touch import arm


def test_it_owns_its_arrays():
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    point = np.zeros(3)
    region = ContactRegion(1, np.array([3, 4]), 2.0, 1e-4, 5e3, np.zeros(2), at, "bar", point, point)
    point[0] = 1
    assert region.link_position[0] == 0
    assert not region.taxels.flags.writeable
    assert not region.torn
    assert (region.partner, region.merged, region.split_from) == (None, (), None)
    assert region.link_axes.shape == (2, 3)
    assert region.map_axes.shape == (2, 2)


def test_groups_in_a_row():
    graph = TaxelGraph(row(10))
    assert graph.groups([]) == []
    assert graph.groups([2, 3, 7]) == [
        TaxelGroup(frozenset({2, 3}), frozenset({1, 4})),
        TaxelGroup(frozenset({7}), frozenset({6, 8})),
    ]


def test_a_taxel_between_two_groups_is_in_both_rings():
    one, other = TaxelGraph(row(5)).groups([1, 3])
    assert one.ring & other.ring == {2}


def test_a_lonely_taxel_has_no_ring():
    assert TaxelGraph(row(3, neighbours=[[0, 1]])).groups([2]) == [TaxelGroup(frozenset({2}), frozenset())]


def test_groups_are_the_connected_components_of_what_is_touched():
    skin = arm().skin
    random = np.random.default_rng(0)
    graph = TaxelGraph(skin)
    for share in (0.05, 0.3, 0.6):
        touched = np.flatnonzero(random.random(len(skin)) < share)
        groups = graph.groups(touched.tolist())
        assert sorted(taxel for group in groups for taxel in group.core) == touched.tolist()
        owner = {taxel: number for number, group in enumerate(groups) for taxel in group.core}
        for a, b in skin.neighbours.tolist():
            if a in owner and b in owner:
                assert owner[a] == owner[b]
            elif a in owner:
                assert b in groups[owner[a]].ring
        assert all(not group.ring & set(touched.tolist()) for group in groups)


def test_what_lies_on_both_sides_of_a_seam_is_torn():
    map_ = arm().map
    seams = SeamCrossings(map_, taxel_positions(map_.skin))
    assert len(seams.pairs)
    for a, b in seams.pairs.tolist():
        assert seams.tear(frozenset({a, b}))
        assert not seams.tear(frozenset({a}))
        assert not seams.tear(frozenset({b}))
    assert not seams.tear(frozenset())
