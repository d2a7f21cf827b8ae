"""Divergence, bad commands and objects that are too fast: stopped, and said where."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.simulation.step_checks import MAX_SPEED, DivergenceGuard, TunnellingCheck
from tactile_maps.tactile.mechanics.contact_notes import ContactNoteKind, contact_note_text
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.scene_objects import thing
from tests.support.touch import BAR_INERTIA, arm, bar, bar_skin, hold, no_command


@pytest.mark.parametrize("hooked", [False, True])
@pytest.mark.parametrize("torque", [1e12, -1e300, 1e7])
def test_first_bad_step_is_named_and_undone(torque, hooked, capfd):
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    if hooked:
        simulation.apply(PokePressed(1, bar_skin().taxel_point(5), Finger(speed=0.0)))
    simulation.step(4, no_command(robot))
    good = simulation.posture, simulation.velocity
    with pytest.raises(SimulationError, match=r"joint hinge at 0\.005 s") as caught:
        simulation.step(5, replace(no_command(robot), torque=np.array([torque])))
    assert caught.value.remedy
    assert "energy before 0 J" in str(caught.value)
    assert simulation.time == pytest.approx(0.004)
    assert (simulation.posture, simulation.velocity) == good
    assert capfd.readouterr() == ("", ""), "MuJoCo does not print what the guard raises"


def test_runaway_joint_is_named_with_its_speed_and_energy():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects(joint_limits=False))
    simulation._data.qvel[:] = 0.999 * MAX_SPEED
    with pytest.raises(SimulationError, match=r"joint hinge at 0\.\d+ s.*velocity 1e\+03 a second") as caught:
        simulation.step(500, replace(no_command(robot), torque=np.array([10.0])))
    assert "energy before 2.67e+04 J" in str(caught.value), "half I w², I = 0.0535 kg m²"
    assert abs(simulation.velocity[0]) <= MAX_SPEED
    assert 0 < simulation.time < 0.4


def test_two_fast_joints_do_not_count_as_divergence():
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, Effects())
    guard = DivergenceGuard(simulation._model, simulation._data)
    simulation._data.qvel[:] = 0.9 * MAX_SPEED
    assert guard.sound()
    simulation._data.qvel[3] = np.nan
    assert not guard.sound()


def test_diverging_object_is_named():
    ball = thing("sphere", at=(5.0, 0.0, 0.0), mass=1.0)
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    simulation._data.xfrc_applied[simulation._model.body("tactile-maps/object sphere").id, 1] = 1e7
    with pytest.raises(SimulationError, match="joint sphere at"):
        simulation.step(5, no_command(bar()))
    assert simulation.object_poses[0, :3, 3] == pytest.approx((5.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("field", ["posture", "stiffness", "damping", "torque"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_invalid_command_is_rejected_by_name(field, value):
    robot = arm().robot
    simulation = Simulation(robot, arm().skin, Effects())
    simulation.step(3, no_command(robot))
    before = simulation.state()
    requested = np.zeros(7)
    requested[6] = value
    with pytest.raises(SimulationError, match=f"joint {robot.joints[6].name}.*output is not finite.*{field}"):
        simulation.step(1, replace(no_command(robot), **{field: requested}))
    assert np.array_equal(simulation.state(), before), "it never reached the physics"


EFFECTS = Effects(contact="environment", timestep=0.001)


def falling(*, height: float, speed: float, kind: str = "sphere", **said):
    """A body above the bar's middle that falls with ``speed``; the watch and the state."""
    body = thing(kind, at=(0.2, 0.0, height), mass=1.0, **said)
    model = assemble(bar(), bar_skin(), EFFECTS, objects=(body,))
    data = mujoco.MjData(model)
    data.qvel[-4 if model.nv > 6 else -1] = -speed
    mujoco.mj_kinematics(model, data)
    return TunnellingCheck(model, (body,)), data


@pytest.mark.parametrize(("height", "speed"), [(0.1, 30.0), (5.0, 100.0), (-0.5, 1.0)])
def test_slow_or_distant_bodies_continue(height, speed):
    """The ball reaches 20 mm and the bar is 40 mm thick: 30 mm a step cannot carry it past the middle."""
    watch, data = falling(height=height, speed=speed)
    assert watch.needed
    watch.check(data, 5)


def test_fast_body_near_the_bar_stops_the_run_with_a_sufficient_time_step():
    watch, data = falling(height=0.1, speed=60.0)
    before = data.qpos.copy()
    with pytest.raises(SimulationError, match=r"sphere near bar.*60 m/s, 60 mm a step.*at most 0\.67 ms"):
        watch.check(data, 1)
    np.testing.assert_array_equal(data.qpos, before)


def test_check_covers_the_whole_call():
    watch, data = falling(height=0.65, speed=60.0)
    watch.check(data, 1)
    with pytest.raises(SimulationError, match="too fast"):
        watch.check(data, 10)


