"""The force loop of a whole arm: predicted from all its joints, and found where it was predicted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.core.errors import SkinError
from app.studies.testbeds.force_loop import (
    Filter,
    controller_filter,
    force_loop_at_goal,
    predicted_gain_limit,
    settled_session,
)
from app.studies.testbeds.path_following import PathSetup, beside_ball
from tests.support.pressed_arm import forearm

CALM = ControlSettings(controller="hybrid", task="hold_point", force_gain=0.002)


@cache
def setup():
    return PathSetup(beside_ball(forearm()))


@cache
def loop():
    return force_loop_at_goal(setup(), CALM)


def test_it_is_linear_about_where_the_goal_is_held():
    session = settled_session(setup(), CALM)
    assert session.total_normal_force == pytest.approx(3.0, abs=0.1)
    made = loop()
    assert made.outward @ made.push == pytest.approx(1.0)
    assert np.abs(np.linalg.eigvals(made.moved[:14, :14])).max() < 1, "without a controller it comes to rest"


def test_a_controller_is_a_filter():
    assert controller_filter(replace(CALM, controller="qp")) == Filter(0.002, integral_time=0.3)
    assert controller_filter(replace(CALM, controller="admittance")) == Filter(0.002, inertia_time=0.05)
    assert controller_filter(replace(CALM, controller="parallel")) == Filter(
        0.002, 0.3, position_gain=4.0, inertia_time=0.05
    )


def test_a_controller_that_lags_bears_less():
    gains = [
        predicted_gain_limit(loop(), replace(CALM, controller=controller))
        for controller in ("hybrid", "admittance", "parallel")
    ]
    assert gains == sorted(gains, reverse=True)
    slower = predicted_gain_limit(loop(), replace(CALM, controller="admittance", inertia_time=0.2))
    assert slower < gains[1]


def test_where_nothing_touches_there_is_no_loop():
    away = PathSetup(beside_ball(forearm(), depth=-0.2))
    with pytest.raises(SkinError, match="nothing touches"):
        force_loop_at_goal(away, CALM)
