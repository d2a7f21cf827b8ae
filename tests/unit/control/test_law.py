"""Every law answers the same question."""

from __future__ import annotations

import inspect
from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.law import Law
from app.control.laws import build_law
from app.control.map_sight import MapSight
from app.control.settings_check import CHOICES
from app.control.task_keeper import TaskKeeper
from tests.touch import arm, prepared_bar
from tests.unit.control.touched import TICK, touch, touch_on


def law_of(name, prepared) -> Law:
    return build_law(name, prepared.robot, TaskKeeper(), MapSight(prepared.map))


@pytest.mark.parametrize("name", CHOICES["law"])
def test_a_law_keeps_the_protocol(name):
    robot, law = arm().robot, law_of(name, arm())
    for method in ("reset", "start", "command"):
        said, wanted = (inspect.signature(getattr(kind, method)).parameters for kind in (type(law), Law))
        assert list(said) == list(wanted)
    law.reset()
    command = law.command(ControlSettings(law=name), robot.home, np.zeros(7), (), TICK)
    assert np.array_equal(command.posture, robot.home), "at home, untouched, it wants to stay"
    assert (command.stiffness > 0).all()
    assert (command.damping > 0).all()
    assert law.why_limited == ()
    assert np.array_equal(law.rest, robot.home)


@pytest.mark.parametrize("name", [law for law in CHOICES["law"] if law != "impedance"])
def test_too_much_force_moves_the_point_inwards_and_too_little_outwards(name):
    for force, sign in ((6.0, 1), (1.0, -1)):
        law = law_of(name, prepared_bar())
        for _ in range(20):
            command = law.command(ControlSettings(law=name), np.zeros(1), np.zeros(1), touch(force), TICK)
        assert sign * command.posture[0] > 1e-4, "down, away from the finger, is positive about +y"


@pytest.mark.parametrize("task", CHOICES["task"])
@pytest.mark.parametrize("name", CHOICES["law"])
def test_every_law_does_every_task_within_its_bounds(name, task):
    prepared, settings = arm(), ControlSettings(law=name, task=task, force_goal=3.0)
    law, posture = law_of(name, prepared), prepared.robot.home
    taxel = int(prepared.skin.first[1]) + 40
    for tick in range(60):
        regions = (touch_on(prepared.map, taxel, 1.0 + 0.2 * tick),) if tick < 50 else ()
        command = law.command(settings, posture, np.zeros(7), regions, TICK)
        assert np.isfinite(command.torque_at(posture, np.zeros(7))).all()
        assert np.abs(command.posture - posture).max() < 0.31
    assert all(isinstance(why, str) for why in law.why_limited)


@pytest.mark.parametrize("name", CHOICES["law"])
def test_a_robot_without_joints_gets_an_empty_command(name):
    law, empty = law_of(name, prepared_bar(hinged=False)), np.zeros(0)
    for regions in ((), touch(9.0), ()):
        assert law.command(replace(ControlSettings(), law=name), empty, empty, regions, TICK).posture.shape == (0,)
