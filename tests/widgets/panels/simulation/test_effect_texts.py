"""Texts of the effects panel: choices, reasons, changes in a recording, and costs in milliseconds."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.timing import Timings
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene import Scene, with_override
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects
from tactile_widgets.panels.model.effects_panel import (
    EffectCosts,
    automatic_rows,
    credited_decision,
    effect_choices,
    effect_reason,
    effect_tip,
    recorded_decision,
)

SCENE = Scene("by hand", "arm")


def row_of(scene, key):
    return next(row for row in scene.decision.rows if row.name == key)


@pytest.mark.parametrize("key", EFFECTS)
def test_every_choice_is_valid_in_a_scene(key):
    choices = effect_choices(key, tick=SCENE.tick)
    assert choices[0] == ("Auto", "auto")
    assert len(choices) >= 3
    for words, override in choices[1:]:
        assert row_of(with_override(SCENE, key, override), key).value == words


def test_only_time_steps_that_make_up_a_tick_are_offered():
    steps = [override for _, override in effect_choices("timestep", tick=0.005)[1:]]
    assert steps == [0.0005, 0.001, 0.0025, 0.005]


def test_override_states_the_automatic_choice():
    scene = with_override(SCENE, "friction", "on")
    row = row_of(scene, "friction")
    auto = automatic_rows(scene)["friction"]
    assert row.overridden
    assert auto == row_of(SCENE, "friction")
    assert effect_reason(row, auto) == f"Set by the scene; auto is off: {auto.why}."
    assert effect_reason(auto, auto) == f"{auto.why[:1].upper()}{auto.why[1:]}."


def test_choice_of_the_user_is_distinguished_from_the_scene():
    opened = with_override(SCENE, "friction", "on")
    scene = with_override(with_override(opened, "noise", "on"), "friction", "on")
    decision = credited_decision(scene.decision, opened, scene)
    reasons = {row.name: row.why for row in decision.rows if row.overridden}
    assert reasons["friction"] == "set by the scene"
    assert reasons["noise"] == "set by user"
    assert decision.effects == scene.effects


def test_disabled_effect_states_its_default():
    row = row_of(SCENE, "noise")
    assert not row.on
    assert "Default: sd 100." in effect_tip(row, row)
    on = row_of(with_override(SCENE, "noise", {"sd": 300.0}), "noise")
    assert "Default" not in effect_tip(on, row)
    assert "sd 300" in effect_tip(on, row)


def test_only_effects_changed_in_a_recording_are_marked():
    effects = replace(SCENE.effects, friction=True, sensor=SensorEffects(noise=Noise()))
    assert recorded_decision(SCENE, SCENE.effects) is SCENE.decision
    changed = recorded_decision(SCENE, effects)
    assert changed.effects == effects
    rows = dict(zip(EFFECTS, zip(SCENE.decision.rows, changed.rows, strict=True), strict=True))
    for key, (old, new) in rows.items():
        if key in ("friction", "noise"):
            assert (new.value, new.on, new.overridden, new.why) == ("on", True, True, "changed during the recording")
        else:
            assert new == old


ROWS = {row.name: row for row in Scene("s", "arm", overrides={"noise": "on", "gravity": "on"}).decision.rows}


def test_cost_of_a_stage_is_its_median_in_this_session():
    costs = EffectCosts()
    for milliseconds in (0.1, 0.3, 9.0):
        costs.add(Timings({"physics": 1.0, "touch": milliseconds, "noise": 0.02}))
    costs.prices = {"skin": 7.0, "noise": 7.0}
    assert (costs.of(ROWS["skin"]).words, costs.of(ROWS["skin"]).ablation) == ("0.30", False)
    assert (costs.of(ROWS["noise"]).words, costs.of(ROWS["noise"]).ablation) == ("0.02", False)


def test_effect_without_a_stage_has_the_separately_measured_cost():
    costs = EffectCosts()
    assert costs.of(ROWS["gravity"]).words == "…"
    costs.prices = {"gravity": 0.123}
    assert (costs.of(ROWS["gravity"]).words, costs.of(ROWS["gravity"]).ablation) == ("0.12", True)
    costs.prices = {"gravity": -0.001}
    assert costs.of(ROWS["gravity"]).words == "<0.01"
    assert costs.of(ROWS["timestep"]).words == "–", "it cannot be left out"


def test_disabled_effect_has_no_cost():
    costs = EffectCosts()
    costs.add(Timings({"crosstalk": 1.0}))
    costs.prices = {"crosstalk": 1.0}
    assert costs.of(ROWS["crosstalk"]).words == "–"


def test_times_of_a_disabled_stage_are_dropped():
    costs = EffectCosts()
    costs.add(Timings({"touch": 0.2, "noise": 0.5}))
    costs.add(Timings({"touch": 0.2}))
    costs.prices = {"noise": 0.1}
    assert costs.of(ROWS["noise"]).ablation


def test_total_is_shown_with_the_available_time():
    costs = EffectCosts()
    assert costs.total == ""
    costs.clear(0.005)
    costs.add(Timings({"physics": 1.0, "touch": 0.25}))
    assert costs.total == "1.25 of 5\u202fms a tick"
    costs.clear(0.01)
    assert costs.total == ""