def test_fast_body_above_a_floor_does_not_stop_the_run():
    ball = thing("sphere", at=(2.0, 0.0, 0.1), mass=1.0)
    floor = thing("plane", at=(0.0, 0.0, 0.0))
    model = assemble(bar(), bar_skin(), EFFECTS, objects=(ball, floor))
    data = mujoco.MjData(model)
    data.qvel[-4] = -100.0
    mujoco.mj_kinematics(model, data)
    TunnellingCheck(model, (ball,)).check(data, 1)


def test_object_made_fast_by_a_motor_stops_the_run_after_the_step():
    """The probe is at rest at the start of the call, and its motors drive it into the bar at 200 m/s."""
    path = ((0.0, 0.2, 0.0, 0.5), (0.005, 0.2, 0.0, -0.5), (60.0, 0.2, 0.0, -0.5))
    probe = thing("probe", size=(0.005,), at=path[0][1:], mass=0.01, max_force=1e4, path=path)
    simulation = Simulation(bar(), bar_skin(), replace(EFFECTS, contact="probe"), objects=(probe,))
    with pytest.raises(SimulationError, match=r"probe near bar"):
        simulation.step(100, no_command(bar()))
    assert simulation.object_poses[0, 2, 3] > 0, "still on its own side"


def servo_notes(simulation) -> list:
    return [note for note in simulation.notes if note.kind is ContactNoteKind.UNSTABLE_SERVO]


def test_servos_too_stiff_for_euler_are_reported_beyond_its_limit():
    """A joint with damping alone: its rate times the step is at most 2."""
    robot = bar()
    step = 0.01
    integrator = "euler"
    most = 2.0
    simulation = Simulation(robot, bar_skin(), Effects(integrator=integrator, timestep=step))
    simulation.step(1, hold(robot, 0.0, 0.99 * most / step * BAR_INERTIA))
    assert servo_notes(simulation) == []
    simulation.step(1, hold(robot, 0.0, 1.02 * most / step * BAR_INERTIA))
    (note,) = servo_notes(simulation)
    assert note.bodies == ("hinge",)
    assert note.max_timestep == pytest.approx(step / 1.02, rel=1e-3)
    assert "at most 9.8 ms" in contact_note_text(note)
    simulation.use(Effects(integrator=integrator, timestep=0.009))
    assert servo_notes(simulation) == [], "that was short enough"


def test_servo_without_damping_is_noted_beyond_the_explicit_limit():
    """Semi-implicit Euler holds a spring while its frequency times the step is below 2."""
    robot = bar()
    step = 0.01
    simulation = Simulation(robot, bar_skin(), Effects(integrator="euler", timestep=step))
    for share, reported in ((0.97, 0), (1.03, 1), (0.97, 0)):
        simulation.step(1, hold(robot, (share * 2.0 / step) ** 2 * BAR_INERTIA, 0.0))
        assert len(servo_notes(simulation)) == reported


@pytest.mark.parametrize("integrator", ["implicitfast", "implicit", "discrete"])
def test_implicit_integrators_accept_the_same_servos(integrator):
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects(integrator=integrator, timestep=0.01))
    simulation.step(100, hold(robot, 0.0, 1e3 * BAR_INERTIA))
    assert servo_notes(simulation) == []
    assert np.abs(simulation.velocity).max() < 1e-9


def near_wall(integrator: str = "implicitfast", *, thickness: float = 0.004, step: float = 0.01) -> Simulation:
    """Return the bar on its hinge, a quarter turn from a thin wall in its path."""
    wall = thing("box", name="wall", size=(0.1, 0.4, thickness), at=(0.25, 0.0, -0.25), turn=(0.0, 45.0, 0.0))
    effects = Effects(contact="environment", joint_limits=False, integrator=integrator, timestep=step)
    return Simulation(bar(), bar_skin(), effects, objects=(wall,))


def swing(simulation: Simulation, speed: float) -> None:
    simulation._data.qvel[0] = speed
    simulation._physics.forward()
    for _ in range(40):
        simulation.step(1, no_command(bar()))


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_link_too_fast_for_a_fixed_object_stops_the_run(integrator):
    """The bar's tip moves 80 mm per step at 20 rad/s; half the bar and half the wall are 22 mm."""
    simulation = near_wall(integrator)
    with pytest.raises(SimulationError, match=r"bar near wall at 0\.\d+ s: a link is too fast") as caught:
        swing(simulation, 20.0)
    assert simulation.posture[0] < np.pi / 4, "not there yet"
    assert "time step of at most" in str(caught.value.remedy)


def test_suggested_time_step_for_a_fast_link_is_sufficient():
    simulation = near_wall(step=0.001)
    swing(simulation, 20.0)
    assert np.abs(simulation.posture[0]) < np.pi / 4, "it has met the wall and was held"


def test_slow_or_distant_link_does_not_stop_the_run():
    swing(near_wall(), 1.0)
    simulation = Simulation(
        bar(),
        bar_skin(),
        Effects(contact="environment", joint_limits=False, timestep=0.01),
        objects=(thing("box", at=(3.0, 0.0, 0.0)),),
    )
    swing(simulation, 20.0)
