"""Effects read back equal, and nothing but effects reads at all."""

from __future__ import annotations

import json
from dataclasses import fields
from typing import get_args, get_type_hints

import pytest

from app.errors import SimulationError
from app.recording.effects_codec import effects_from_json, effects_to_json
from app.scene.effects import Effects
from app.touch.sensor.effects import SensorEffects

EVERY = {name: get_args(hint)[0]() for name, hint in get_type_hints(SensorEffects).items()}
FULL = Effects(gravity="on", contact="all", friction=True, timestep=1 / 3000, sensor=SensorEffects(**EVERY))


def damaged(**changes) -> dict:
    return json.loads(json.dumps(effects_to_json(FULL))) | changes


@pytest.mark.parametrize("effects", [Effects(), FULL])
def test_they_read_back_equal(effects):
    assert effects_from_json(json.loads(json.dumps(effects_to_json(effects)))) == effects


def test_every_field_is_there():
    raw = effects_to_json(Effects())
    assert set(raw) == {field.name for field in fields(Effects)}
    assert set(raw["sensor"]) == {field.name for field in fields(SensorEffects)}


@pytest.mark.parametrize("raw", [
    None, [], {}, "effects", damaged(magic=1), damaged(gravity="moon"), damaged(gravity=["on"]), damaged(friction=1),
    damaged(friction="on"), damaged(timestep="fast"), damaged(timestep=float("nan")), damaged(timestep=True),
    damaged(sensor=None), damaged(sensor={}), damaged(sensor=damaged()["sensor"] | {"noise": 3}),
    damaged(sensor=damaged()["sensor"] | {"noise": {"sd": "loud"}}),
    damaged(sensor=damaged()["sensor"] | {"noise": {"sd": 1.0, "colour": 2.0}}),
])  # fmt: skip
def test_what_is_damaged_is_refused(raw):
    with pytest.raises(ValueError, match="effects"):
        effects_from_json(raw)


def test_an_option_out_of_range_is_refused():
    with pytest.raises(SimulationError, match="noise"):
        effects_from_json(damaged(sensor=damaged()["sensor"] | {"noise": {"sd": -1.0}}))
