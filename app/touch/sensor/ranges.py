"""The one check of every number an effect of the sensor is given."""

from __future__ import annotations

import math
from numbers import Real

from app.errors import SimulationError


def check_range(place: str, value: float, low: float, high: float) -> None:
    """Refuse a number outside ``low`` to ``high``, both included.

    Args:
        place: The effect and its field, e.g. ``noise.sd``.
        value: What was given.
        low: The least that makes sense.
        high: The most.

    Raises:
        SimulationError: It is no number, not finite or outside.
    """
    if not (isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value) and low <= value <= high):
        raise SimulationError(
            "a sensor cannot be so", place=f"sensor.{place}", value=value, remedy=f"Choose {low:g} to {high:g}"
        )
