"""What the Effects panel offers and says, as words: choices, reasons, and what a recording changed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.scene.effect_table import EFFECTS
from app.scene.scene import Scene, with_wish
from app.touch.sensor.effects import SensorEffects
from app.touch.sensor.noise import Noise
from widgets.panels.effect_choices import autos_of, choices_of, chosen, reason_of, recorded, tip_of

SCENE = Scene("by hand", "arm")


def row_of(scene, key):
    return next(row for row in scene.decision.rows if row.name == key)


@pytest.mark.parametrize("key", EFFECTS)
def test_every_choice_is_one_that_the_scene_takes(key):
    choices = choices_of(key, tick=SCENE.tick)
    assert choices[0] == ("Auto", "auto")
    assert len(choices) >= 3
    for words, wish in choices[1:]:
        assert row_of(with_wish(SCENE, key, wish), key).value == words


def test_only_time_steps_that_make_up_a_tick_are_offered():
    steps = [wish for _, wish in choices_of("timestep", tick=0.005)[1:]]
    assert steps == [0.0005, 0.001, 0.0025, 0.005]


def test_a_wish_says_what_it_would_be_without():
    scene = with_wish(SCENE, "friction", "on")
    row, auto = row_of(scene, "friction"), autos_of(scene)["friction"]
    assert row.wished
    assert auto == row_of(SCENE, "friction")
    assert reason_of(row, auto) == f"The scene says so; auto is off: {auto.why}."
    assert reason_of(auto, auto) == f"{auto.why[:1].upper()}{auto.why[1:]}."


def test_what_was_chosen_here_is_told_from_what_the_scene_said():
    opened = with_wish(SCENE, "friction", "on")
    scene = with_wish(with_wish(opened, "noise", "on"), "friction", "on")
    decision = chosen(scene.decision, opened, scene)
    reasons = {row.name: row.why for row in decision.rows if row.wished}
    assert reasons["friction"] == "the scene says so"
    assert reasons["noise"] == "you chose so"
    assert decision.effects == scene.effects


def test_what_is_off_says_what_it_would_usually_be():
    row = row_of(SCENE, "noise")
    assert not row.on
    assert "Usually sd 100." in tip_of(row, row)
    on = row_of(with_wish(SCENE, "noise", {"sd": 300.0}), "noise")
    assert "Usually" not in tip_of(on, row)
    assert "sd 300" in tip_of(on, row)


def test_what_changed_in_a_recording_is_marked_and_nothing_else():
    effects = replace(SCENE.effects, friction=True, sensor=SensorEffects(noise=Noise()))
    assert recorded(SCENE, SCENE.effects) is SCENE.decision
    changed = recorded(SCENE, effects)
    assert changed.effects == effects
    rows = dict(zip(EFFECTS, zip(SCENE.decision.rows, changed.rows, strict=True), strict=True))
    for key, (old, new) in rows.items():
        if key in ("friction", "noise"):
            assert (new.value, new.on, new.wished, new.why) == ("on", True, True, "changed while it ran")
        else:
            assert new == old
