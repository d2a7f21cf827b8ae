"""The shapes with which links collide, and the pairs of links that never do."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import mujoco
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.model.mujoco_spec import TOUCHING
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.skin.collision_shapes import excluded_pairs
from tactile_maps.skin.link_hulls import overlapping_hulls
from tests.support.hollows import bowl_and_ball
from tests.support.touch import arm

BOTH = frozenset(("block", "ball"))


def test_adjacent_links_never_collide():
    robot = arm().robot
    skin = arm().skin
    names = [link.name for link in robot.links]
    apart = excluded_pairs(robot, skin)
    assert all(frozenset(two) in apart for two in pairwise(names))
    assert frozenset((names[0], names[-1])) not in apart
    assert excluded_pairs(robot, skin) is apart, "computed once"


@pytest.mark.long
@pytest.mark.parametrize(
    ("height", "hulls", "shapes"),
    [
        (0.03, False, False),  # above the lid of the bowl
        (0.005, True, False),  # below the lid, above the bowl
        (-0.004, True, True),  # 2 mm deep in the bowl
        (-0.015, True, True),
    ],
)
def test_links_whose_collision_shapes_touch_at_home_never_collide(height, hulls, shapes):
    robot, skin = bowl_and_ball(height)
    assert (BOTH in overlapping_hulls(robot, skin)[1]) is hulls
    assert (BOTH in excluded_pairs(robot, skin)) is shapes


def excluding(robot, name=""):
    """Return the robot with its two links excluded from collisions with each other."""
    exclude = f'<contact><exclude name="{name}" body1="block" body2="ball"/></contact></mujoco>'
    return replace(robot, mjcf=robot.mjcf.replace("</mujoco>", exclude))


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("height", "overlaps"), [pytest.param(0.03, False, marks=pytest.mark.long), (0.005, False), (-0.004, True)]
)
def test_pairs_excluded_at_loading_are_reconsidered_with_the_collision_shapes(height, overlaps):
    """Shapes of the model, which loading uses, may overlap where the skins do not."""
    robot, skin = bowl_and_ball(height)
    found = excluding(robot, f"{TOUCHING}block ball")
    effects = Effects(contact="self")
    assert (BOTH in excluded_pairs(found, skin)) is overlaps
    assert BOTH in excluded_pairs(excluding(robot), skin), "as the file of the robot states"
    model = assemble(found, skin, effects)
    assert model.nexclude == overlaps
    data = mujoco.MjData(model)
    data.qpos[0] = -0.016 - height
    mujoco.mj_fwdPosition(model, data)
    assert (data.ncon > 0) is not overlaps
    assert assemble(excluding(robot), skin, effects).nexclude == 1


def test_pairs_of_bare_links_stay_excluded():
    robot, skin = bowl_and_ball(0.03)
    found = excluding(robot, f"{TOUCHING}block ball")
    for number, apart in ((0, False), (1, False), (2, True)):
        bare = replace(skin, patches=skin.patches[number : number + 1])
        assert (BOTH in excluded_pairs(found, bare)) is apart


def test_link_inside_another_one_never_collides_with_it():
    """A small ball in the middle of the solid below the rim touches none of the pieces, which are 10 mm thick."""
    robot, skin = bowl_and_ball(0.005)
    ball = robot.link("ball")
    tiny = Mesh(0.03 * ball.mesh.vertices, ball.mesh.faces)
    patches = (
        skin.patches[0],
        replace(skin.patches[1], surface=Mesh(0.03 * skin.patches[1].surface.vertices, ball.mesh.faces)),
    )
    deep = replace(
        robot,
        mjcf=robot.mjcf.replace('pos="0 0 0.005"', 'pos="0.045 0.04 -0.016"'),
        links=(robot.links[0], replace(ball, mesh=tiny)),
    )
    assert BOTH in excluded_pairs(deep, replace(skin, patches=patches))
