"""Scenes as values: what cannot run is refused, effects follow from the needs, a person may overrule."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from tactile_maps.core.errors import SceneError
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene, whole_steps, with_effects, with_override
from tactile_maps.skin.fitting.cover import CoverSpec
from tactile_maps.stimuli.stimulus_kinds import Poke
from tactile_maps.tactile.sensors.sensor_effects import Noise

SCENE = Scene(name="s", robot="arm")
BALL = ObjectSpec("ball", "sphere", size=(0.1,))


def test_tick_contains_the_stated_number_of_steps():
    assert whole_steps(SCENE.tick, SCENE.effects.timestep) == 5
    assert whole_steps(SCENE.tick, replace(SCENE, overrides={"timestep": 0.0001}).effects.timestep) == 50


def test_time_step_that_does_not_divide_the_tick_is_rejected_with_a_valid_one():
    with pytest.raises(SceneError, match=r"time step 0\.003 s in a tick of 0\.005 s.*time step of 0\.0025 s .tick / 2"):
        replace(SCENE, tick=0.005, overrides={"timestep": 0.003})
    replace(SCENE, tick=0.005, overrides={"timestep": 0.0025})
    with pytest.raises(SceneError, match=r"time step of 0\.005 s .tick / 1"):
        replace(SCENE, tick=0.005, overrides={"timestep": 0.02})


@pytest.mark.parametrize("tick", [0.0005, 0.001, 0.0012, 0.005, 1 / 60, 0.1, 1.0])
@pytest.mark.parametrize("task", ["touch", "view"])
def test_derived_time_step_divides_any_tick(tick, task):
    scene = replace(SCENE, tick=tick, task=task)
    assert whole_steps(scene.tick, scene.effects.timestep) * scene.effects.timestep == pytest.approx(tick)


@pytest.mark.parametrize(
    ("bad", "place"),
    [
        ({"tick": 0.0}, "tick"),
        ({"tick": 2.0}, "tick"),
        ({"tick": float("nan")}, "tick"),
        ({"seed": -1}, "seed"),
        ({"seed": 2**63}, "seed"),
        ({"tick": 0.0012, "overrides": {"timestep": 0.001}}, "effects.timestep"),
        ({"cover": CoverSpec(seed=-1)}, "cover.seed"),
        ({"overrides": {"timestep": 0.5}}, "effects.timestep"),
        ({"overrides": {"gravty": "on"}}, "effects.gravty"),
        ({"task": "slied"}, "task"),
        ({"outputs": ("pressures",)}, "outputs"),
        ({"objects": (BALL, BALL)}, "objects.1.name"),
    ],
)
def test_invalid_scene_is_rejected_with_the_place(bad, place):
    with pytest.raises(SceneError) as caught:
        replace(SCENE, **bad)
    assert caught.value.place == place


def test_effects_follow_from_task_outputs_objects_and_script():
    assert SCENE.effects.contact == "off"
    assert replace(SCENE, objects=(BALL,)).effects.contact == "environment"
    assert replace(SCENE, task="view").effects.skin == "off"
    assert replace(SCENE, task="view", stimuli=(Poke(),)).effects.fingers
    assert replace(SCENE, task="view", control={"controller": "hold_force"}).effects.skin == "water-fill"
    assert replace(SCENE, outputs=("readings",)).effects.sensor.noise == Noise()


def test_effects_are_decided_once_and_pickled():
    assert SCENE.decision is SCENE.decision
    copy = pickle.loads(pickle.dumps(SCENE))
    assert copy == SCENE
    assert copy.effects == SCENE.effects


def test_override_replaces_the_rule_until_it_is_removed():
    scene = with_override(SCENE, "friction", "on")
    assert scene.effects.friction
    assert scene.overrides == {"friction": "on"}
    again = with_override(with_override(scene, "noise", {"sd": 3}), "friction", "auto")
    assert again.overrides == {"noise": {"sd": 3.0}}
    assert again.effects.sensor.noise == Noise(sd=3.0)
    assert with_override(again, "noise", "auto") == SCENE
    with pytest.raises(SceneError, match="friction"):
        with_override(SCENE, "friction", "sticky")


@pytest.mark.parametrize(
    "other",
    [
        replace(SCENE, task="view"),
        replace(SCENE, outputs=("readings", "shear", "pressure_shape", "joint_torque"), objects=(BALL,), tick=0.004),
        replace(SCENE, overrides={"noise": {"sd": 3.0}, "dead_taxels": "on", "timestep": 0.0005}),
    ],
    ids=["fewer", "more", "overrides"],
)
def test_scene_with_effects_of_another_one_keeps_them_when_its_controller_changes(other):
    assert other.effects != SCENE.effects
    scene = with_effects(SCENE, other.effects)
    assert scene.effects == other.effects
    assert scene.overrides
    assert with_effects(scene, other.effects) is scene
    touching = with_effects(replace(scene, control={"controller": "hold_force"}), other.effects)
    assert touching.effects == other.effects


def test_decision_contains_warnings():
    scene = Scene(name="s", robot="arm", task="slide", objects=(BALL,), overrides={"friction": "off"})
    assert [finding.where for finding in scene.decision.warnings] == ["effects.friction"]
