"""What a sensor's effects make of readings; the formula itself is checked against chance in tests/numerics."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.accuracy import ReadingErrors, uncertainty
from app.errors import MapError
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.gain_spread import GainSpread
from app.touch.sensor.noise import Noise
from app.touch.sensor.quantisation import Quantisation


def test_a_perfect_sensor_makes_no_errors():
    assert ReadingErrors.of_sensor(SensorEffects()) == ReadingErrors()


def test_noise_and_converter_add_as_variances():
    errors = ReadingErrors.of_sensor(SensorEffects(noise=Noise(300.0), quantisation=Quantisation(400.0 * np.sqrt(12))))
    assert errors.noise == pytest.approx(500.0)
    assert errors.gain == 0.0


def test_gains_are_known():
    assert ReadingErrors.of_sensor(SensorEffects(gain_spread=GainSpread(0.2))).gain == 0.2


@pytest.mark.parametrize("name", ["noise", "gain", "calibration"])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_what_is_no_deviation_is_refused(name, value):
    with pytest.raises(MapError, match=name):
        ReadingErrors(**{name: value})


def test_exact_readings_give_an_exact_force_and_a_taxel_wide_place():
    place, force = uncertainty(ReadingErrors(), np.array([3.0]), np.array([6e-4]), np.zeros(1))
    assert force == 0
    assert place == pytest.approx(np.sqrt(6e-4 / 6))
