from __future__ import annotations

from dataclasses import asdict, fields

from app.touch.sensor.effects import SensorEffects
from tests.sensors import ALL_ON


def test_all_is_off_unless_told():
    assert set(asdict(SensorEffects()).values()) == {None}


def test_the_fields_stand_in_the_order_of_the_signal():
    assert [field.name for field in fields(SensorEffects)] == [
        "area_averaging", "crosstalk", "hysteresis", "gain_spread", "offset_drift", "noise", "saturation", "threshold",
        "quantisation", "dead_taxels", "sampling",
    ]  # fmt: skip


def test_equal_choices_are_equal():
    assert SensorEffects(**{f.name: getattr(ALL_ON, f.name) for f in fields(ALL_ON)}) == ALL_ON
