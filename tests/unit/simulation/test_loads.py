"""Loads: what presses, as values; contacts between links press both."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import SimulationError
from app.simulation.effects import Effects
from app.simulation.loads import Load
from app.simulation.simulation import Simulation
from tests.touch import hold, pair


@pytest.mark.parametrize(("force", "radius"), [(-1.0, 0.01), (float("nan"), 0.01), (float("inf"), 0.01), (1.0, 0.0)])
def test_a_load_that_cannot_be_is_refused(force, radius):
    with pytest.raises(SimulationError, match="no such load"):
        Load("bar", np.zeros(3), np.array([0, 0, 1.0]), force, radius)


def test_two_links_that_touch_both_feel_the_force_between_them():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    command = replace(hold(robot, 0.0, 40.0), torque=np.array([7.0]))
    simulation.step(3000, command)
    assert abs(simulation.velocity[0]) < 1e-6, "at rest, so the contact carries the push"
    assert simulation.posture[0] == pytest.approx(0.03, abs=2e-3)
    force = simulation.sense() * skin.areas
    first = skin.first[1]
    assert force[:first].sum() == pytest.approx(7.0, rel=1e-4)
    assert force[first:].sum() == pytest.approx(force[:first].sum(), rel=1e-12)


def test_links_apart_feel_nothing():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self"))
    simulation.step(10, hold(robot, 10.0, 1.0))
    assert not simulation.sense().any()


def test_without_the_effect_links_pass_through_each_other():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="off"))
    simulation.step(3000, replace(hold(robot, 0.0, 40.0), torque=np.array([7.0])))
    assert simulation.posture[0] > 0.045
    assert not simulation.sense().any()
