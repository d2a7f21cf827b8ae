"""The solid shapes of geoms, and which of them may press which link."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.object_geoms import has_body
from tactile_maps.simulation.pressing_shapes import Solids, contact_candidates
from tactile_maps.skin.collision_shapes import excluded_pairs
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, MeshShape, Plane, Sphere
from tests.support.scene_objects import every_kind, thing
from tests.support.touch import arm, bar, bar_skin, pair

KINDS = ("sphere", "box", "cylinder", "mesh", "plate", "probe", "plane")
POINT = 1e-4
"""Radius of a probe that approximates a point [m]."""


def world_with(*things):
    model = assemble(bar(), bar_skin(), Effects(contact="environment"), objects=things)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def solid_of(kind: str, **said):
    body = thing(kind, at=(0.1, 0.2, 0.3), turn=(20.0, 30.0, 40.0), **said)
    model, _ = world_with(body)
    return Solids(model, (body,))[int(model.geom(f"tactile-maps/object {kind}").id)]


@pytest.mark.parametrize("kind", KINDS)
def test_distances_equal_those_of_mujoco(kind):
    body = thing(kind, at=(0.1, 0.2, 0.3), turn=(20.0, 30.0, 40.0))
    point = thing("probe", name="point", size=(POINT,))
    model, data = world_with(body, point)
    geom = int(model.geom(f"tactile-maps/object {kind}").id)
    tip = int(model.geom("tactile-maps/object point").id)
    solid = Solids(model, (body, point))[geom]
    first = int(model.joint("tactile-maps/object point x").qposadr[0])
    shape = solid.seen_from(data, 0)
    rng = np.random.default_rng(0)
    nearby = np.zeros(6)
    for place in shape.points(rng.normal(size=(40, 3)) * 0.03):
        data.qpos[first : first + 3] = place
        mujoco.mj_kinematics(model, data)
        theirs = mujoco.mj_geomDistance(model, data, geom, tip, 1.0, nearby) + POINT
        ours = solid.shape.distance(shape.inverse.points(place[None]))[0]
        if ours > 1e-3:  # inside, MuJoCo returns the depth, which differs only near edges
            assert ours == pytest.approx(theirs, abs=2e-6)


def test_objects_of_all_kinds_have_the_correct_shape():
    shapes = {kind: solid_of(kind).shape for kind in KINDS}
    assert shapes["sphere"] == Sphere(0.02)
    assert shapes["probe"] == Sphere(0.01)
    assert shapes["box"] == Box((0.03, 0.025, 0.01))
    assert shapes["plate"] == Box((0.03, 0.03, 0.01))
    assert shapes["cylinder"] == Cylinder(0.03, 0.01)
    assert shapes["plane"] == Plane()
    assert isinstance(shapes["mesh"], MeshShape)


def test_open_mesh_presses_with_its_collision_shape():
    closed = thing("mesh").mesh
    body = thing("mesh", mesh=Mesh(closed.vertices, closed.faces[3:]), at=(0.1, 0.2, 0.3))
    model, _ = world_with(body)
    shape = Solids(model, (body,))[int(model.geom("tactile-maps/object mesh").id)].shape
    assert shape.distance(np.zeros((1, 3)))[0] == pytest.approx(-0.02, rel=0.03)


@pytest.mark.long
def test_hull_of_a_link_contains_link_and_skin():
    robot = arm().robot
    skin = arm().skin
    model = assemble(robot, skin, Effects(contact="self"))
    solids = Solids(model, ())
    for patch in skin.patches:
        solid = solids[int(model.geom(f"tactile-maps/skin {patch.link}").id)]
        local = solid.pose.inverse.points(patch.surface.vertices)
        assert solid.shape.distance(local).max() < 5e-6, "a hull leaves out corners of that height"
        assert solid.by == patch.link
    for geom in range(model.ngeom):
        assert solids[geom] is solids[geom]
        assert np.isfinite(solids[geom].shape.reach)


def found(contact: str, objects=()):
    robot = arm().robot
    skin = arm().skin
    effects = Effects(contact=contact, skin="foundation")
    model = assemble(robot, skin, effects, objects=objects)
    present = [t for t in objects if has_body(model, t.spec)]
    return contact_candidates(model, robot, skin, effects, present)


@pytest.mark.long
def test_objects_are_checked_against_every_link_with_skin():
    links = set(arm().skin.links)
    assert {(m.link, m.by) for m in found("probe", every_kind())} == {(link, "probe") for link in links}
    outside = found("environment", every_kind())
    assert {(m.link, m.by) for m in outside} == {(link, t.spec.name) for link in links for t in every_kind()}
    assert all(m.own is None for m in outside)
    (plane,) = (m.shape for m in found("environment", (thing("plane"),)) if m.link == "hand")
    assert plane == Plane()
    assert {m.shape for m in found("probe", (thing("probe"),))} == {Sphere(0.01)}


@pytest.mark.long
def test_each_pair_of_links_is_checked_once_unless_excluded():
    apart = excluded_pairs(arm().robot, arm().skin)
    itself = found("self")
    met = [frozenset((m.link, m.by)) for m in itself if m.own is not None]
    assert len(set(met)) == len(met)
    assert set(met) <= {frozenset((a, b)) for a in arm().skin.links for b in arm().skin.links}
    assert not any(frozenset((m.link, m.by)) in apart for m in itself)
    assert {m.by for m in itself} - set(arm().skin.links), "links without skin press too"


def test_shape_of_the_link_is_included_if_both_links_have_skin():
    robot, skin = pair()
    effects = Effects(contact="self", skin="foundation")
    (meeting,) = contact_candidates(assemble(robot, skin, effects), robot, skin, effects, ())
    assert (meeting.link, meeting.by) == ("left", "right")
    assert meeting.own is not None
    assert meeting.own[0] is not meeting.shape
