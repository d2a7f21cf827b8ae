"""Groups of touched taxels and their rings; what a seam tears."""

from __future__ import annotations

import numpy as np

from app.contacts.graph import Group, Seams, SkinGraph
from app.contacts.place import body_of
from tests.sensors import row
from tests.touch import arm


def test_groups_in_a_row():
    graph = SkinGraph(row(10))
    assert graph.groups([]) == []
    assert graph.groups([2, 3, 7]) == [
        Group(frozenset({2, 3}), frozenset({1, 4})),
        Group(frozenset({7}), frozenset({6, 8})),
    ]


def test_a_taxel_between_two_groups_is_in_both_rings():
    one, other = SkinGraph(row(5)).groups([1, 3])
    assert one.ring & other.ring == {2}


def test_a_lonely_taxel_has_no_ring():
    assert SkinGraph(row(3, neighbours=[[0, 1]])).groups([2]) == [Group(frozenset({2}), frozenset())]


def test_groups_are_the_connected_components_of_what_is_touched():
    skin, random = arm().skin, np.random.default_rng(0)
    graph = SkinGraph(skin)
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
    seams = Seams(map_, body_of(map_.skin))
    assert len(seams.pairs)
    for a, b in seams.pairs.tolist():
        assert seams.tear(frozenset({a, b}))
        assert not seams.tear(frozenset({a}))
        assert not seams.tear(frozenset({b}))
    assert not seams.tear(frozenset())
