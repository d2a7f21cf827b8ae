"""A contact region owns its arrays; touched taxels are gathered on the body and torn by seams on the map."""

from __future__ import annotations

import numpy as np

from tactile_maps.contacts.detection.regions import SeamCrossings, TaxelGraph
from tests.support.touch import arm


def test_groups_are_connected_components_of_touched_taxels():
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


def test_group_on_both_sides_of_a_seam_is_torn():
    map_ = arm().map
    seams = SeamCrossings(map_, map_.skin.positions)
    assert len(seams.pairs)
    for a, b in seams.pairs.tolist():
        assert seams.tear(frozenset({a, b}))
        assert not seams.tear(frozenset({a}))
        assert not seams.tear(frozenset({b}))
    assert not seams.tear(frozenset())
