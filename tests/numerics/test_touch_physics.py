"""Laws of touch on the whole arm: energy, refinement of the time step, rest after release."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from app.robots.configuration import Configuration
from app.scene.effects import Effects
from app.session.session import Session
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokePressed, PokeReleased
from tests.touch import arm, hold, no_command

TAXELS = (20, 120, 170, 200, 290)


def free_arm(taxel: int, *, timestep: float) -> tuple[Simulation, float]:
    """The arm without any loss, thrown against a standing finger; and the finger's stiffness."""
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, Effects("off", "off", False, timestep))
    simulation._model.dof_damping[:] = simulation._model.dof_frictionloss[:] = 0
    simulation._model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    at = prepared.skin.taxel_point(taxel)
    configuration, link = Configuration(prepared.robot), prepared.skin.link(at)
    outward = configuration.pose(link).rotation @ prepared.skin.normal(at)
    row = outward @ configuration.jacobian(link, prepared.skin.position(at))
    simulation.apply(PokePressed(1, at, Finger(stiffness=300.0, speed=0.0, max_force=1e6)))
    simulation._data.qvel[:] = 0.6 * row / np.linalg.norm(row) + 0.3 * np.cos(np.arange(7))
    return simulation, 300.0


@pytest.mark.parametrize("taxel", TAXELS)
def test_a_standing_finger_gives_back_what_it_took(taxel):
    """Kinetic energy and ½ k depth² stay constant however the arm turns under the finger."""
    command = no_command(arm().robot)
    for timestep, drift in ((1e-3, 1e-2), (2.5e-4, 2.5e-3)):
        simulation, stiffness = free_arm(taxel, timestep=timestep)
        energy, forces = [], []
        for _ in range(round(3.0 / timestep / 10)):
            simulation.step(10, command)
            forces.append(simulation.pokes[0].force)
            energy.append(simulation._data.energy[1] + 0.5 * forces[-1] ** 2 / stiffness)
        assert max(forces) > 1, "the arm did run into the finger"
        assert np.abs(np.array(energy) / energy[0] - 1).max() < drift


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


@pytest.mark.parametrize("taxel", TAXELS)
def test_after_release_the_arm_loses_energy_and_comes_home(taxel):
    session = Session(arm(), scripted=False)
    session.submit(PokePressed(1, arm().skin.taxel_point(taxel), Finger(max_force=6.0)))
    for _ in range(300):
        frame = session.tick()
    assert np.abs(frame.posture - arm().robot.home).max() > 5e-3, "it yielded"
    session.submit(PokeReleased(1))
    model, data = session._simulation._model, session._simulation._data
    energy, mass = [], np.zeros((7, 7))
    for _ in range(800):
        frame = session.tick()
        mujoco.mj_fullM(model, data, mass)
        bent = frame.posture - frame.command.posture
        energy.append(0.5 * frame.velocity @ mass @ frame.velocity + 0.5 * bent @ (frame.command.stiffness * bent))
    energy = np.array(energy)
    assert (np.diff(energy) <= 1e-4 * energy[0]).all()
    assert energy[-1] < 1e-8 * energy[0]
    assert frame.posture == pytest.approx(arm().robot.home, abs=1e-4)


def test_a_finger_pressed_hard_anywhere_never_makes_a_number_that_means_nothing():
    session = Session(arm(), scripted=False)
    for k, taxel in enumerate(range(0, 300, 12)):
        session.submit(PokePressed(k + 1, arm().skin.taxel_point(taxel), Finger(speed=0.5, max_force=200.0)))
    for _ in range(400):
        frame = session.tick()
    for values in (frame.posture, frame.velocity, frame.pressures):
        assert np.isfinite(values).all()
    assert frame.pressures @ arm().skin.areas == pytest.approx(sum(p.force for p in frame.pokes), rel=1e-9)
