"""Commands and settings as values."""

from __future__ import annotations

import numpy as np

from app.control.command import ControlSettings, JointCommand


def test_a_command_owns_its_arrays():
    posture = np.zeros(2)
    command = JointCommand(posture, posture, posture, posture)
    posture[0] = 1
    assert command.posture[0] == 0
    assert not command.torque.flags.writeable


def test_settings_compare_by_value():
    assert ControlSettings() == ControlSettings(law="impedance")
    assert ControlSettings(force_goal=5.0) != ControlSettings()
