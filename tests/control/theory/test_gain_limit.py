"""The predicted gain limit of whole robots against a measured one."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.control.gain_limits import GAIN_SHARE
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import LimitKind
from tactile_maps.session.inputs import ControlChanged
from tactile_maps.session.session import skin_readings
from tactile_maps.studies.testbeds.fixed_ball import forearm_skin_scene, with_fixed_ball
from tactile_maps.studies.testbeds.force_loop import force_loop_at_goal, predicted_gain_limit
from tactile_maps.studies.testbeds.path_following import PathSetup
from tactile_maps.tactile.sensors.sensor_effects import Sampling, SensorEffects
from tests.support.loop_trials import gain_of_whole_arm, measured_gain_limit
from tests.support.pressed_arm import forearm


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["hybrid", "parallel"])
def test_force_oscillates_from_the_predicted_gain_on(controller):
    settings = ControlSettings(controller=controller, task="hold_point", force_gain=0.002)
    setup = PathSetup(with_fixed_ball(forearm()))
    predicted = predicted_gain_limit(force_loop_at_goal(setup, settings), settings)
    assert measured_gain_limit(setup, settings, predicted, steps=3) == pytest.approx(predicted, rel=0.1)


@pytest.mark.long  # up to 60 s a case
@pytest.mark.parametrize("controller", ["hybrid", "admittance", "parallel"])
@pytest.mark.parametrize("robot", ["arm", "ur5e", "icub"])
def test_gain_limit_is_as_predicted_on_every_robot(robot, controller):
    measured, _, predicted = gain_of_whole_arm({"robot": robot, "controller": controller, "seed": 0})
    assert measured == pytest.approx(predicted, rel=0.1)


READINGS = {"every 5 ms": None, "20 Hz": Sampling(20.0, 0.0), "20 Hz, one late": Sampling(20.0, 0.05)}


def limit_at_run_time(setup: PathSetup, controller: str, *, ticks: int) -> tuple[ControlSettings, float]:
    """Return the limited settings after an approach from a light touch, and the gain limit of the session [m/s/N]."""
    requested = ControlSettings(controller=controller, task="hold_point", force_gain=0.05, force_goal=3.0)
    session = setup.session(replace(requested, force_goal=1.5))
    held = None
    for tick in range(ticks):
        if tick == ticks // 3:
            session.submit(ControlChanged(requested))
        frame = session.tick()
        held = next((limit for limit in frame.why_limited if limit.kind is LimitKind.FORCE_GAIN_HELD), None)
    assert held is not None
    readings = skin_readings(setup.effects, setup.prepared.scene.tick)
    wait = readings.period + readings.delay
    as_limited = replace(
        requested, integral_time=max(0.3, 12 * wait), position_gain=min(4.0, 0.3 / wait), gains="as_given"
    )
    return as_limited, held.value / GAIN_SHARE


@pytest.mark.long
def test_limit_at_run_time_matches_the_true_contact():
    """The nominal contact is stiffer than this one: its limit would be half of the true one."""
    setup = PathSetup(with_fixed_ball(forearm()), sensor=SensorEffects(sampling=Sampling(20.0, 0.0)))
    _, found = limit_at_run_time(setup, "hybrid", ticks=360)
    assert found == pytest.approx(0.0057, rel=0.1), "measured, see the next test"


@pytest.mark.long  # up to 60 s a case
@pytest.mark.parametrize("readings", READINGS)
@pytest.mark.parametrize("controller", ["hybrid"])
@pytest.mark.parametrize("robot", ["arm", "ur5e", "icub"])
def test_limit_at_run_time_is_near_the_measured_one(robot, controller, readings):
    """Within a tenth."""
    sensor = SensorEffects(sampling=READINGS[readings])
    setup = PathSetup(with_fixed_ball(forearm_skin_scene(robot, 600)), sensor=sensor)
    settings, found = limit_at_run_time(setup, controller, ticks=900)
    assert found == pytest.approx(measured_gain_limit(setup, settings, found), rel=0.1)
