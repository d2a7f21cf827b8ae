"""Every law answers the same question."""

from __future__ import annotations

import inspect

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.hold_force import HoldForce
from app.control.impedance import ImpedancePosture
from app.control.law import Law
from tests.touch import arm


@pytest.mark.parametrize("kind", [ImpedancePosture, HoldForce])
def test_a_law_keeps_the_protocol(kind):
    robot = arm().robot
    law: Law = kind(robot)
    assert list(inspect.signature(kind.command).parameters) == list(inspect.signature(Law.command).parameters)
    law.reset()
    command = law.command(ControlSettings(), robot.home, np.zeros(7), (), 0.005)
    assert np.array_equal(command.posture, robot.home), "at home, untouched, it wants to stay"
    assert (command.stiffness > 0).all()
    assert (command.damping > 0).all()
    assert law.why_limited == ()
    assert np.array_equal(law.rest, robot.home)
