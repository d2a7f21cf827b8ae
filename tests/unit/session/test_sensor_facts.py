"""What a controller is told of the simulated sensor."""

from __future__ import annotations

import math

from app.control.skin_readings import SkinReadings
from app.scene.effects import Effects
from app.session.sensor_facts import skin_readings
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.sampling import Sampling
from app.touch.sensor.saturation import Saturation


def told(**sensor):
    return skin_readings(Effects(sensor=SensorEffects(**sensor)), 0.005)


def test_rate_delay_and_end_come_from_the_effects():
    assert told() == SkinReadings(0.005, 0.0, math.inf)
    assert told(sampling=Sampling(20.0, 0.1)) == SkinReadings(0.05, 0.1, math.inf)
    assert told(sampling=Sampling(1000.0, 0.0)).period == 0.005, "no more often than a tick"
    assert told(saturation=Saturation(1e5)) == SkinReadings(0.005, 0.0, 1e5)
