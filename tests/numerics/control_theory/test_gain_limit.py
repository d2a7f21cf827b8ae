"""The predicted gain limit of whole robots against a measured one."""

from __future__ import annotations

import pytest

from app.control.command import ControlSettings
from app.studies.testbeds.force_loop import force_loop_at_goal, predicted_gain_limit
from app.studies.testbeds.path_following import PathSetup, beside_ball
from tests.numerics.control_theory.predictions import gain_of_whole_arm
from tests.numerics.control_theory.step_tests import measured_gain_limit
from tests.support.pressed_arm import forearm


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["hybrid", "parallel"])
def test_the_force_swings_from_the_gain_on_that_was_predicted(controller):
    settings = ControlSettings(controller=controller, task="hold_point", force_gain=0.002)
    setup = PathSetup(beside_ball(forearm()))
    predicted = predicted_gain_limit(force_loop_at_goal(setup, settings), settings)
    assert measured_gain_limit(setup, settings, predicted, steps=3) == pytest.approx(predicted, rel=0.1)


@pytest.mark.long  # up to 60 s a case
@pytest.mark.parametrize("controller", ["hybrid", "admittance", "parallel"])
@pytest.mark.parametrize("robot", ["arm", "ur5e", "icub"])
def test_so_it_does_on_every_robot(robot, controller):
    measured, _, predicted = gain_of_whole_arm({"robot": robot, "controller": controller, "seed": 0})
    assert measured == pytest.approx(predicted, rel=0.1)
