"""The solver's contacts as loads: one a meeting, at the right place, felt on both sides."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from app.geometry.pose import Pose
from app.scene.effects import Effects
from app.simulation.contact_loads import ContactLoads
from app.simulation.geom_shapes import Solids
from app.simulation.simulation import Simulation
from app.touch.shapes import Ball
from tests.things import thing
from tests.touch import bar, bar_skin, hold, no_command, pair

WORLD = Effects(contact="environment")


def resting(kind: str, *, deep: float = 2e-4, **said) -> Simulation:
    """Something fixed that the skin of the hinged bar is pressed against from above; stiff joints, at rest."""
    half = {"sphere": 0.02, "box": 0.01, "cylinder": 0.01, "mesh": 0.02}[kind]
    body = thing(kind, at=(0.3, 0.01, 0.02 + half - deep), **said)
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(body,))
    simulation.step(3000, hold(bar(), 5000.0, 100.0))
    assert abs(simulation.velocity[0]) < 1e-9, "at rest"
    assert abs(simulation.posture[0]) > 1e-6, "pushed away"
    return simulation


@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "mesh"])
def test_the_force_is_what_holds_the_bar(kind):
    simulation = resting(kind)
    (load,) = simulation._physics.loads()
    spring = 5000.0 * simulation.posture[0]
    torque = load.force * np.cross(load.point, load.normal)[1]
    assert (load.link, load.by) == ("bar", kind)
    assert -torque == pytest.approx(-abs(spring) * np.sign(torque), rel=1e-6)
    assert load.normal == pytest.approx((0, 0, 1), abs=1e-3)
    assert load.point[2] == pytest.approx(0.02, abs=1e-3)


@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "mesh"])
def test_the_sum_of_pressure_times_area_is_the_force(kind):
    simulation = resting(kind)
    (load,) = simulation._physics.loads()
    assert load.force > 0.5
    assert simulation.sense() @ bar_skin().areas == pytest.approx(load.force, rel=1e-6)


def test_the_shape_is_where_the_body_is():
    simulation = resting("sphere")
    (load,) = simulation._physics.loads()
    assert load.shape == Ball(0.02)
    angle = simulation.posture[0]
    turned = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    world = Pose(turned, np.zeros(3)) @ load.pose
    assert world.translation == pytest.approx((0.3, 0.01, 0.04 - 2e-4), abs=1e-12)
    depth = -load.distances(load.point[None])[0]
    assert 0 < depth < 2e-4, "the middle of the overlap"


def test_two_links_that_touch_both_feel_the_force_between_them():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    simulation.step(3000, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    assert abs(simulation.velocity[0]) < 1e-6, "at rest, so the contact carries the push"
    assert simulation.posture[0] == pytest.approx(0.03 + 7.0 / 1e4, rel=1e-6), "two skins of 2e4 N/m in series"
    force = simulation.sense() * skin.areas
    first = skin.first[1]
    assert force[:first].sum() == pytest.approx(7.0, rel=1e-6)
    assert force[first:].sum() == pytest.approx(force[:first].sum(), rel=1e-12)
    left, right = simulation._physics.loads()
    assert {left.by, right.by} == {"left", "right"}
    assert {left.link, right.link} == {"left", "right"}


def test_links_apart_feel_nothing():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    simulation.step(10, hold(robot, 10.0, 1.0))
    assert simulation._physics.loads() == []
    assert not simulation.sense().any()


def test_without_the_effect_links_pass_through_each_other():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="off"))
    simulation.step(3000, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    assert simulation.posture[0] > 0.045
    assert not simulation.sense().any()


def test_many_contacts_of_one_meeting_are_one_load_at_their_centre():
    """With several points a hull and a box, as no model of ours makes them, but as MuJoCo can."""
    robot, skin = bar(hinged=False), bar_skin()
    box = thing("box", at=(0.2, 0.01, 0.03 - 1e-3), mass=1.0)
    simulation = Simulation(robot, skin, WORLD, objects=(box,))
    model, data = simulation._model, simulation._data
    model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_MULTICCD)
    mujoco.mj_forward(model, data)
    assert data.ncon == 4
    forces = data.efc_force[data.contact.efc_address]
    (load,) = ContactLoads(model, skin, Solids(model, (box,))).read(data)
    assert load.force == pytest.approx(forces.sum(), rel=1e-12)
    assert load.point == pytest.approx(forces @ data.contact.pos / forces.sum(), rel=1e-12)
    assert load.normal == pytest.approx((0, 0, 1), abs=1e-9)


def test_two_things_on_one_link_are_two_loads():
    one, other = (thing("sphere", name=name, at=(x, 0.0, 0.0395)) for name, x in (("one", 0.15), ("other", 0.3)))
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(one, other))
    simulation.step(2000, hold(bar(), 5000.0, 100.0))
    loads = simulation._physics.loads()
    assert sorted(load.by for load in loads) == ["one", "other"]
    assert simulation.sense() @ bar_skin().areas == pytest.approx(sum(load.force for load in loads), rel=1e-6)


def test_two_things_that_cannot_move_make_no_force():
    robot = bar(hinged=False)
    simulation = Simulation(robot, bar_skin(), WORLD, objects=(thing("sphere", at=(0.2, 0.0, 0.0395)),))
    simulation.step(5, no_command(robot))
    assert simulation._physics.loads() == []
