"""Stages as people see them: nothing is lost when the sensor's effects are told as one."""

from __future__ import annotations

from app.timing import Timings
from widgets.panels.stage_times import stage_times


def test_the_sensors_effects_are_one_stage():
    timings = Timings({"physics": 1.0, "touch": 0.5, "noise": 0.25, "sampling": 0.125, "contacts": 2.0})
    times = stage_times(timings)
    assert list(times) == ["physics", "touch", "sensor", "contacts"]
    assert times["sensor"] == 0.375
    assert sum(times.values()) == timings.total_ms


def test_an_ideal_sensor_is_no_stage():
    assert "sensor" not in stage_times(Timings({"physics": 1.0, "touch": 0.5}))
