"""The wrench of all contacts on a link, against what holds the link still."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from app.scene.effects import Effects
from app.simulation.link_wrenches import LinkWrenches
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokePressed
from app.touch.push import Push
from tests.things import thing
from tests.touch import bar, bar_skin, hold, no_command, pair

WORLD = Effects(contact="environment")
STIFF = 5000.0


def pressed(effects: Effects, *, count: int = 1, steps: int = 3000) -> Simulation:
    """The hinged bar, held by stiff joints, against ``count`` fixed balls above it; at rest."""
    balls = [thing("sphere", name=f"ball {k}", at=(0.1 + 0.2 * k, 0.01 * k, 0.04 - 2e-4)) for k in range(count)]
    simulation = Simulation(bar(), bar_skin(), effects, objects=tuple(balls))
    simulation.step(steps, hold(bar(), STIFF, 100.0))
    assert abs(simulation.velocity[0]) < 1e-9, "at rest"
    return simulation


def held(simulation: Simulation) -> float:
    """The torque about the hinge that the joint's spring takes up [N m]."""
    return STIFF * float(simulation.posture[0])


@pytest.mark.parametrize("effects", [
    WORLD, replace(WORLD, friction=True), replace(WORLD, skin="depth"),
    replace(WORLD, skin="foundation", timestep=0.0005),
], ids=["solver", "friction", "depth", "foundation"])  # fmt: skip
@pytest.mark.parametrize("count", [1, 2])
def test_its_torque_about_the_hinge_is_what_the_joint_holds(effects, count):
    simulation = pressed(effects, count=count, steps=round(3 / effects.timestep))
    wrench = simulation.wrenches()["bar"]
    assert abs(held(simulation)) > 1e-4
    assert wrench[4] == pytest.approx(held(simulation), rel=1e-5)
    assert wrench[2] < -1e-3, "pressed from above"


def test_it_is_the_sum_of_the_loads_without_friction():
    simulation = pressed(WORLD, count=2)
    force = sum(-load.force * load.normal for load in simulation.loads)
    torque = sum(np.cross(load.point, -load.force * load.normal) for load in simulation.loads)
    assert simulation.wrenches()["bar"] == pytest.approx(np.concatenate([force, torque]), rel=1e-6, abs=1e-6)


def test_a_link_in_motion_feels_it_where_it_was_when_it_touched():
    ball = thing("sphere", at=(0.3, 0.0, 0.04 - 2e-3))
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(ball,))
    simulation.step(4, no_command(bar()))
    assert abs(simulation.velocity[0]) > 0.05
    (load,) = simulation.loads
    wanted = np.concatenate([-load.force * load.normal, np.cross(load.point, -load.force * load.normal)])
    assert simulation.wrenches()["bar"] == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_a_push_brings_its_own_torque():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='bar' pos='1 0 0'><geom size='1'/></body></worldbody></mujoco>"
    )
    data, sums = mujoco.MjData(model), LinkWrenches(model, bar_skin())
    mujoco.mj_forward(model, data)
    sums.keep(data)
    push = Push(1, 0, np.array([1.0, 0.5, 0.0]), np.array([0.0, 0.0, -2.0]), np.array([0.1, 0.2, 0.3]))
    assert sums.read(data, [push])["bar"] == pytest.approx((0, 0, -2, 0.1 - 1.0, 0.2, 0.3))
    other = push._replace(body=0, other=1)
    assert sums.read(data, [other])["bar"] == pytest.approx((0, 0, 2, 1.0 - 0.1, -0.2, -0.3))


def test_friction_is_felt():
    """A ball that is dragged along pulls the bar with as much as Coulomb allows."""
    ball = thing("probe", path=((0.0, 0.1, 0.0, 0.0395), (2.0, 0.2, 0.0, 0.0395)), size=(0.02,), max_force=20.0)
    robot = bar(hinged=False)
    simulation = Simulation(robot, bar_skin(), Effects(contact="probe", friction=True), objects=(ball,))
    simulation.step(500, hold(robot, 0.0, 0.0))
    wrench = simulation.wrenches()["bar"]
    (load,) = simulation.loads
    assert wrench[2] == pytest.approx(-load.force, rel=1e-3)
    assert wrench[0] == pytest.approx(0.5 * load.force, rel=0.05), "along the way of the ball"


def test_fingers_are_felt():
    simulation = Simulation(bar(hinged=False), bar_skin(), Effects())
    at = bar_skin().taxel_point(30)
    simulation.apply(PokePressed(1, at, Finger(max_force=3.0, speed=1.0)))
    simulation.step(500, hold(bar(hinged=False), 0.0, 0.0))
    (poke,) = simulation.pokes
    assert poke.force > 1
    wrench, force = simulation.wrenches()["bar"], np.array([0, 0, -poke.force])
    assert wrench == pytest.approx(np.concatenate([force, np.cross(bar_skin().position(at), force)]))


def test_two_links_feel_the_opposite():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    simulation.step(3000, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    wrenches = simulation.wrenches()
    assert wrenches["left"][:3] == pytest.approx((-7.0, 0, 0), abs=1e-5)
    assert wrenches["right"][:3] == pytest.approx((7.0, 0, 0), abs=1e-5)


def test_untouched_is_nothing():
    simulation = Simulation(bar(), bar_skin(), WORLD)
    simulation.step(5, hold(bar(), STIFF, 100.0))
    assert not simulation.wrenches()["bar"].any()


def test_asking_changes_nothing():
    """Neither the run nor a second answer."""
    asked, silent = pressed(WORLD, count=2), pressed(WORLD, count=2)
    first = asked.wrenches()["bar"]
    first += 1.0
    assert asked.wrenches()["bar"] == pytest.approx(first - 1.0, abs=1e-12)
    for run in (asked, silent):
        run.step(50, hold(bar(), 0.5 * STIFF, 100.0))
    assert np.array_equal(asked.state(), silent.state())
