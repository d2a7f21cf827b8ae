"""What a scene's sensor lets a controller know of its readings."""

from __future__ import annotations

import math

from app.control.skin_readings import SkinReadings
from app.scene.effects import Effects


def skin_readings(effects: Effects, tick: float) -> SkinReadings:
    """At every ``tick`` [s], at once and without an end; but for the effects ``sampling`` and ``saturation``."""
    bus, amplifier = effects.sensor.sampling, effects.sensor.saturation
    highest = math.inf if amplifier is None else amplifier.at
    if bus is None:
        return SkinReadings(tick, highest=highest)
    return SkinReadings(max(1 / bus.rate, tick), bus.delay, highest)
