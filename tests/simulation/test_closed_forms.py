"""Physics against closed forms: what is off leaves nothing behind, energy, refinement of the time step, friction,
stated stiffness.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import MIN_MOVING_MASS
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.poke import Finger, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects
from tests.support.scene_objects import every_kind, thing
from tests.support.touch import BAR_INERTIA, arm, bar, bar_skin, hold, no_command

BARE = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
SIZES = [
    name
    for name in dir(mujoco.MjModel)
    if name.startswith("n")
    and name not in ("names", "numeric_adr", "numeric_data", "numeric_size", "name_actuatoradr", "nbuffer")
]


def sizes(model: mujoco.MjModel) -> dict[str, int]:
    return {name: int(value) for name in SIZES if isinstance(value := getattr(model, name), int)}


@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("feature", "without"),
    [
        (Effects(contact="off"), Effects(contact="off", friction=True)),
        (Effects(skin="water-fill"), Effects(skin="off")),
        (Effects(skin="water-fill"), Effects(skin="depth")),
        (Effects(skin="water-fill"), Effects(skin="foundation")),
        (Effects(fingers=True), Effects(fingers=False)),
        (Effects(), Effects(sensor=SensorEffects(noise=Noise()))),
    ],
)
def test_effect_without_a_body_to_act_on_leaves_the_model_unchanged(feature, without):
    models = [assemble(arm().robot, arm().skin, effects, objects=every_kind()) for effects in (feature, without)]
    assert sizes(models[0]) == sizes(models[1])


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("contact", ["off", "probe", "environment", "self", "all"])
def test_objects_out_of_reach_of_the_effect_leave_the_model_as_if_they_did_not_exist(contact):
    kinds = {"off": (), "self": (), "probe": ("probe",)}.get(contact)
    present = tuple(t for t in every_kind() if kinds is None or t.spec.kind in kinds)
    effects = Effects(contact=contact)
    with_all = assemble(arm().robot, arm().skin, effects, objects=every_kind())
    assert sizes(with_all) == sizes(assemble(arm().robot, arm().skin, effects, objects=present))


@pytest.fixture
def calls(monkeypatch) -> Counter[str]:
    """Counts every call of a MuJoCo function."""
    counted: Counter[str] = Counter()

    def counting(name, function):
        def call(*args, **kwargs):
            counted[name] += 1
            return function(*args, **kwargs)

        return call

    for name in dir(mujoco):
        if name.startswith(("mj_", "mju_")):
            monkeypatch.setattr(mujoco, name, counting(name, getattr(mujoco, name)))
    return counted


def run(effects: Effects, calls: Counter[str], *, things=(), poke: bool = False) -> Counter[str]:
    """Calls of one step of five under an old command, and one reading."""
    robot = bar()
    simulation = Simulation(robot, bar_skin(), effects, objects=things)
    command = hold(robot, 5.0, 0.5)
    simulation.step(5, command)
    if poke:
        simulation.apply(PokePressed(1, bar_skin().taxel_point(5), Finger(speed=0.0)))
    calls.clear()
    simulation.step(5, command)
    simulation.sense()
    return Counter(calls)


def test_all_steps_without_effects_are_one_call_of_mujoco(calls):
    assert run(BARE, calls) == {"mj_step": 1, "mj_getState": 1, "mju_dot": 1}


def test_inactive_objects_add_no_call(calls):
    assert run(Effects(), calls, things=every_kind()) == run(BARE, calls)


def test_contacts_are_read_once_per_reading_and_only_checked_after_each_step(calls):
    """After a step two dot products, of speeds and of forces, and one more a reading; nothing between its halves."""
    made = run(Effects(contact="environment"), calls, things=(thing("box", at=(5.0, 0.0, 0.0)),))
    dots = made.pop("mju_dot")
    assert made == {"mj_step1": 5, "mj_step2": 5, "mj_getState": 1, "mj_kinematics": 1, "mj_comPos": 1}
    assert dots <= 2 * 5 + 2


def test_hooks_are_called_between_steps(calls):
    made = run(Effects(), calls, poke=True)
    assert made["mj_step1"] == made["mj_step2"] == 5
    assert made["mj_step"] == 0
    walker = thing("probe", path=((0.0, 5.0, 0.0, 0.0), (1.0, 6.0, 0.0, 0.0)))
    assert run(Effects(contact="probe"), calls, things=(walker,))["mj_step1"] == 5
    bare = run(Effects(contact="off"), calls, things=(thing("probe", at=(5.0, 0.0, 0.0)),))
    assert bare["mj_step1"] == 0


def test_lifted_finger_adds_no_call(calls):
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    command = hold(robot, 5.0, 0.5)
    simulation.apply(PokePressed(1, bar_skin().taxel_point(5)))
    simulation.step(5, command)
    simulation.apply(PokeReleased(1))
    simulation.step(5, command)
    calls.clear()
    simulation.step(5, command)
    assert calls == {"mj_step": 1, "mj_getState": 1, "mju_dot": 1}


def test_gains_are_written_only_when_the_command_changes():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), BARE)
    command = hold(robot, 5.0, 0.5)
    simulation.step(1, command)
    simulation._model.actuator_gainprm[0, 0] = 7.0
    simulation.step(1, command)
    assert simulation._model.actuator_gainprm[0, 0] == 7.0
    simulation.step(1, hold(robot, 5.0, 0.5))
    assert simulation._model.actuator_gainprm[0, 0] == 7.0, "an equal command says nothing new"
    simulation.step(1, hold(robot, 6.0, 0.5))
    assert simulation._model.actuator_gainprm[0, 0] == 6.0


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit"])
def test_finger_without_force_does_not_change_the_motion(integrator):
    effects = Effects(gravity="on", integrator=integrator)
    free = Simulation(bar(), bar_skin(), effects)
    touched = Simulation(bar(), bar_skin(), effects)
    touched.apply(PokePressed(1, bar_skin().taxel_point(5), Finger(max_force=0.0)))
    for simulation in (free, touched):
        simulation.step(200, no_command(bar()))
    assert np.array_equal(free.posture, touched.posture)


def test_pendulum_follows_the_closed_form():
    robot = bar()
    effects = Effects(gravity="on", contact="off", joint_limits=False, fingers=False, skin="off", timestep=1e-4)
    simulation = Simulation(robot, bar_skin(), effects)
    simulation._data.qpos[:] = 0.5 * np.pi - 0.01  # hanging down is +90 degrees about +y
    omega = np.sqrt(9.81 * 0.2 / BAR_INERTIA)
    simulation.step(20000, no_command(robot))
    assert simulation.posture[0] - 0.5 * np.pi == pytest.approx(-0.01 * np.cos(omega * 2.0), abs=2e-5)


def test_bar_without_forces_keeps_turning():
    simulation = Simulation(bar(), bar_skin(), BARE)
    simulation._data.qvel[:] = 2.0
    simulation.step(1000, no_command(bar()))
    assert simulation.posture[0] == pytest.approx(2.0, rel=1e-12)


TAXELS = (20, 120, 170, 200, 290)


def free_arm(taxel: int, *, timestep: float) -> tuple[Simulation, float]:
    """The arm without any loss, thrown against a standing finger; and the finger's stiffness."""
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, Effects("off", "off", False, timestep))
    simulation._model.dof_damping[:] = simulation._model.dof_frictionloss[:] = 0
    simulation._model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    at = prepared.skin.taxel_point(taxel)
    configuration = Configuration(prepared.robot)
    link = prepared.skin.link(at)
    outward = configuration.pose(link).rotation @ prepared.skin.normal(at)
    row = outward @ configuration.jacobian(link, prepared.skin.position(at))
    simulation.apply(PokePressed(1, at, Finger(stiffness=300.0, speed=0.0, max_force=1e6)))
    simulation._data.qvel[:] = 0.6 * row / np.linalg.norm(row) + 0.3 * np.cos(np.arange(7))
    return simulation, 300.0


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("taxel", TAXELS)
def test_fixed_finger_returns_the_energy_it_took(taxel):
    """Kinetic energy and ½ k depth² stay constant however the arm turns under the finger."""
    command = no_command(arm().robot)
    for timestep, drift in ((1e-3, 1e-2), (2.5e-4, 2.5e-3)):
        simulation, stiffness = free_arm(taxel, timestep=timestep)
        energy = []
        forces = []
        for _ in range(round(3.0 / timestep / 10)):
            simulation.step(10, command)
            forces.append(simulation.pokes[0].force)
            energy.append(simulation._data.energy[1] + 0.5 * forces[-1] ** 2 / stiffness)
        assert max(forces) > 1, "the arm did run into the finger"
        assert np.abs(np.array(energy) / energy[0] - 1).max() < drift


