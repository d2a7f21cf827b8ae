"""Holding a force on the whole arm: it settles at the goal, stays, and matches the second-order law it is built on."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.reference import HOME_SPEED
from app.session.session import Session
from app.touch.poke import Finger, PokePressed, PokeReleased
from tests.touch import arm

TICK = 0.005


def pressed(taxel, *, seconds, goal=3.0, speed=0.006, **settings):
    """The finger's force at every tick, and the session afterwards."""
    session = Session(arm(), scripted=False, settings=ControlSettings(law="hold_force", force_goal=goal, **settings))
    session.submit(PokePressed(1, arm().skin.taxel_point(taxel), Finger(speed=speed, max_force=20.0)))
    return np.array([session.tick().pokes[0].force for _ in range(round(seconds / TICK))]), session


def forearm_taxels():
    return [int(taxel) for taxel in range(arm().skin.first[1] + 5, arm().skin.first[2], 15)]


@pytest.mark.parametrize("goal", [1.0, 3.0, 8.0])
def test_the_force_settles_at_the_goal_and_stays(goal):
    """A finger that keeps advancing at 6 mm/s and would press with 20 N."""
    for taxel in forearm_taxels():
        force, session = pressed(taxel, seconds=5.0, goal=goal)
        assert np.abs(force[400:] / goal - 1).max() < 0.05, f"taxel {taxel}"
        assert session.frame.why_limited == (), f"taxel {taxel}"


def test_a_faster_finger_is_held_too():
    force, _ = pressed(forearm_taxels()[2], seconds=4.0, speed=0.012)
    assert np.abs(force[400:] / 3.0 - 1).max() < 0.05


def test_without_it_the_same_finger_presses_harder():
    taxel = forearm_taxels()[2]
    held, _ = pressed(taxel, seconds=4.0)
    session = Session(arm(), scripted=False)
    session.submit(PokePressed(1, arm().skin.taxel_point(taxel), Finger(speed=0.006, max_force=20.0)))
    for _ in range(800):
        frame = session.tick()
    assert frame.pokes[0].force > 2 * held[-1]


def test_proportional_alone_lags_by_the_speed_over_the_gain():
    """In balance the arm retreats as fast as the finger comes: gain e = speed."""
    force, _ = pressed(forearm_taxels()[2], seconds=3.0, force_gain=0.015, gains="as_set", integral_time=float("inf"))
    assert force[-1] - 3.0 == pytest.approx(0.006 / 0.015, rel=0.05)


@pytest.mark.parametrize("gain", [0.002, 0.01, 0.05])
@pytest.mark.parametrize("integral_time", [0.05, 0.3, 2.0])
def test_any_setting_stays_finite_and_bounded(gain, integral_time):
    force, session = pressed(forearm_taxels()[1], seconds=2.0, force_gain=gain, integral_time=integral_time)
    assert np.isfinite(force).all()
    assert force.max() <= 20.0
    assert np.abs(session.frame.velocity).max() < 10


def test_when_the_finger_leaves_the_arm_goes_home_gently():
    _, session = pressed(forearm_taxels()[2], seconds=4.0)
    away = np.abs(session.frame.posture - arm().robot.home).max()
    assert away > 0.02
    session.submit(PokeReleased(1))
    speeds, wanted = [], [session.frame.command.posture]
    for _ in range(1200):
        frame = session.tick()
        speeds.append(np.abs(frame.velocity).max())
        wanted.append(frame.command.posture)
    assert np.abs(np.diff(wanted, axis=0)).max() / TICK <= HOME_SPEED * (1 + 1e-9)
    assert max(speeds) < 1.5 * HOME_SPEED
    assert frame.posture == pytest.approx(arm().robot.home, abs=1e-3)
