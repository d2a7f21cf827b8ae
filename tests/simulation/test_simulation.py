"""A simulation: deterministic, with or without dynamics, and carried on when effects change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.physics import Physics
from tactile_maps.simulation.simulation import Simulation, joint_states, restore_joint_states
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.poke import Finger, PokeMoved, PokePressed, PokeReleased
from tactile_maps.tactile.sensors.sensor_effects import Hysteresis, Noise, SensorEffects
from tests.support.scene_objects import thing
from tests.support.touch import BAR_INERTIA, arm, bar, bar_skin, hold, no_command


def test_joint_under_impedance_follows_the_closed_form():
    """I q'' + d q' + k q = torque, critically damped, against the closed form."""
    robot = bar()
    frequency = 10.0
    command = hold(robot, BAR_INERTIA * frequency**2, 2 * BAR_INERTIA * frequency)
    simulation = Simulation(robot, bar_skin(), Effects(timestep=1e-4))
    simulation._data.qpos[:] = 0.1
    simulation.step(3000, command)
    exact = 0.1 * (1 + frequency * 0.3) * np.exp(-frequency * 0.3)
    assert simulation.posture[0] == pytest.approx(exact, rel=2e-3)


def test_weight_sags_unless_compensated():
    robot = bar()
    for gravity, sagged in (("on", True), ("compensated", False), ("off", False)):
        simulation = Simulation(robot, bar_skin(), Effects(gravity=gravity))
        simulation.step(3000, hold(robot, 40.0, 6.0))
        assert (abs(simulation.posture[0]) > 0.02) == sagged
        if sagged:
            angle = simulation.posture[0]
            assert 40.0 * angle == pytest.approx(9.81 * 0.2 * np.cos(angle), rel=1e-3), "about +y, down is positive"


def test_joints_stop_at_their_limits():
    robot = bar()
    push = type(no_command(robot))(np.zeros(1), np.zeros(1), np.ones(1), np.array([5.0]))
    for limits, free in ((True, False), (False, True)):
        simulation = Simulation(robot, bar_skin(), Effects(joint_limits=limits))
        simulation.step(3000, push)
        assert (simulation.posture[0] > 1.6) == free


def test_reset_clears_everything():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    start = simulation.state()
    simulation.apply(PokePressed(1, bar_skin().taxel_point(5)))
    simulation.step(200, hold(robot, 1.0, 0.1))
    assert simulation.time == pytest.approx(0.2)
    assert abs(simulation.posture[0]) > 1e-3
    simulation.reset()
    assert np.array_equal(simulation.state(), start)
    assert simulation.pokes == ()
    assert simulation.timestep == 0.001


BALL = thing("sphere", at=(5.0, 0.0, 5.0), mass=1.0)
PROBE = thing("probe", at=(5.0, 1.0, 5.0))


def physics(*objects, effects: Effects | None = None, robot=None, skin=None) -> Physics:
    made = Physics(
        robot or bar(), skin or bar_skin(), effects or Effects(contact="environment"), objects, ElasticLayer()
    )
    made.start((robot or bar()).home)
    return made


def test_joint_states_are_transferred_by_name():
    one = physics(BALL, PROBE)
    other = physics(PROBE, BALL)
    rng = np.random.default_rng(0)
    one.data.qpos[:] = rng.normal(size=one.model.nq) * 0.1
    one.data.qpos[one.model.joint("tactile-maps/object sphere").qposadr[0] + 3 :][:4] = (1, 0, 0, 0)
    one.data.qvel[:], one.data.qacc_warmstart[:] = rng.normal(size=(2, one.model.nv))
    states = joint_states(one.model, one.data)
    assert list(states) == [
        "hinge",
        "tactile-maps/object sphere",
        "tactile-maps/object probe x",
        "tactile-maps/object probe y",
        "tactile-maps/object probe z",
    ]
    restore_joint_states(other, states, 1.25)
    back = joint_states(other.model, other.data)
    for name, state in states.items():
        for field in ("position", "velocity", "acceleration"):
            assert np.array_equal(getattr(back[name], field), getattr(state, field)), (name, field)
    assert other.data.time == 1.25
    assert other.data.xpos[other.model.body("tactile-maps/object sphere").id] == pytest.approx(
        states["tactile-maps/object sphere"].position[:3]
    )


STILL = Effects(dynamics=False, contact="all")


