"""Who touches whom in each mode, and with what numbers."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import every_kind, thing
from tests.support.touch import arm, bar, bar_skin, pair

BOX = thing("box", at=(5.0, 0.0, 5.0), mass=1.0)


def pairs(model) -> set[frozenset[str]]:
    return {
        frozenset((model.geom(a).name, model.geom(b).name))
        for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)
    }


def meet(model, first: str, second: str) -> bool:
    """Whether MuJoCo's bits let two geoms collide."""
    a = model.geom(first)
    b = model.geom(second)
    return bool((a.contype[0] & b.conaffinity[0]) | (b.contype[0] & a.conaffinity[0]))


def test_self_contact_collides_hulls_that_reach_the_skin():
    robot, skin = pair()
    raised = replace(skin.patches[0].surface, vertices=skin.patches[0].surface.vertices + [0.004, 0, 0])
    model = assemble(
        robot,
        replace(skin, patches=(replace(skin.patches[0], surface=raised), skin.patches[1])),
        Effects(contact="self"),
    )
    assert pairs(model) == {frozenset(("tactile-maps/skin left", "tactile-maps/skin right"))}
    assert not model.geom_contype.any(), "nothing collides by bits as well"
    assert model.ngeom == 2, "the links' own shapes are gone"
    mesh = model.mesh("tactile-maps/skin left").id
    start = model.mesh_vertadr[mesh]
    count = model.mesh_vertnum[mesh]
    geom = model.geom("tactile-maps/skin left")
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, geom.quat)
    vertices = model.mesh_vert[start : start + count].reshape(-1, 3) @ rotation.reshape(3, 3).T + geom.pos
    assert (vertices[:, 0].min(), vertices[:, 0].max()) == pytest.approx((-0.05, 0.054), abs=1e-6), "link and skin"


@pytest.mark.long
def test_environment_contact_uses_pairs_for_skin_and_collision_bits_otherwise():
    robot = arm().robot
    skin = arm().skin
    model = assemble(robot, skin, Effects(contact="environment"), objects=every_kind())
    links = skin.links
    things = [t.spec.name for t in every_kind()]
    partners = {f"tactile-maps/object {name}" for name in things}
    assert pairs(model) == {frozenset((f"tactile-maps/skin {link}", other)) for link in links for other in partners}
    bare = [model.geom(i).name for i in np.flatnonzero(model.geom_conaffinity) if "object" not in model.geom(i).name]
    assert len(bare) == len(robot.links) - len(links)
    assert meet(model, bare[0], "tactile-maps/object box")
    assert meet(model, "tactile-maps/object box", "tactile-maps/object plane")
    assert not meet(model, bare[0], bare[1])
    assert not any(
        meet(model, f"tactile-maps/skin {links[0]}", other)
        for other in (*bare, "tactile-maps/object box", "tactile-maps/object plane")
    )


@pytest.mark.long
def test_effect_all_combines_environment_and_self_contact():
    robot = arm().robot
    skin = arm().skin
    everything, outside, itself = (
        assemble(robot, skin, Effects(contact=contact), objects=every_kind())
        for contact in ("all", "environment", "self")
    )
    assert pairs(everything) == pairs(outside) | pairs(itself)
    bare = [i for i in np.flatnonzero(everything.geom_contype) if "object" not in everything.geom(i).name]
    assert meet(everything, everything.geom(bare[0]).name, everything.geom(bare[1]).name)


@pytest.mark.parametrize(("friction", "dimensions"), [(False, 1), (True, 3)])
def test_friction_is_that_of_the_object_or_by_default_of_the_cover(friction, dimensions):
    layer = ElasticLayer(friction=0.4)
    for of_box, felt in ((0.1, 0.1), (0.9, 0.9), (0.0, 0.0), (None, 0.4)):
        box = thing("box", at=(5.0, 0.0, 5.0), mass=1.0, friction=of_box)
        model = assemble(
            bar(), bar_skin(), Effects(contact="environment", friction=friction), objects=(box,), layer=layer
        )
        assert list(model.pair_dim) == [dimensions]
        assert model.pair_friction[0, 0] == felt
        assert model.geom("tactile-maps/object box").condim[0] == dimensions
        assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC


def test_pairs_and_collision_bits_of_the_robot_file_are_ignored():
    text = (
        bar()
        .mjcf.replace(
            "</worldbody>",
            '<geom name="g" type="box" size="1 1 1" pos="9 9 9"/></worldbody>'
            '<contact><pair geom1="g" geom2="own"/></contact>',
        )
        .replace('<geom type="box" pos', '<geom name="own" type="box" pos')
    )
    model = assemble(replace(bar(), mjcf=text), bar_skin(), Effects(contact="environment"), objects=(BOX,))
    assert pairs(model) == {frozenset(("tactile-maps/skin bar", "tactile-maps/object box"))}
