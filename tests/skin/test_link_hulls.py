"""The hulls of links with skin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import Finding
from tactile_maps.robots.files.mesh_files import box_mesh
from tactile_maps.robots.model.mujoco_spec import compile_spec
from tactile_maps.skin.link_hulls import hull_name, hull_points, hulls_spec, skinned_links
from tactile_maps.skin.model.skin import PLACEHOLDER_COVERED
from tests.support.touch import arm, pair


def test_hull_points_are_links_and_skins():
    robot, skin = pair()
    assert len(hull_points(robot, skin, "left")) == len(skin.patches[0].surface.vertices) + 8


def lost(covered):
    """Two blocks with flat skin; a placeholder is in place of the left one, and is covered where stated."""
    robot, skin = pair()
    left = replace(robot.links[0], mesh=box_mesh(0.02), missing=("block",))
    notes = (Finding(PLACEHOLDER_COVERED, "left", "covered"), Finding("other", "left", "noticed"))
    return replace(robot, links=(left, robot.links[1])), replace(skin, findings=notes[not covered :])


def test_the_placeholder_of_a_missing_mesh_is_in_no_hull_unless_it_is_covered():
    bare, covered = (hull_points(*lost(covered=covered), "left")[:, 0].min() for covered in (False, True))
    assert covered == -0.01
    assert bare == pytest.approx(0.05 - 0.003), "a plate under the skin at 0.05"
    robot, skin = lost(covered=True)
    other = replace(skin.findings[0], where="right")
    assert hull_points(robot, replace(skin, findings=(other,)), "left")[:, 0].min() > 0, "another link is covered"


def test_flat_skin_alone_has_a_hull():
    robot, skin = lost(covered=False)
    compile_spec(hulls_spec(robot, skin), source=robot.source)


def test_hulls_collide_in_place_of_the_shapes_of_skinned_links():
    robot = arm().robot
    skin = arm().skin
    model = compile_spec(hulls_spec(robot, skin), source=robot.source)
    solid = [int(geom) for geom in np.flatnonzero(model.geom_contype)]
    of_skinned = {model.geom(g).name for g in solid if model.body(model.geom_bodyid[g]).name in skinned_links(skin)}
    assert of_skinned == {hull_name(link) for link in skinned_links(skin)}
    assert {model.body(model.geom_bodyid[g]).name for g in solid} == {link.name for link in robot.links}
