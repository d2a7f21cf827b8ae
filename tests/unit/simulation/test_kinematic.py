"""Without dynamics the robot is where it is asked to be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.robots.configuration import Configuration
from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from app.touch.poke import Finger, PokePressed
from tests.things import thing
from tests.touch import arm, bar, bar_skin, hold

STILL = Effects(dynamics=False, contact="all")


def test_the_posture_is_the_commands_and_time_passes():
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


def test_fingers_ride_on_it_and_press_without_moving_it():
    prepared = arm()
    robot, skin = prepared.robot, prepared.skin
    simulation, at = Simulation(robot, skin, STILL), skin.taxel_point(150)
    simulation.apply(PokePressed(1, at, Finger(stiffness=1e9, speed=1e-8, max_force=4.0)))
    simulation.step(2000, hold(robot, 0.0, 0.0))
    assert np.array_equal(simulation.posture, robot.home)
    assert simulation.pokes[0].force == 4.0
    assert simulation.sense() @ skin.areas == pytest.approx(4.0, rel=1e-9)
    posture = robot.home + 0.05
    simulation.step(1, replace(hold(robot, 0.0, 0.0), posture=posture))
    configuration = Configuration(robot)
    configuration.update(posture)
    assert simulation.pokes[0].point == pytest.approx(configuration.pose(skin.link(at)).points(skin.position(at)))


def test_a_posture_that_is_no_number_is_refused():
    simulation = Simulation(bar(), bar_skin(), STILL)
    with pytest.raises(SimulationError, match="asked for no number"):
        simulation.step(1, replace(hold(bar(), 1.0, 1.0), posture=np.array([np.nan])))
    assert simulation.time == 0


def test_dynamics_take_over_where_it_is():
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
