"""The shapes with which skinned links collide, and which links never do."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from app.robots.mujoco_spec import compile_spec
from app.skin.link_hulls import collision_spec, excluded_pairs, hull_name, hull_points, skinned_links
from tests.support.touch import arm, pair


def test_hull_points_are_links_and_skins():
    robot, skin = pair()
    assert len(hull_points(robot, skin, "left")) == len(skin.patches[0].surface.vertices) + 8


def test_neighbours_never_touch():
    robot, skin = arm().robot, arm().skin
    names = [link.name for link in robot.links]
    apart = excluded_pairs(robot, skin)
    assert all(frozenset(two) in apart for two in pairwise(names))
    assert frozenset((names[0], names[-1])) not in apart
    assert excluded_pairs(robot, skin) is apart, "asked once"


def test_hulls_collide_in_place_of_the_shapes_of_skinned_links():
    robot, skin = arm().robot, arm().skin
    model = compile_spec(collision_spec(robot, skin), source=robot.source)
    solid = [int(geom) for geom in np.flatnonzero(model.geom_contype)]
    of_skinned = {model.geom(g).name for g in solid if model.body(model.geom_bodyid[g]).name in skinned_links(skin)}
    assert of_skinned == {hull_name(link) for link in skinned_links(skin)}
    assert {model.body(model.geom_bodyid[g]).name for g in solid} == {link.name for link in robot.links}