@pytest.mark.long
def test_postures_agree_when_the_time_step_is_refined():
    prepared = arm()
    ends = []
    for timestep in (1e-3, 5e-4, 1e-4):
        simulation = Simulation(prepared.robot, prepared.skin, Effects(timestep=timestep))
        simulation.apply(PokePressed(1, prepared.skin.taxel_point(170), Finger(max_force=8.0)))
        simulation.step(round(1.5 / timestep), hold(prepared.robot, 3.0, 0.5))
        ends.append(simulation.posture)
    moved = np.abs(ends[-1] - prepared.robot.home).max()
    assert moved > 0.03
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert errors[0] < 0.01 * moved
    assert errors[1] < 0.7 * errors[0], "first order"


FORCE = 10.0
MASS = 0.2


def dragged(
    friction: float, speed: float, stiffness: float, *, hinged: bool = True, force: float = FORCE, **effects
) -> tuple[np.ndarray, np.ndarray]:
    """Normal and friction force [N] at each step while a probe presses with ``force`` and slides along the bar."""
    robot = bar(hinged=hinged)
    top = 0.02 + 0.01
    slides = 1.0 + 0.22 / speed
    path = ((0.0, 0.1, 0.0, top + 0.001), (0.1, 0.1, 0.0, top - 0.05), (1.0, 0.1, 0.0, top - 0.05),
            (slides, 0.32, 0.0, top - 0.05))  # fmt: skip
    probe = thing("probe", path=path, mass=MASS, max_force=force, friction=friction)
    layer = ElasticLayer(stiffness=stiffness, friction=friction)
    simulation = Simulation(
        robot, bar_skin(), Effects(contact="probe", friction=True, **effects), objects=(probe,), layer=layer
    )
    assert MIN_MOVING_MASS < MASS
    command = hold(robot, 2000.0, 80.0)
    rows = []
    wrench = np.zeros(6)
    simulation.step(round(1.3 / simulation.timestep), command)
    while simulation.time < min(slides - 0.01, 4.0):
        simulation.step(1, command)
        wrench[:] = 0
        if simulation._data.ncon:
            mujoco.mj_contactForce(simulation._model, simulation._data, 0, wrench)
        rows.append((wrench[0], np.hypot(wrench[1], wrench[2])))
    return tuple(np.array(rows).T)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("stiffness", [2e3, 2e4, 2e5])
