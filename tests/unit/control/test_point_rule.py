"""What the laws that move points in space share: one memory by contact, forgotten with it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.point_rule import PointRule, bounded
from app.control.reference import MAX_SPEED, PostureReference
from app.control.rule import ArmState
from tests.touch import bar
from tests.unit.control.touched import contact

AIM, DT = np.array([0.1, 0.0, -0.2]), 0.005
SETTINGS = ControlSettings(force_gain=0.01, integral_time=1.0)


class Slow(PointRule):
    """Nears a velocity in ten ticks' time, and presses."""

    def velocity(self, settings, contact, dt, limits):
        return self.lagged(contact, AIM, 10 * DT, dt)


def levels(rule, *contacts):
    zero = np.zeros(4)
    arm = ArmState(zero, zero, zero, PostureReference(bar(), np.ones(1)), contacts, DT)
    return rule.levels(SETTINGS, contacts, arm, [])


def test_all_contacts_are_wanted_alike():
    free, held = contact(), replace(contact(np.zeros(2)), id=2)
    [level] = levels(Slow(), free, held)
    assert np.array_equal(level.rows, np.concatenate([free.outward[None], held.move]))
    assert level.speed == pytest.approx(0.1 * np.array([AIM[2], *AIM])), "a tenth of the way in the first tick"


def test_the_velocity_wanted_is_remembered_by_contact_and_forgotten_with_it():
    rule, one = Slow(), contact(np.zeros(2))
    for tick in range(1, 5):
        [level] = levels(rule, one)
        assert level.speed == pytest.approx((1 - 0.9**tick) * AIM)
    other = replace(one, id=2)
    [level] = levels(rule, other)
    assert level.speed == pytest.approx(0.1 * AIM), "another one starts at rest"
    [level] = levels(rule, one)
    assert level.speed == pytest.approx(0.1 * AIM), "and so does one that was lost"
    rule.reset()
    [level] = levels(rule, one)
    assert level.speed == pytest.approx(0.1 * AIM)


def test_a_time_constant_shorter_than_a_tick_is_none():
    assert Slow().lagged(contact(), AIM, 0.5 * DT, DT) is AIM


def test_the_force_s_integral_goes_with_its_contact():
    rule, one = Slow(), replace(contact(), force_error=-1.0)
    pushes = []
    for _ in range(3):
        levels(rule, one)
        pushes.append(rule.push(SETTINGS, one, DT, []))
    assert pushes == pytest.approx([-0.01 * (1 + DT * k) for k in (1, 2, 3)])
    levels(rule, replace(one, id=2))
    assert rule.push(SETTINGS, one, DT, []) == pytest.approx(pushes[0])


def test_a_point_that_is_too_fast_is_slowed_and_that_is_said():
    limits: list[str] = []
    assert bounded(AIM, limits) is AIM
    assert limits == []
    assert bounded(10 * AIM, limits) == pytest.approx(MAX_SPEED * AIM / np.linalg.norm(AIM))
    assert limits == ["speed of the touched point"]
