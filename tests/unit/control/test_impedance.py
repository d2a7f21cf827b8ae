"""The impedance law: home, always, with the stiffness asked for."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.impedance import ImpedancePosture
from tests.touch import BAR_INERTIA, bar


def test_it_holds_home_whatever_the_posture():
    robot = bar()
    law = ImpedancePosture(robot)
    settings = ControlSettings(stiffness=5.0, damping_ratio=0.5)
    for posture in (np.zeros(1), np.ones(1)):
        command = law.command(settings, posture, posture, (), 0.005)
        assert np.array_equal(command.posture, robot.home)
        assert command.stiffness == pytest.approx(25 * BAR_INERTIA)
        assert command.damping == pytest.approx(2 * 0.5 * 5 * BAR_INERTIA)
    law.reset()
    assert law.why_limited == ()


def test_it_holds_the_rest_posture_it_is_given():
    law = ImpedancePosture(bar())
    law.rest = np.array([0.4])
    assert law.command(ControlSettings(), np.zeros(1), np.zeros(1), (), 0.005).posture == [0.4]
    law.reset()
    assert law.rest == [0.4]


def test_a_robot_without_joints_gets_an_empty_command():
    empty = np.zeros(0)
    assert ImpedancePosture(bar(hinged=False)).command(ControlSettings(), empty, empty, (), 0.005).posture.shape == (0,)
