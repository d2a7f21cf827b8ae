"""Effects are values, and the table knows each by its key, choices and ranges."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.effects import EFFECTS, SENSOR_KEYS, Effects, effect_entry
from tactile_maps.tactile.sensors.sensor_effects import Noise


def test_every_effect_is_in_the_table_once():
    plain = [field.name for field in fields(Effects) if field.name != "sensor"]
    assert sorted(EFFECTS) == sorted([*plain, *SENSOR_KEYS])
    assert [key for key in EFFECTS if key in SENSOR_KEYS] == list(SENSOR_KEYS)


@pytest.mark.parametrize("entry", EFFECTS.values(), ids=EFFECTS)
def test_each_entry_is_complete(entry):
    assert entry.title
    assert entry.tip
    assert bool(entry.choices) == (entry.key != "timestep")
    assert not entry.when_on or entry.when_on in entry.choices
    assert (entry.sensor is not None) == (entry.key in SENSOR_KEYS)
    assert not entry.sensor or is_dataclass(entry.value("on"))
    for choice in entry.choices:
        assert entry.checked(choice) == choice
        assert entry.word(entry.value(choice)) == choice


@pytest.mark.parametrize(
    ("key", "override", "checked"),
    [
        ("friction", True, "on"),
        ("friction", False, "off"),
        ("noise", "auto", "auto"),
        ("timestep", 0.002, 0.002),
        ("noise", {"sd": 150}, {"sd": 150.0}),
        ("gravity", "on", "on"),
    ],
)
def test_override_has_its_standard_form(key, override, checked):
    result = effect_entry(key).checked(override)
    assert result == checked
    assert type(result) is type(checked)


def test_overrides_become_values():
    assert effect_entry("friction").value("on") is True
    assert effect_entry("gravity").value("on") == "on"
    assert effect_entry("noise").value("off") is None
    assert effect_entry("noise").value("on") == Noise()
    assert effect_entry("noise").value({"sd": 150.0}) == Noise(sd=150.0)
    assert effect_entry("timestep").word(0.002) == "0.002 s"


@pytest.mark.parametrize(
    ("key", "override", "place", "words"),
    [
        ("gravity", "compensate", "effects.gravity", "Did you mean compensated"),
        ("contact", 3, "effects.contact", "off, probe, environment, self, all"),
        ("friction", {"sd": 1.0}, "effects.friction", "auto, off, on"),
        ("noise", 150.0, "effects.noise", "table of sd"),
        ("noise", {"ds": 1.0}, "effects.noise.ds", "sd"),
        ("noise", {"sd": True}, "effects.noise.sd", "must be a number"),
        ("noise", {"sd": float("nan")}, "effects.noise.sd", "must be a number"),
        ("noise", {"sd": "150 kPa"}, "effects.noise.sd", "write 150000"),
        ("noise", {"sd": -1.0}, "effects.noise.sd", "Choose"),
        ("timestep", "2 ms", "effects.timestep", "write 0.002"),
        ("timestep", 0.5, "effects.timestep", "0.02"),
        ("timestep", float("nan"), "effects.timestep", "0.02"),
        ("timestep", True, "effects.timestep", "0.02"),
        ("integrator", ["euler"], "effects.integrator", "euler"),
        ("integrator", "rk4", "effects.integrator", "implicitfast"),
    ],
)
def test_impossible_override_is_rejected(key, override, place, words):
    with pytest.raises(SceneError) as caught:
        effect_entry(key).checked(override)
    assert place in str(caught.value.place)
    assert words in str(caught.value)
