"""The supervisor stops for what is not safe, and lets go when all is quiet."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.supervisor import QUIET, STOP_SPEED, Supervisor
from tests.unit.control.touched import TICK, touch

STILL, BENT = np.zeros(1), np.array([0.3])


def test_what_is_safe_goes_on():
    supervisor = Supervisor()
    assert supervisor.check(30.0, BENT, STILL, touch(29.9), TICK)
    assert supervisor.reason == ""


@pytest.mark.parametrize(
    ("regions", "velocity", "words"),
    [
        (touch(31.4), STILL, "31 N of force, more than 30 N"),
        (touch(float("nan")), STILL, "no number"),
        (touch(3.0, normal=(0, 0, float("nan"))), STILL, "no number"),
        ((), np.array([-STOP_SPEED - 0.1]), "3.1 rad/s"),
    ],
)
def test_what_is_not_safe_stops_until_nothing_touched_for_a_while(regions, velocity, words):
    supervisor = Supervisor()
    assert not supervisor.check(30.0, BENT, velocity, regions, TICK)
    assert words in supervisor.reason
    for _ in range(300):
        assert not supervisor.check(30.0, STILL, STILL, touch(1.0), TICK), "still touched"
    ticks = 0
    while not supervisor.check(30.0, STILL, STILL, (), TICK):
        assert np.array_equal(supervisor.posture, BENT), "where it stopped"
        ticks += 1
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)
    assert supervisor.reason == ""


def test_a_reset_lets_go_at_once():
    supervisor = Supervisor()
    supervisor.check(30.0, BENT, STILL, touch(50.0), TICK)
    supervisor.reset()
    assert supervisor.check(30.0, BENT, STILL, (), TICK)


def test_a_robot_without_joints_is_never_too_fast():
    assert Supervisor().check(30.0, np.zeros(0), np.zeros(0), (), TICK)
