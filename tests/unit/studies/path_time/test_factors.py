"""Levels of a factor as conditions, and where they are drawn."""

from __future__ import annotations

import pytest

from tactile_maps.studies.path_time.conditions import Conditions
from tactile_maps.studies.path_time.factors import Factor, chosen, sensing, varied
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects


def test_a_level_is_one_thing_otherwise():
    assert varied("misplaced", 1e-3)(2.0) == Conditions(misplaced=0.002)
    assert chosen("controller")("qp") == Conditions(controller="qp")
    noisy = sensing(lambda sd: SensorEffects(noise=Noise(sd)))
    assert noisy(5.0) == Conditions(sensor=SensorEffects(noise=Noise(5.0)))


def test_nothing_is_drawn_where_it_is_said():
    factor = Factor("noise", "Pa", (100.0,), varied("gain"), (100.0,), 0.0, drawn_zero=10.0)
    assert not factor.named
    assert (factor.position(0.0), factor.position(100.0)) == pytest.approx((10.0, 100.0))
    assert Factor("controller", "who", ("qp",), chosen("controller"), ("qp",), "hybrid").named
