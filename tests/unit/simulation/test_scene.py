"""Scenes as values, and why each effect is on."""

from __future__ import annotations

from dataclasses import replace

import pytest

from app.errors import SceneError
from app.simulation.effects import Effects
from app.simulation.scene import Scene, effect_rows
from app.skin.cover_spec import CoverSpec

SCENE = Scene(name="s", robot="arm")


def test_steps_in_a_tick():
    assert SCENE.steps_per_tick == 5
    assert replace(SCENE, effects=Effects(timestep=0.0001)).steps_per_tick == 50


@pytest.mark.parametrize("bad", [{"tick": 0.0}, {"tick": 2.0}, {"tick": float("nan")}, {"tick": 0.0012}, {"seed": -1},
                                 {"effects": Effects(timestep=0.5)}, {"effects": Effects(timestep=float("nan"))},
                                 {"cover": CoverSpec(seed=-1)}])  # fmt: skip
def test_a_scene_that_cannot_run_is_refused(bad):
    with pytest.raises(SceneError, match=r"tick|seed|timestep"):
        replace(SCENE, **bad)


def test_every_effect_says_why():
    rows = {row.name: row for row in effect_rows(SCENE)}
    assert rows["gravity"].on
    assert not rows["contact between links"].on
    assert all(row.why for row in rows.values())


@pytest.mark.parametrize(("effects", "name", "on"), [
    (Effects(gravity="off"), "gravity", False), (Effects(gravity="on"), "gravity", True),
    (Effects(contact="self"), "contact between links", True), (Effects(joint_limits=False), "joint limits", False),
])  # fmt: skip
def test_rows_follow_the_effects(effects, name, on):
    usual = {row.name: row for row in effect_rows(SCENE)}[name]
    row = {row.name: row for row in effect_rows(replace(SCENE, effects=effects))}[name]
    assert row.on == on
    assert row.why != usual.why
