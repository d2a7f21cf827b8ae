"""The hold-force law on a bar: directions, limits and memory, without a simulation."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.region import ContactRegion
from app.control.command import ControlSettings
from app.control.hold_force import HoldForce
from app.control.reference import DAMPING, HOME_SPEED, MAX_JOINT_SPEED, MAX_LEAD, MAX_SPEED
from app.geometry.surface_point import SurfacePoint
from tests.touch import bar

SETTINGS = ControlSettings(law="hold_force", force_goal=3.0, force_gain=0.01, integral_time=0.5)
STILL, TICK = np.zeros(1), 0.005


def touch(force, *, x=0.3, id_=1, normal=(0, 0, 1)):
    at = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
    place = np.array([x, 0, 0.02])
    return (ContactRegion(id_, np.array([0]), force, 1e-4, 1e4, np.zeros(2), at, "bar", place, np.asarray(normal)),)


def moved(law, regions, *, settings=SETTINGS, posture=STILL):
    """How far one command moves the wanted posture."""
    before = law._reference.from_where(posture)
    return float((law.command(settings, posture, STILL, regions, TICK).posture - before)[0])


def test_it_retreats_from_too_much_and_advances_into_too_little():
    """Down, away from the finger, is positive about +y: one newton too much moves the point at the gain."""
    assert moved(HoldForce(bar()), touch(4.0)) * 0.3 == pytest.approx(0.01 * (1 + 1 * TICK / 0.5) * TICK, rel=1e-9)
    assert moved(HoldForce(bar()), touch(2.0)) * 0.3 == pytest.approx(-0.01 * TICK, rel=1e-9), "no integral yet"
    assert moved(HoldForce(bar()), touch(3.0)) == 0


def test_the_integral_grows_with_a_constant_error_once_the_goal_was_reached():
    law = HoldForce(bar())
    speeds = [moved(law, touch(4.0)) * 0.3 / TICK for _ in range(20)]
    assert speeds == pytest.approx([0.01 * (1 + (k + 1) * TICK / 0.5) for k in range(20)], rel=1e-9)
    assert moved(law, touch(2.0)) > -0.01 * TICK / 0.3, "what was gathered still pushes back"
    assert moved(law, touch(2.0, id_=2)) == pytest.approx(-0.01 * TICK / 0.3), "a new contact starts without it"


def test_a_lost_contact_forgets_the_integral():
    law = HoldForce(bar())
    for _ in range(20):
        moved(law, touch(4.0))
    moved(law, ())
    assert moved(law, touch(2.0)) * 0.3 == pytest.approx(-0.01 * TICK, rel=1e-9)


def test_speed_is_bounded_without_windup_and_says_so():
    law = HoldForce(bar())
    step = moved(law, touch(200.0))
    assert step * 0.3 == pytest.approx(MAX_SPEED * TICK)
    assert law.why_limited == ("speed of the touched point",)
    assert law._servo.integral(1) == 0


def test_no_joint_is_faster_than_its_limit():
    law = HoldForce(bar())
    for x in (0.001, 0.02, 0.05, DAMPING, 0.1, 2 * DAMPING, 0.3):
        law.reset()
        assert abs(moved(law, touch(200.0, x=x))) <= MAX_JOINT_SPEED * TICK * (1 + 1e-9)
    law.reset()
    moved(law, touch(4.0, x=0.02))
    assert law.why_limited == ("the arm can hardly move along this contact",)


def test_a_push_along_the_axis_moves_nothing():
    law = HoldForce(bar())
    assert moved(law, touch(9.0, normal=(0, 1, 0))) == 0
    assert "hardly move" in law.why_limited[0]


def test_a_joint_at_its_limit_stays_and_says_so():
    law, edge = HoldForce(bar()), np.array([1.5])
    assert moved(law, touch(9.0), posture=edge) == 0
    assert "joint limit" in law.why_limited
    law.reset()
    assert moved(law, touch(1.0), posture=edge) < 0, "away from the limit it is free"


def test_it_does_not_run_ahead_of_an_arm_that_is_held_back():
    law = HoldForce(bar())
    for _ in range(500):
        law.command(SETTINGS, STILL, STILL, touch(9.0), TICK)
    assert law._reference.wanted[0] == pytest.approx(MAX_LEAD)
    assert "something holds the arm back" in law.why_limited


def test_it_starts_from_the_posture_it_finds_and_goes_home_gently():
    law, posture = HoldForce(bar()), np.array([1.0])
    wanted = [float(law.command(SETTINGS, posture, STILL, (), TICK).posture[0])]
    assert wanted[0] == pytest.approx(1.0, abs=1e-3), "no jolt"
    for _ in range(2000):
        posture = np.array([wanted[-1]])
        wanted.append(float(law.command(SETTINGS, posture, STILL, (), TICK).posture[0]))
    speed = np.diff(wanted) / TICK
    assert np.abs(speed).max() <= HOME_SPEED * (1 + 1e-9)
    assert np.abs(np.diff(speed)).max() / TICK < HOME_SPEED / 0.15, "smooth start and end"
    assert wanted[-1] == pytest.approx(0, abs=1e-4)


def test_a_reading_that_is_no_number_moves_nothing_and_is_said():
    law = HoldForce(bar())
    moved(law, touch(4.0))
    assert moved(law, touch(float("nan"))) == 0
    assert law.why_limited == ("the skin reads what is no number",)
    assert np.isfinite(moved(law, touch(4.0)))


def test_no_integral_at_all_can_be_asked_for():
    endless = ControlSettings(law="hold_force", force_gain=0.01, integral_time=float("inf"))
    law = HoldForce(bar())
    assert [moved(law, touch(4.0), settings=endless) for _ in range(5)] == pytest.approx([0.01 * TICK / 0.3] * 5)


def test_a_robot_without_joints_gets_an_empty_command():
    law, empty = HoldForce(bar(hinged=False)), np.zeros(0)
    for regions in ((), touch(9.0), ()):
        assert law.command(SETTINGS, empty, empty, regions, TICK).posture.shape == (0,)