@pytest.mark.parametrize("friction", [0.2, 0.5, 1.0])
@pytest.mark.parametrize("speed", [0.03, 0.1])
def test_force_of_ten_newtons_is_kept_while_sliding(stiffness, friction, speed):
    normal, tangent = dragged(friction, speed, stiffness)
    assert len(normal) > 500
    assert (normal > 0).all(), "never lost"
    assert np.abs(normal - FORCE).max() < 0.03 * FORCE
    assert (tangent <= friction * normal * (1 + 1e-6)).all()


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(("friction", "speed"), [(0.2, 0.03), (0.2, 0.1), (0.5, 0.1), (0.5, 0.2), (1.0, 0.2)])
def test_sliding_body_has_coulomb_friction(friction, speed):
    """Friction must survive the remedy against hopping: MuJoCo's ``solreffriction = 0.2 1`` leaves 1 % of it."""
    normal, tangent = dragged(friction, speed, 2e4, hinged=False)
    steady = slice(len(normal) // 3, None)
    assert tangent[steady].mean() == pytest.approx(friction * normal[steady].mean(), rel=0.03)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("integrator", ["discrete", "euler", "implicit"])
def test_sliding_friction_is_correct_with_every_integrator(integrator):
    for speed in (0.1, 0.2):
        normal, tangent = dragged(0.5, speed, 2e4, integrator=integrator)
        assert np.abs(normal - FORCE).max() < 0.03 * FORCE
        steady = slice(len(normal) // 3, None)
        assert tangent[steady].mean() == pytest.approx(0.5 * FORCE, rel=0.03)


def test_contact_without_friction_has_no_shear():
    robot = bar()
    probe = thing("probe", path=((0.0, 0.1, 0.0, 0.029), (2.0, 0.3, 0.0, 0.029)), mass=MASS, friction=1.0)
    simulation = Simulation(robot, bar_skin(), Effects(contact="probe"), objects=(probe,))
    simulation.step(1000, hold(robot, 2000.0, 80.0))
    wrench = np.zeros(6)
    mujoco.mj_contactForce(simulation._model, simulation._data, 0, wrench)
    assert wrench[0] > 0.5
    assert not wrench[1:].any()


STIFFNESS_TAXELS = (20, 150, 280)
"""Taxels on upper arm, forearm and hand."""


def facing(normal: np.ndarray) -> tuple[float, ...]:
    """Turns [deg] that bring the z axis to ``normal``."""
    z = normal / np.linalg.norm(normal)
    x = np.cross([0.0, 1.0, 0.3], z)
    x /= np.linalg.norm(x)
    return tuple(Rotation.from_matrix(np.stack([x, np.cross(z, x), z], axis=1)).as_euler("xyz", degrees=True))


def pressed(
    kind: str,
    taxel: int,
    turned: float,
    deep: float,
    layer: ElasticLayer,
    *,
    held: float = 20000.0,
    seconds: float = 1.5,
    **effects,
) -> Simulation:
    """A thing fixed or sprung ``deep`` in the arm's skin, joints held at a posture ``turned`` from home, at rest."""
    prepared = arm()
    robot = replace(prepared.robot, home=prepared.robot.home + turned * np.sin(np.arange(7)))
    at = prepared.skin.taxel_point(taxel)
    configuration = Configuration(robot)
    pose = configuration.pose(prepared.skin.link(at))
    normal = pose.directions(prepared.skin.normal(at))
    half = {"probe": 0.01, "sphere": 0.02, "mesh": 0.02}.get(kind, 0.01)
    said = {"plate": {"stiffness": 2000.0, "damping": 1.0, "mass": 0.2}, "probe": {"mass": 0.2}}.get(kind, {})
    centre = pose.points(prepared.skin.position(at)) + (half - deep) * normal
    body = thing(kind, at=tuple(centre), turn=facing(normal), **said)
    simulation = Simulation(
        robot, prepared.skin, Effects(contact="environment", **effects), objects=(body,), layer=layer
    )
    simulation.step(round(seconds / simulation.timestep), hold(robot, held, 0.015 * held))
    return simulation


def measured(simulation: Simulation) -> tuple[float, float]:
    """Return the force [N] of the contact and its stiffness [N/m] by the depth of its deepest point."""
    (load,) = simulation._physics.loads()
    depth = -simulation._data.contact.dist.min()
    return load.force, load.force / depth


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("taxel", STIFFNESS_TAXELS)
@pytest.mark.parametrize("kind", ["probe", "sphere", "box", "cylinder", "mesh", "plate"])
def test_measured_contact_stiffness_is_that_of_the_cover(kind, taxel):
    for turned, stiffness in ((0.0, 2e4), (0.3, 5e4), (-0.4, 5e3)):
        deep = 5e-3 if kind in ("probe", "plate") else 5e-4
        force, found = measured(pressed(kind, taxel, turned, deep, ElasticLayer(stiffness=stiffness)))
        assert force > 0.5
        assert found == pytest.approx(stiffness, rel=0.01)


@pytest.mark.long
@pytest.mark.parametrize("integrator", ["implicitfast", "discrete", "euler", "implicit"])
def test_contact_stiffness_is_correct_with_every_integrator(integrator):
    for friction in (False, True):
        how = {"held": 200.0, "seconds": 5.0, "integrator": integrator, "friction": friction}
        assert measured(pressed("sphere", 150, 0.2, 5e-4, ElasticLayer(stiffness=2e4), **how))[1] == pytest.approx(
            2e4, rel=0.01
        )


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("held", [200.0, 2000.0, 20000.0])
def test_contact_stiffness_with_implicit_integration_does_not_depend_on_joint_stiffness(held):
    """``discrete`` weighs bodies with their servos: without care the contact would be up to seven times as stiff."""
    run = pressed("sphere", 150, 0.2, 5e-4, ElasticLayer(stiffness=2e4), held=held, integrator="discrete")
    assert measured(run)[1] == pytest.approx(2e4, rel=0.01)
