"""The force loop of a whole arm: predicted from all its joints, and found where it was predicted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.errors import SkinError
from app.experiments.arm_loop import arm_loop, filter_of, measured_gain, predicted_gain, rested
from app.experiments.control_setup import ControlSetup, beside_ball
from app.experiments.sampled_loop import Filter
from tests.numerics.pressed_arm import forearm

CALM = ControlSettings(law="hybrid", task="hold_point", force_gain=0.002)


@cache
def setup():
    return ControlSetup(beside_ball(forearm()))


@cache
def loop():
    return arm_loop(setup(), CALM)


def test_it_is_linear_about_where_the_goal_is_held():
    session = rested(setup(), CALM)
    assert session.pressing == pytest.approx(3.0, abs=0.1)
    made = loop()
    assert made.outward @ made.push == pytest.approx(1.0)
    assert np.abs(np.linalg.eigvals(made.moved[:14, :14])).max() < 1, "without a law it comes to rest"


def test_a_law_is_a_filter():
    assert filter_of(replace(CALM, law="qp")) == Filter(0.002, integral_time=0.3)
    assert filter_of(replace(CALM, law="admittance")) == Filter(0.002, inertia_time=0.05)
    assert filter_of(replace(CALM, law="parallel")) == Filter(0.002, 0.3, position_gain=4.0, inertia_time=0.05)


def test_a_law_that_lags_bears_less():
    gains = [predicted_gain(loop(), replace(CALM, law=law)) for law in ("hybrid", "admittance", "parallel")]
    assert gains == sorted(gains, reverse=True)
    slower = predicted_gain(loop(), replace(CALM, law="admittance", inertia_time=0.2))
    assert slower < gains[1]


@pytest.mark.parametrize("law", ["hybrid", "parallel"])
def test_the_force_swings_from_the_gain_on_that_was_predicted(law):
    settings = replace(CALM, law=law)
    predicted = predicted_gain(loop(), settings)
    assert measured_gain(setup(), settings, predicted, steps=3) == pytest.approx(predicted, rel=0.1)


def test_where_nothing_touches_there_is_no_loop():
    away = ControlSetup(beside_ball(forearm(), depth=-0.2))
    with pytest.raises(SkinError, match="nothing touches"):
        arm_loop(away, CALM)
