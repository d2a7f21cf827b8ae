"""MuJoCo's tactile sensor against the depth of a ball, a box and a mesh known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold, no_command, pair

SKIN = bar_skin(400)
EFFECTS = Effects(contact="environment", skin="depth")
TAXELS = SKIN.patches[0].taxels.positions


def pressed(kind: str, centre: tuple[float, float, float], **said) -> Simulation:
    """The hinged bar held still by hand, touched by something fixed."""
    simulation = Simulation(bar(), SKIN, EFFECTS, objects=(thing(kind, at=centre, **said),))
    simulation.reset()
    assert simulation._data.ncon
    return simulation


@pytest.mark.long
def test_depth_of_a_ball_is_correct_at_every_taxel():
    centre = np.array([0.21, 0.004, 0.0385])
    inside = np.maximum(0.02 - np.linalg.norm(TAXELS - centre, axis=1), 0)
    assert (inside > 0).sum() >= 2
    simulation = pressed("sphere", tuple(centre))
    assert simulation.sense() == pytest.approx(ElasticLayer().foundation * inside, abs=ElasticLayer().foundation * 1e-7)


@pytest.mark.long
def test_depth_of_a_box_is_correct_at_every_taxel():
    simulation = pressed("box", (0.21, 0.0, 0.0299))
    under = (np.abs(TAXELS[:, 0] - 0.21) < 0.0299) & (np.abs(TAXELS[:, 1]) < 0.0249)
    assert under.sum() > 10
    assert simulation.sense()[under] == pytest.approx(ElasticLayer().foundation * 1e-4, rel=0.02), "MuJoCo rounds edges"


@pytest.mark.long
def test_depth_of_a_mesh_is_not_zero():
    """A colliding mesh without a signed distance reads 0 in MuJoCo, silently."""
    centre = np.array([0.21, 0.004, 0.0385])
    ball = pressed("sphere", tuple(centre))
    mesh = pressed("mesh", tuple(centre))
    assert mesh.sense().max() == pytest.approx(ball.sense().max(), rel=0.2)
    assert mesh.notes == (), "the ball is convex"


@pytest.mark.long
def test_both_links_in_contact_have_readings():
    robot, skin = pair()
    simulation = Simulation(robot, skin, Effects(contact="self", skin="depth"))
    command = hold(robot, 0.0, 40.0)
    simulation.step(3000, type(command)(command.posture, command.stiffness, command.damping, np.array([7.0])))
    deep = simulation.posture[0] - 0.03
    assert deep == pytest.approx(7.0 / 1e4, rel=1e-5)
    inner = np.concatenate([np.abs(p.taxels.positions[:, 1:]).max(axis=1) < 0.045 for p in skin.patches])
    assert simulation.sense()[inner] == pytest.approx(ElasticLayer().foundation * deep, rel=0.02)


@pytest.mark.long
def test_finger_penetrates_the_skin_as_deep_as_its_force_requires():
    robot = bar(hinged=False)
    simulation = Simulation(robot, SKIN, EFFECTS)
    at = SKIN.taxel_point(200)
    simulation.apply(PokePressed(1, at, Finger(max_force=3.0)))
    simulation.step(1000, no_command(robot))
    pressures = simulation.sense()
    assert pressures.argmax() == 200
    assert pressures[200] == pytest.approx(ElasticLayer().foundation * 3.0 / ElasticLayer().stiffness)
