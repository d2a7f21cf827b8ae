"""The force loop of one contact: proportional and integral, bounded, forgetful."""

from __future__ import annotations

import pytest

from app.control.command import ControlSettings
from app.control.force_servo import ForceServo

SETTINGS = ControlSettings(force_gain=0.01, integral_time=0.5)
DT = 0.005


def push(servo, error, *, contact=1, limits=None, settings=SETTINGS):
    return servo.push(settings, contact, error, DT, [] if limits is None else limits)


def test_proportional_until_the_goal_was_reached_then_integral_too():
    servo = ForceServo(1.0)
    assert [push(servo, 1.0) for _ in range(3)] == pytest.approx([0.01] * 3)
    assert [push(servo, -1.0) for _ in range(3)] == pytest.approx([-0.01 * (1 + k * DT / 0.5) for k in (1, 2, 3)])
    assert servo.integral(1) == pytest.approx(-3 * DT)


def test_each_contact_has_its_own_memory_and_takes_it_along():
    servo = ForceServo(1.0)
    push(servo, -1.0)
    push(servo, -2.0, contact=2)
    assert (servo.integral(1), servo.integral(2)) == pytest.approx((-DT, -2 * DT))
    servo.keep([2])
    assert (servo.integral(1), servo.integral(2)) == pytest.approx((0.0, -2 * DT))
    assert push(servo, 1.0) == pytest.approx(0.01), "it has to reach its goal again"


def test_the_integral_stands_while_the_answer_is_bounded():
    servo, limits = ForceServo(0.02), []
    push(servo, -1.0)
    gathered = servo.integral(1)
    for _ in range(1000):
        assert push(servo, -50.0, limits=limits) == -0.02
    assert servo.integral(1) == pytest.approx(gathered)
    assert set(limits) == {"speed of the touched point"}
    assert push(servo, 1.0) == pytest.approx(0.01, rel=0.02), "free at once"


def test_no_integral_at_all():
    servo, endless = ForceServo(1.0), ControlSettings(force_gain=0.01, integral_time=float("inf"))
    assert [push(servo, -1.0, settings=endless) for _ in range(4)] == [-0.01] * 4
    assert servo.integral(1) == 0.0
    push(servo, -1.0)
    push(servo, -1.0, settings=endless)
    assert servo.integral(1) == pytest.approx(-DT), "what was gathered stands"


def test_a_goal_that_is_not_reached_alone_is_integrated_for_after_a_while():
    """Something holds against it: the proportional part comes no nearer, and would stand for ever."""
    servo, ticks = ForceServo(1.0), round(SETTINGS.integral_time / DT)
    nearing = [push(servo, 2.0 * 0.97**k) for k in range(ticks)]
    assert servo.integral(1) == 0.0, "it still comes nearer"
    assert nearing[-1] < 0.2 * nearing[0]
    for _ in range(ticks - 2):
        push(servo, 0.5)
    assert servo.integral(1) == 0.0
    held = [push(servo, 0.5) for _ in range(20)]
    assert held[-1] > held[0]
    assert servo.integral(1) > 0
    servo.keep([])
    push(servo, 0.5)
    assert servo.integral(1) == 0.0, "a new contact waits again"