@pytest.mark.long
def test_kinematic_posture_equals_the_command_while_time_advances():
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, STILL, objects=(thing("box", at=(1.0, 0.0, 0.0), mass=1.0),))
    posture = prepared.robot.home + 0.1
    simulation.step(5, replace(hold(prepared.robot, 1.0, 1.0), posture=posture))
    assert np.array_equal(simulation.posture, posture)
    assert simulation.time == pytest.approx(0.005)
    assert simulation.velocity == pytest.approx(np.full(7, 0.1 / 0.005))
    simulation.step(5, replace(hold(prepared.robot, 1.0, 1.0), posture=posture))
    assert not simulation.velocity.any()
    assert simulation.object_poses[0, :3, 3] == pytest.approx((1.0, 0.0, 0.0)), "nothing falls"


def test_fingers_press_on_a_kinematic_robot_without_moving_it():
    prepared = arm()
    robot = prepared.robot
    skin = prepared.skin
    simulation = Simulation(robot, skin, STILL)
    at = skin.taxel_point(150)
    simulation.apply(PokePressed(1, at, Finger(stiffness=1e9, speed=1e-8, max_force=4.0)))
    simulation.step(2000, hold(robot, 0.0, 0.0))
    assert np.array_equal(simulation.posture, robot.home)
    assert simulation.pokes[0].force == 4.0
    assert simulation.sense() @ skin.areas == pytest.approx(4.0, rel=1e-9)
    posture = robot.home + 0.05
    simulation.step(1, replace(hold(robot, 0.0, 0.0), posture=posture))
    configuration = Configuration(robot)
    configuration.update(posture)
    assert simulation.pokes[0].world_position == pytest.approx(
        configuration.pose(skin.link(at)).points(skin.position(at))
    )


def test_dynamics_start_from_the_current_state():
    simulation = Simulation(bar(), bar_skin(), STILL)
    command = replace(hold(bar(), 40.0, 6.0), posture=np.array([0.2]))
    simulation.step(5, command)
    simulation.step(5, command)
    simulation.use(Effects())
    assert simulation.posture[0] == 0.2
    simulation.step(1000, command)
    assert simulation.posture[0] == pytest.approx(0.2, abs=1e-9)
    simulation.use(STILL)
    simulation.step(1, replace(command, posture=np.array([0.3])))
    assert simulation.posture[0] == 0.3


PRESS = PokePressed(1, bar_skin().taxel_point(30), Finger(max_force=3.0))
OTHERS = (
    Effects(gravity="off"),
    Effects(contact="environment"),
    Effects(contact="self"),
    Effects(contact="all"),
    Effects(joint_limits=False),
    Effects(timestep=5e-4),
    Effects(fingers=True, friction=True),
    Effects(skin="off"),
    Effects(joint_friction=True),
    Effects(skin="depth", contact="all"),
    Effects(skin="foundation", contact="all"),
    Effects(integrator="discrete"),
    Effects(integrator="euler"),
    Effects(sensor=SensorEffects(noise=Noise())),
    Effects(skin="point"),
)


def moving(*, effects: Effects | None = None, things=()) -> Simulation:
    simulation = Simulation(bar(), bar_skin(), effects or Effects(), objects=things)
    simulation.apply(PRESS)
    simulation.step(300, hold(bar(), 5.0, 0.5))
    assert abs(simulation.velocity[0]) > 1e-3
    return simulation


@pytest.mark.sampled(5)
@pytest.mark.parametrize("other", OTHERS)
def test_changed_effects_keep_the_state_bitwise(other):
    simulation = moving(things=(thing("box", at=(5.0, 0.0, 5.0), mass=1.0),))
    before = simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force
    simulation.use(other)
    assert simulation.effects is other
    assert (simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force) == before
    simulation.use(Effects())
    assert (simulation.posture, simulation.velocity, simulation.time, simulation.pokes[0].force) == before
    one = moving(things=(thing("box", at=(5.0, 0.0, 5.0), mass=1.0),))
    two = simulation
    for run in (one, two):
        run.step(200, hold(bar(), 5.0, 0.5))
    assert np.array_equal(one.posture, two.posture), "and so is the future"
    assert np.array_equal(one.velocity, two.velocity)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("skin", ["point", "water-fill", "punch", "half-space", "foundation", "depth"])
def test_skin_switched_on_measures_existing_contacts(skin):
    weight = thing("sphere", at=(0.3, 0.0, 0.0398), mass=0.5, guided=True)
    effects = Effects(contact="environment", gravity="on", skin="off")
    simulation = Simulation(bar(hinged=False), bar_skin(), effects, objects=(weight,))
    simulation.step(500, no_command(bar(hinged=False)))
    assert not simulation.sense().any()
    simulation.use(replace(effects, skin=skin))
    simulation.step(500, no_command(bar(hinged=False)))
    felt = simulation.sense() @ bar_skin().areas
    assert felt == pytest.approx(0.5 * 9.81, rel=0.1) or (skin == "depth" and felt > 0)


