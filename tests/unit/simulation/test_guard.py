"""The guard names the joint and the time at the first number that means nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.simulation.effects import Effects
from app.simulation.simulation import Simulation
from tests.touch import arm, bar, bar_skin, no_command


@pytest.mark.parametrize("torque", [np.nan, np.inf, 1e12, -1e300])
def test_the_first_bad_step_is_named(torque):
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    simulation.step(4, no_command(robot))
    with pytest.raises(SimulationError, match=r"joint hinge at 0\.005 s") as caught:
        simulation.step(5, replace(no_command(robot), torque=np.array([torque])))
    assert caught.value.remedy
    assert simulation.time == pytest.approx(0.005), "the state is kept as it was then"


def test_the_first_bad_joint_of_many_is_named():
    robot = arm().robot
    torque = np.zeros(7)
    torque[6] = np.inf
    with pytest.raises(SimulationError, match=r"0\.001 s"):
        Simulation(robot, arm().skin, Effects()).step(1, replace(no_command(robot), torque=torque))


def test_a_reset_makes_it_usable_again():
    robot = bar()
    simulation = Simulation(robot, bar_skin(), Effects())
    before = simulation.state()
    with pytest.raises(SimulationError):
        simulation.step(1, replace(no_command(robot), torque=np.array([np.nan])))
    simulation.reset()
    simulation.step(3, no_command(robot))
    assert np.isfinite(simulation.state()).all()
    simulation.reset()
    assert np.array_equal(simulation.state(), before)
