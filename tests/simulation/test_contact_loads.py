"""Contacts as loads on the skin, and their wrenches on links."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.contact_loads import LinkWrenches
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.loads import Sphere
from tactile_maps.tactile.models.foundation import ContactWrench
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold, no_command, pair

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


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("kind", ["sphere", "box", "cylinder", "mesh"])
def test_contact_force_balances_the_joint_torque(kind):
    simulation = resting(kind)
    (load,) = simulation._physics.loads()
    spring = 5000.0 * simulation.posture[0]
    torque = load.force * np.cross(load.point, load.normal)[1]
    assert (load.link, load.by) == ("bar", kind)
    assert -torque == pytest.approx(-abs(spring) * np.sign(torque), rel=1e-6)
    assert load.normal == pytest.approx((0, 0, 1), abs=1e-3)
    assert load.point[2] == pytest.approx(0.02, abs=1e-3)


def test_load_shape_is_at_the_pose_of_the_body():
    simulation = resting("sphere")
    (load,) = simulation._physics.loads()
    assert load.shape == Sphere(0.02)
    angle = simulation.posture[0]
    turned = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    world = Pose(turned, np.zeros(3)) @ load.pose
    assert world.translation == pytest.approx((0.3, 0.01, 0.04 - 2e-4), abs=1e-12)
    depth = -load.distances(load.point[None])[0]
    assert 0 < depth < 2e-4, "the middle of the overlap"


@pytest.mark.long
def test_both_links_in_contact_have_the_force_between_them():
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


def test_two_bodies_on_one_link_are_two_loads():
    one, other = (thing("sphere", name=name, at=(x, 0.0, 0.0395)) for name, x in (("one", 0.15), ("other", 0.3)))
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(one, other))
    simulation.step(2000, hold(bar(), 5000.0, 100.0))
    loads = simulation._physics.loads()
    assert sorted(load.by for load in loads) == ["one", "other"]
    assert simulation.sense() @ bar_skin().areas == pytest.approx(sum(load.force for load in loads), rel=1e-6)


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


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    "effects",
    [
        WORLD,
        replace(WORLD, friction=True),
        replace(WORLD, skin="depth"),
        replace(WORLD, skin="foundation", timestep=0.0005),
    ],
    ids=["solver", "friction", "depth", "foundation"],
)
@pytest.mark.parametrize("count", [1, 2])
def test_wrench_torque_about_the_hinge_equals_the_joint_torque(effects, count):
    simulation = pressed(effects, count=count, steps=round(3 / effects.timestep))
    wrench = simulation.wrenches()["bar"]
    assert abs(held(simulation)) > 1e-4
    assert wrench[4] == pytest.approx(held(simulation), rel=1e-5)
    assert wrench[2] < -1e-3, "pressed from above"


def test_load_on_a_moving_link_is_at_its_pose_of_contact():
    ball = thing("sphere", at=(0.3, 0.0, 0.04 - 2e-3))
    simulation = Simulation(bar(), bar_skin(), WORLD, objects=(ball,))
    simulation.step(4, no_command(bar()))
    assert abs(simulation.velocity[0]) > 0.05
    (load,) = simulation.loads
    expected = np.concatenate([-load.force * load.normal, np.cross(load.point, -load.force * load.normal)])
    assert simulation.wrenches()["bar"] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_load_includes_its_torque():
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body name='bar' pos='1 0 0'><geom size='1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    sums = LinkWrenches(model, bar_skin())
    mujoco.mj_forward(model, data)
    sums.keep(data)
    push = ContactWrench(1, 0, np.array([1.0, 0.5, 0.0]), np.array([0.0, 0.0, -2.0]), np.array([0.1, 0.2, 0.3]))
    assert sums.read(data, [push])["bar"] == pytest.approx((0, 0, -2, 0.1 - 1.0, 0.2, 0.3))
    other = push._replace(body=0, other=1)
    assert sums.read(data, [other])["bar"] == pytest.approx((0, 0, 2, 1.0 - 0.1, -0.2, -0.3))


def test_wrench_includes_friction():
    """A ball that is dragged along pulls the bar with as much as Coulomb allows."""
    ball = thing("probe", path=((0.0, 0.1, 0.0, 0.0395), (2.0, 0.2, 0.0, 0.0395)), size=(0.02,), max_force=20.0)
    robot = bar(hinged=False)
    simulation = Simulation(robot, bar_skin(), Effects(contact="probe", friction=True), objects=(ball,))
    simulation.step(500, hold(robot, 0.0, 0.0))
    wrench = simulation.wrenches()["bar"]
    (load,) = simulation.loads
    assert wrench[2] == pytest.approx(-load.force, rel=1e-3)
    assert wrench[0] == pytest.approx(0.5 * load.force, rel=0.05), "along the way of the ball"


def test_wrench_includes_fingers():
    simulation = Simulation(bar(hinged=False), bar_skin(), Effects())
    at = bar_skin().taxel_point(30)
    simulation.apply(PokePressed(1, at, Finger(max_force=3.0, speed=1.0)))
    simulation.step(500, hold(bar(hinged=False), 0.0, 0.0))
    (poke,) = simulation.pokes
    assert poke.force > 1
    wrench = simulation.wrenches()["bar"]
    force = np.array([0, 0, -poke.force])
    assert wrench == pytest.approx(np.concatenate([force, np.cross(bar_skin().position(at), force)]))


@pytest.mark.long
def test_wrenches_of_two_links_in_contact_are_opposite():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    simulation.step(3000, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    wrenches = simulation.wrenches()
    assert wrenches["left"][:3] == pytest.approx((-7.0, 0, 0), abs=1e-5)
    assert wrenches["right"][:3] == pytest.approx((7.0, 0, 0), abs=1e-5)