def test_sensor_and_skin_model_do_not_change_the_physics():
    simulation = moving()
    model = simulation._model
    for effects in (Effects(sensor=SensorEffects(noise=Noise())), Effects(skin="point"), Effects(skin="off")):
        simulation.use(effects)
        assert simulation._model is model


def test_removed_object_keeps_its_pose_until_it_returns():
    ball = thing("sphere", at=(5.0, 0.0, 20.0), mass=1.0)
    on = Effects(contact="environment")
    off = Effects()
    simulation = Simulation(bar(), bar_skin(), on, objects=(ball,))
    simulation.step(500, hold(bar(), 1.0, 1.0))
    fallen = simulation.object_poses
    assert fallen[0, 2, 3] < 19.0
    simulation.use(off)
    assert np.array_equal(simulation.object_poses, fallen)
    simulation.step(500, hold(bar(), 1.0, 1.0))
    assert np.array_equal(simulation.object_poses, fallen), "what is off does not fall"
    simulation.use(on)
    assert np.array_equal(simulation.object_poses, fallen)
    simulation.step(100, hold(bar(), 1.0, 1.0))
    assert fallen[0, 2, 3] - simulation.object_poses[0, 2, 3] == pytest.approx(0.5 * 9.81 * 0.01, rel=0.02), "from rest"
    simulation.reset()
    assert simulation.object_poses[0, 2, 3] == 20.0


def test_switching_fingers_off_lifts_them_and_rejects_new_ones():
    simulation = moving()
    simulation.use(Effects(fingers=False))
    assert simulation.pokes == ()
    before = simulation.state()
    simulation.apply(PokeReleased(1))
    simulation.apply(PokeMoved(1, PRESS.at))
    assert np.array_equal(simulation.state(), before)
    with pytest.raises(SimulationError, match="fingers are off"):
        simulation.apply(PRESS)
    simulation.step(1, hold(bar(), 1.0, 1.0))
    assert not simulation._data.qfrc_applied.any(), "its force is gone with it"


def test_time_step_too_long_for_a_finger_is_rejected_without_changes():
    simulation = Simulation(bar(), bar_skin(), Effects())
    simulation.apply(PokePressed(1, bar_skin().taxel_point(30), Finger(stiffness=1e5)))
    before = simulation.state()
    model = simulation._model
    with pytest.raises(SimulationError, match="too stiff"):
        simulation.use(Effects(timestep=8e-3))
    assert np.array_equal(simulation.state(), before)
    assert simulation._model is model
    assert simulation.effects == Effects()
    simulation.step(10, hold(bar(), 1.0, 1.0))


def test_unchanged_sensor_effects_keep_their_state():
    creep = SensorEffects(hysteresis=Hysteresis())
    simulation = moving(effects=Effects(sensor=creep))
    simulation.sense()
    state = simulation._chain.state()
    assert state.any()
    simulation.use(Effects(sensor=replace(creep, noise=Noise()), contact="self"))
    assert [name for name, _ in simulation.readings] == ["touch", "hysteresis", "noise"]
    assert np.array_equal(simulation._chain.state()[: len(state)], state)


def test_hull_of_a_mesh_with_a_hollow_is_noted_with_its_distance():
    ball = thing("mesh").mesh
    hollow = Mesh(np.where(ball.vertices[:, 2:] > 0.0199, ball.vertices * [1, 1, 0.75], ball.vertices), ball.faces)
    body = thing("mesh", mesh=hollow, at=(5, 0, 0))
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(body,))
    (note,) = simulation.notes
    assert (note.kind, note.bodies) == (ContactNoteKind.CONVEX_HULL, ("mesh",))
    assert 0.003 < note.depth <= 0.005
    assert contact_note_text(note).startswith("mesh collides as its convex hull, up to 3.4 mm from its")
    simulation.use(Effects())
    assert simulation.notes == ()


@pytest.mark.parametrize("order", [("pokes", "object_poses"), ("object_poses", "pokes"), ()])
def test_position_queries_do_not_change_the_simulation(order):
    """Kinematics are computed on request; the order of the requests does not matter."""
    ball = thing("sphere", at=(0.2, 0.0, 0.04), mass=0.2)
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    simulation.apply(PRESS)
    seen = []
    for _ in range(60):
        simulation.step(5, hold(bar(), 50.0, 2.0))
        for name in order:
            getattr(simulation, name)
        seen.append(simulation.sense())
    assert np.any(seen[-1])
    reference = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    reference.apply(PRESS)
    for pressures in seen:
        reference.step(5, hold(bar(), 50.0, 2.0))
        assert np.array_equal(reference.sense(), pressures)
    assert np.array_equal(reference.state(), simulation.state())
