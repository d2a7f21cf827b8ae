"""The guard names the joint and the time at the first number that means nothing, and keeps the last good state."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from app.errors import SimulationError
from app.scene.effects import Effects
from app.simulation.guard import MAX_SPEED, Guard
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokePressed
from tests.things import thing
from tests.touch import arm, bar, bar_skin, no_command


@pytest.mark.parametrize("hooked", [False, True])
@pytest.mark.parametrize("torque", [1e12, -1e300, 1e7])
def test_the_first_bad_step_is_named_and_undone(torque, hooked, capfd):
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


def test_a_runaway_is_named_with_its_speed_and_energy():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects(joint_limits=False))
    simulation._data.qvel[:] = 0.999 * MAX_SPEED
    with pytest.raises(SimulationError, match=r"joint hinge at 0\.\d+ s.*velocity 1e\+03 a second") as caught:
        simulation.step(500, replace(no_command(robot), torque=np.array([10.0])))
    assert "energy before 2.67e+04 J" in str(caught.value), "half I w², I = 0.0535 kg m²"
    assert abs(simulation.velocity[0]) <= MAX_SPEED
    assert 0 < simulation.time < 0.4


def test_two_fast_joints_are_no_runaway():
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, Effects())
    guard = Guard(simulation._model, simulation._data)
    simulation._data.qvel[:] = 0.9 * MAX_SPEED
    assert guard.sound()
    simulation._data.qvel[3] = np.nan
    assert not guard.sound()


def test_an_object_that_runs_away_is_named():
    ball = thing("sphere", at=(5.0, 0.0, 0.0), mass=1.0)
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment"), objects=(ball,))
    simulation._data.xfrc_applied[simulation._model.body("object sphere").id, 1] = 1e7
    with pytest.raises(SimulationError, match="joint object sphere"):
        simulation.step(5, no_command(bar()))
    assert simulation.object_poses[0, :3, 3] == pytest.approx((5.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize("field", ["posture", "stiffness", "damping", "torque"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_command_that_is_no_number_is_refused_by_name(field, value):
    robot = arm().robot
    simulation = Simulation(robot, arm().skin, Effects())
    simulation.step(3, no_command(robot))
    before, asked = simulation.state(), np.zeros(7)
    asked[6] = value
    with pytest.raises(SimulationError, match=f"joint {robot.joints[6].name}.*asked for no number.*{field}"):
        simulation.step(1, replace(no_command(robot), **{field: asked}))
    assert np.array_equal(simulation.state(), before), "it never reached the physics"


def test_a_reset_makes_it_usable_again():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    before = simulation.state()
    with pytest.raises(SimulationError):
        simulation.step(1, replace(no_command(robot), torque=np.array([1e12])))
    simulation.reset()
    simulation.step(3, no_command(robot))
    assert np.isfinite(simulation.state()).all()
    simulation.reset()
    assert np.array_equal(simulation.state(), before)


def test_a_robot_without_joints_is_always_sound():
    robot = bar(hinged=False)
    simulation = Simulation(robot, bar_skin(), Effects())
    assert Guard(simulation._model, simulation._data).sound()
    assert mujoco.mjtDisableBit.mjDSBL_AUTORESET & simulation._model.opt.disableflags
