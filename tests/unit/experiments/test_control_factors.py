"""What is wrong with what a controller knows, one thing at a time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.reading_settings import ReadingSettings
from app.experiments.control_factors import FACTORS, NOMINAL, WRENCH_NOISE, Knowledge, known, known_by
from app.experiments.control_setup import beside_ball
from app.touch.sensor.noise import Noise
from app.touch.sensor.sampling import Sampling
from tests.numerics.pressed_arm import forearm


@pytest.fixture(scope="module")
def prepared():
    return beside_ball(forearm(), taxel=150)


@pytest.mark.parametrize(("factor", "level"), NOMINAL.items())
def test_the_nominal_level_of_each_factor_is_the_nominal(factor, level):
    assert known_by(factor, level) == Knowledge()
    assert level not in FACTORS[factor]
    assert all(known_by(factor, other) != Knowledge() for other in FACTORS[factor]) or factor == "tolerance"


def test_the_nominal_is_a_skin_that_is_read_at_once_and_believed_as_it_is(prepared):
    setup = known(prepared, Knowledge(), 0)
    assert setup.believed is None
    assert setup.sensor.noise is None
    assert setup.sensor.sampling == Sampling(50.0, 0.0)
    assert setup.reading == ReadingSettings()


def test_rate_delay_and_noise_are_the_sensors(prepared):
    setup = known(prepared, replace(known_by("rate", 20.0), delay=2, noise=100.0), 0)
    assert setup.sensor.sampling == Sampling(20.0, 0.1)
    assert setup.sensor.noise == Noise(100.0)


def test_a_misplaced_skin_is_believed_and_not_touched(prepared):
    setups = [known(prepared, known_by("misplaced", 3.0, by), 1) for by in ("taxel", "module")]
    moved = [
        np.linalg.norm(setup.map.skin.patches[0].taxels.positions - prepared.skin.patches[0].taxels.positions, axis=1)
        for setup in setups
    ]
    assert all(0.002 < np.median(away) < 0.007 for away in moved)
    assert not np.allclose(*moved)
    assert setups[0].prepared is prepared
    assert known(prepared, known_by("misplaced", 3.0), 1).believed is setups[0].believed, "made once"
    assert known(prepared, known_by("misplaced", 3.0), 2).believed is not setups[0].believed


def test_a_map_is_made_by_a_method_or_learned(prepared):
    conformal = known(prepared, known_by("map", "lscm"), 0)
    assert conformal.map.charts[0].method == "lscm"
    assert conformal.map.skin is prepared.skin
    learned = known(prepared, known_by("map", "information-distance"), 0)
    assert len(learned.map.skin) == len(prepared.skin)
    assert "information" in learned.map.charts[0].method


def test_the_lumped_sensor_has_its_own_noise(prepared):
    assert known(prepared, known_by("estimator", "lumped"), 0).reading == ReadingSettings("lumped", None, WRENCH_NOISE)
    assert known(prepared, known_by("estimator", "tikhonov"), 0).reading == ReadingSettings("tikhonov")
