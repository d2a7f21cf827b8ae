"""One frequency gives every joint its stiffness."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.gains import MIN_INERTIA, joint_impedance, joint_limits
from tests.touch import arm, bar


def test_stiffness_and_damping_are_those_of_a_second_order_joint():
    command = joint_impedance(np.array([2.0, 0.5]), np.zeros(2), frequency=3.0, damping_ratio=0.7)
    assert command.stiffness == pytest.approx([18.0, 4.5])
    assert command.damping == pytest.approx(2 * 0.7 * np.sqrt(command.stiffness * [2.0, 0.5]))
    assert not command.torque.any()


def test_a_weightless_joint_still_holds():
    command = joint_impedance(np.zeros(1), np.zeros(1), frequency=10.0, damping_ratio=1.0)
    assert command.stiffness[0] == pytest.approx(100 * MIN_INERTIA)


def test_limits_in_posture_order():
    lower, upper = joint_limits(arm().robot)
    assert lower.shape == upper.shape == (7,)
    assert (lower < upper).all()
    assert [side.shape for side in joint_limits(bar(hinged=False))] == [(0,), (0,)]
