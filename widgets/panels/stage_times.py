"""A tick's stage times as plots and panels show them: all that the sensor does is one stage. No Qt."""

from __future__ import annotations

from app.scene.effect_table import SENSOR_KEYS
from app.timing import Timings

SENSOR = "sensor"


def stage_times(timings: Timings) -> dict[str, float]:
    """Milliseconds by stage; the sensor's effects, each of which is timed, stand together after touch."""
    times: dict[str, float] = {}
    for stage, milliseconds in timings.ms.items():
        name = SENSOR if stage in SENSOR_KEYS else stage
        times[name] = times.get(name, 0.0) + milliseconds
    return times
