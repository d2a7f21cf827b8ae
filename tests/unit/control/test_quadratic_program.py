"""The quadratic program where its bounds do not bind: damped where a direction is weak, as least squares are."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.levels import Level, solve_levels
from app.control.quadratic_program import QuadraticProgram
from app.control.reference import WEAK, PostureReference
from app.control.rule import ArmState
from tests.touch import bar

REST = np.zeros(3)


def answer(levels: list[Level]) -> np.ndarray:
    reference = PostureReference(bar(), np.ones(1))
    reference.lower, reference.upper = np.full(3, -9.0), np.full(3, 9.0)
    arm = ArmState(REST, REST, REST, reference, (), 1.0)
    return QuadraticProgram().solve(levels, ControlSettings(law="qp"), (), arm, [])


@pytest.mark.parametrize("gain", [0.01, 0.05, 0.1, 0.9 * WEAK])
def test_a_weak_direction_is_damped_as_in_least_squares(gain):
    """Undamped it would ask for 0.05 m/s over the gain: 5 rad/s at the weakest."""
    outward, along = np.array([[gain, 0.0, 0.0]]), np.array([[0.0, 0.5, 0.0]])
    levels = [Level(outward, np.array([0.05])), Level(along, np.array([0.02]))]
    wanted, damped = solve_levels(levels, REST)
    assert damped
    assert answer(levels) == pytest.approx(wanted, rel=0.05, abs=1e-3)
    assert abs(answer(levels)[0]) < 0.7


def test_a_strong_one_is_not():
    levels = [Level(np.array([[1.5 * WEAK, 0.0, 0.0]]), np.array([0.05]))]
    assert answer(levels)[0] == pytest.approx(0.05 / (1.5 * WEAK), rel=1e-3)
