"""Contacts of the robot in another posture, under every contact model."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold


def on_the_way(posture: float) -> tuple[float, ...]:
    """Return the position of the end of the bar at a posture; the bar turns about y."""
    return (0.25 * float(np.cos(posture)), 0.0, -0.25 * float(np.sin(posture)))


@pytest.mark.parametrize("skin", ["water-fill", "foundation", "depth"])
def test_only_objects_in_contact_are_named(skin):
    block = thing("box", at=on_the_way(1.0))
    simulation = Simulation(bar(), bar_skin(), Effects(contact="environment", skin=skin), objects=(block,))
    before = simulation.state()
    assert simulation.touching(simulation.posture) == ""
    assert block.spec.name.replace("_", " ") in simulation.touching(np.array([1.0]))
    assert simulation.state().tobytes() == before.tobytes()


def test_no_object_is_named_without_contact():
    block = thing("box", at=on_the_way(1.0))
    simulation = Simulation(bar(), bar_skin(), Effects(contact="off"), objects=(block,))
    assert simulation.touching(np.array([1.0])) == ""
    simulation.use(Effects(contact="environment"))
    assert simulation.touching(np.array([1.0]))


def test_placed_robot_is_at_rest():
    simulation = Simulation(bar(), bar_skin(), Effects())
    simulation.step(20, hold(bar(), 3.0, 0.5))
    simulation.place(np.array([0.4]))
    assert simulation.posture.tolist() == [0.4]
    assert simulation.velocity.tolist() == [0.0]
