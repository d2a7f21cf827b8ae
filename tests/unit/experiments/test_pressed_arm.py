"""The scene of the experiments in time: the probe reaches the skin, presses as it should, and can be made again."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.pressed_arm import ARRIVED, PRESS, pressed_arm
from app.robots.configuration import Configuration
from app.scene.effects import Effects
from app.scene.stability import PROBE
from app.simulation.simulation import Simulation

ARM = pressed_arm(120)
EFFECTS = Effects(gravity="off", contact="probe", fingers=False)


def test_the_probe_starts_off_the_skin_and_goes_straight_in_along_an_axis():
    first, last = np.array(ARM.probe.spec.path)[[0, -1], 1:]
    way = last - first
    assert np.count_nonzero(np.abs(way) > 1e-12) == 1
    touched = Configuration(ARM.robot).pose("forearm").points(ARM.skin.position(ARM.at)[None])[0]
    assert np.linalg.norm(first - touched) == pytest.approx(ARM.probe.spec.size[0] + 0.002)
    assert ARM.probe.spec.mass == PROBE


def test_it_presses_as_hard_as_its_motors_may():
    simulation = Simulation(ARM.robot, ARM.skin, EFFECTS, objects=(ARM.probe,))
    simulation.step(1, ARM.command)
    assert not simulation.sense().any(), "it starts in the air"
    simulation.step(round((5 * ARRIVED) / EFFECTS.timestep), ARM.command)
    pressures = simulation.sense()
    assert float(pressures @ ARM.skin.areas) == pytest.approx(PRESS, rel=0.05)
    assert ARM.skin.patches[ARM.skin.patch_of[pressures.argmax()]].link == "forearm"


def test_the_arm_gives_way_and_stays_near_home():
    simulation = Simulation(ARM.robot, ARM.skin, EFFECTS, objects=(ARM.probe,))
    simulation.step(500, ARM.command)
    moved = np.abs(simulation.posture - ARM.robot.home).max()
    assert 1e-3 < moved < 0.2


def test_it_is_made_once_and_the_same_each_time():
    assert pressed_arm(120) is ARM
    pressed_arm.cache_clear()
    again = pressed_arm(120)
    assert again is not ARM
    assert again.at == ARM.at
    assert again.probe.spec == ARM.probe.spec
