"""Effects that the needs require, overrides, and warnings about missing effects."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

from tactile_maps.scene.effect_decision import EFFECT_RULES, OVERRIDDEN, decide_effects
from tactile_maps.scene.effects import EFFECTS, SENSOR_KEYS
from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.scene.tasks import TASKS, Needs
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Noise

BOX = ObjectSpec("box", "box", size=(0.1, 0.1, 0.1), mass=1.0)
WALL = ObjectSpec("wall", "box", size=(0.1, 0.1, 0.1))
PROBE = ObjectSpec("probe", "probe", size=(0.01,))
VIEW = Needs(task="view", outputs=("posture",))
ALL = ("posture", "pressure", "readings", "shear", "force", "centre_of_pressure", "pressure_shape", "joint_torque")


def test_every_effect_has_a_rule_in_the_order_of_the_table():
    assert list(EFFECT_RULES) == list(EFFECTS)


@pytest.mark.parametrize(
    ("needs", "expected"),
    [
        (
            VIEW,
            {
                "dynamics": False,
                "fingers": False,
                "contact": "off",
                "gravity": "off",
                "friction": False,
                "joint_limits": False,
                "joint_friction": False,
                "skin": "off",
                "timestep": 0.005,
            },
        ),
        (
            Needs(task="view", outputs=("joint_torque",)),
            {"dynamics": True, "joint_friction": True, "gravity": "compensated"},
        ),
        (Needs(task="view", outputs=("pressure",)), {"dynamics": False, "fingers": True, "skin": "water-fill"}),
        (
            Needs(),
            {
                "dynamics": True,
                "fingers": True,
                "contact": "off",
                "gravity": "off",
                "friction": False,
                "joint_limits": True,
                "skin": "water-fill",
                "timestep": 0.001,
                "integrator": "implicitfast",
            },
        ),
        (Needs(objects=(PROBE,)), {"contact": "probe", "friction": False, "gravity": "off", "time_averaging": True}),
        (Needs(), {"time_averaging": False}),
        (Needs(outputs=("force",), objects=(WALL,)), {"time_averaging": True}),
        (Needs(outputs=("readings",)), {"time_averaging": True}),
        (Needs(outputs=("pressure",), objects=(WALL,)), {"time_averaging": False}),
        (Needs(outputs=("posture",), objects=(WALL,)), {"time_averaging": False}),
        (Needs(objects=(WALL, PROBE)), {"contact": "environment", "friction": False, "gravity": "off"}),
        (Needs(objects=(BOX,)), {"contact": "environment", "friction": True, "gravity": "compensated"}),
        (Needs(task="self-touch"), {"contact": "self", "friction": True}),
        (Needs(task="self-touch", objects=(PROBE,)), {"contact": "all"}),
        (Needs(task="slide", objects=(WALL,)), {"contact": "environment", "friction": True, "gravity": "off"}),
        (Needs(task="push", objects=(BOX,)), {"friction": True, "gravity": "compensated"}),
        (Needs(outputs=("joint_torque",), objects=(WALL,)), {"friction": True, "joint_friction": True, "skin": "off"}),
        (Needs(outputs=("posture",), scripted=True), {"fingers": True, "skin": "off"}),
        (Needs(outputs=("posture",), controller="hold_force"), {"fingers": True, "skin": "water-fill"}),
        (Needs(outputs=("posture",), behaviours=True), {"fingers": True, "skin": "water-fill"}),
        (Needs(outputs=("posture", "force"), behaviours=True), {"skin": "water-fill"}),
        (Needs(outputs=("posture", "force")), {"skin": "point"}),
        (Needs(outputs=("force",), controller="hold_force"), {"skin": "water-fill"}),
        (Needs(outputs=("centre_of_pressure",)), {"skin": "punch"}),
        (Needs(outputs=("shear",), objects=(WALL,)), {"skin": "water-fill", "shear": True, "friction": True}),
        (Needs(outputs=("shear", "centre_of_pressure"), objects=(WALL,)), {"skin": "punch", "shear": True}),
        (Needs(outputs=("shear", "pressure_shape"), objects=(WALL,)), {"skin": "half-space", "shear": False}),
        (Needs(objects=(BOX,)), {"shear": False}),
        (Needs(outputs=("centre_of_pressure", "pressure_shape")), {"skin": "half-space"}),
        (Needs(tick=0.008), {"timestep": 0.001}),
        (Needs(tick=0.0005), {"timestep": 0.0005}),
        (Needs(task="view", outputs=("posture",), tick=0.1), {"timestep": 0.02}),
        (Needs(layer=ElasticLayer(stiffness=1e7), objects=(WALL,)), {"integrator": "discrete"}),
        (Needs(layer=ElasticLayer(stiffness=1e8), objects=(WALL,)), {"integrator": "discrete"}),
        (Needs(layer=ElasticLayer(stiffness=1e7)), {"integrator": "implicitfast"}),
    ],
)
def test_effects_follow_from_the_needs(needs, expected):
    effects = decide_effects(needs, {}).effects
    assert {key: getattr(effects, key) for key in expected} == pytest.approx(expected)


@pytest.mark.parametrize("follows", [{"controller": "hybrid"}, {"behaviours": True}, {}])
def test_reason_states_the_centre_error_where_the_posture_follows_touch(follows):
    (row,) = (row for row in decide_effects(Needs(**follows), {}).rows if row.name == "skin")
    assert ("centre within 0.6 taxel spacings" in row.why) == bool(follows)
    (row,) = (row for row in decide_effects(Needs(outputs=("force",), **follows), {}).rows if row.name == "skin")
    assert "centre" not in row.why


def test_sensor_is_simulated_if_its_readings_are_an_output():
    on = vars(decide_effects(Needs(outputs=("readings",)), {}).effects.sensor)
    assert [key for key in SENSOR_KEYS if on[key] is None] == ["misorientation", "axis_crosstalk", "dead_taxels"]
    assert not any(vars(decide_effects(Needs(), {}).effects.sensor).values())
    assert not any(vars(decide_effects(Needs(outputs=("readings",)), {"skin": "off"}).effects.sensor).values())


def test_all_outputs_switch_all_effects_on():
    needs = Needs(task="self-touch", outputs=ALL, objects=(BOX, PROBE))
    off = [row.name for row in decide_effects(needs, {}).rows if not row.on]
    assert off == ["shear", "misorientation", "axis_crosstalk", "dead_taxels"], "the half-space has no shear"
    off = [row.name for row in decide_effects(needs, {"skin": "water-fill"}).rows if not row.on]
    assert off == ["dead_taxels"]


def test_rule_depends_on_overrides_before_it():
    effects = decide_effects(Needs(objects=(BOX,)), {"contact": "off", "fingers": "off"}).effects
    assert not effects.friction
    assert effects.skin == "off"
    coarse = decide_effects(Needs(), {"timestep": 0.005}).effects
    assert coarse.integrator == "discrete"


@pytest.mark.parametrize("needs", [VIEW, Needs(), Needs(task="self-touch", outputs=ALL, objects=(BOX, PROBE))])
def test_every_effect_has_a_reason(needs):
    for row in decide_effects(needs, {}).rows:
        assert row.why
        assert not row.overridden
        assert row.value in EFFECTS[row.name].choices or row.name == "timestep"


SLIDE = Needs(task="slide", objects=(WALL,))


@pytest.mark.parametrize("task", TASKS)
def test_derived_effects_have_no_warnings(task):
    for outputs in (TASKS[task].outputs, ("readings", "joint_torque")):
        assert decide_effects(Needs(task=task, outputs=outputs, objects=(WALL, BOX)), {}).warnings == ()


@pytest.mark.parametrize(
    ("needs", "overrides", "where", "words"),
    [
        (SLIDE, {"friction": "off"}, "effects.friction", "slide .* friction on"),
        (SLIDE, {"skin": "foundation"}, "effects.friction", "foundation has no friction"),
        (Needs(task="push", objects=(BOX,)), {"friction": "off"}, "effects.friction", "push"),
        (Needs(task="self-touch"), {"friction": "off"}, "effects.friction", "self-contact, but friction is off"),
        (Needs(task="self-touch"), {"contact": "environment"}, "effects.contact", "self-collision is off"),
        (Needs(task="self-touch"), {"contact": "off"}, "effects.contact", "contact self"),
        (SLIDE, {"contact": "off"}, "effects.contact", "wall collides with nothing"),
        (SLIDE, {"contact": "probe"}, "effects.contact", "wall"),
        (Needs(objects=(PROBE,)), {"contact": "self"}, "effects.contact", "probe collides with nothing"),
        (Needs(), {"skin": "off"}, "effects.skin", "outputs pressure"),
        (Needs(outputs=("posture",), controller="hold_force"), {"skin": "off"}, "effects.skin", "outputs force"),
        (Needs(outputs=("readings",)), {"skin": "off"}, "effects.skin", "outputs readings"),
        (Needs(scripted=True), {"fingers": "off"}, "effects.fingers", "fingers on"),
        (Needs(task="push", objects=(BOX,)), {"gravity": "off"}, "effects.gravity", "box does not fall"),
        (Needs(), {"dynamics": "off"}, "effects.dynamics", "touch the skin"),
        (Needs(task="view", outputs=("joint_torque",)), {"dynamics": "off"}, "effects.dynamics", "joint torques"),
        (Needs(task="slide"), {}, "objects", "has no object"),
        (Needs(task="crowd", objects=(PROBE,)), {}, "objects", "crowd|many"),
    ],
)
def test_missing_effects_are_reported(needs, overrides, where, words):
    found = decide_effects(needs, overrides).warnings
    assert where in [finding.where for finding in found]
    (finding,) = [finding for finding in found if finding.where == where]
    assert finding.kind == "scene-warning"
    assert re.search(words, finding.action)


def test_readings_of_an_ideal_sensor_are_reported():
    overrides = dict.fromkeys(SENSOR_KEYS, "off")
    assert [finding.where for finding in decide_effects(Needs(outputs=("readings",)), overrides).warnings] == [
        "effects"
    ]


@pytest.mark.parametrize(
    ("needs", "overrides"),
    [
        (SLIDE, {"timestep": 0.005, "integrator": "implicitfast"}),
        (Needs(objects=(WALL,), layer=ElasticLayer(stiffness=1e7)), {"integrator": "euler"}),
    ],
)
def test_unsteady_settings_are_reported(needs, overrides):
    (finding,) = decide_effects(needs, overrides).warnings
    assert finding.kind == "unstable-time-step"
    assert overrides["integrator"] in finding.where
    assert not decide_effects(needs, overrides | {"integrator": "auto"}).warnings


def rows_of(decision):
    return {row.name: row for row in decision.rows}


def test_override_replaces_the_rule_and_is_marked():
    decision = decide_effects(
        Needs(), {"gravity": "on", "timestep": 0.0005, "joint_limits": "off", "noise": {"sd": 150.0}}
    )
    assert decision.effects.gravity == "on"
    assert decision.effects.timestep == 0.0005
    assert not decision.effects.joint_limits
    assert decision.effects.sensor.noise == Noise(sd=150.0)
    rows = rows_of(decision)
    assert rows["gravity"].overridden
    assert rows["gravity"].why == OVERRIDDEN
    assert rows["timestep"].value == "0.0005 s"
    assert (rows["joint_limits"].on, rows["joint_limits"].value) == (False, "off")
    assert rows["noise"].value == "on"
    assert "sd 150" in rows["noise"].why
    assert not rows["skin"].overridden


@pytest.mark.parametrize("needs", [Needs(), SLIDE, Needs(task="self-touch", outputs=ALL), Needs(outputs=("readings",))])
def test_scene_without_user_and_script_has_no_fingers(needs):
    alone = decide_effects(replace(needs, attended=False), {}).effects
    assert decide_effects(needs, {}).effects.fingers
    assert not alone.fingers
    assert decide_effects(replace(needs, attended=False, scripted=True), {}).effects.fingers
    assert (alone.skin == "off") == (needs == Needs()), "a sensor without contact has noise too"
    assert alone.contact == decide_effects(needs, {}).effects.contact


@pytest.mark.parametrize("key", ["fingers", "joint_limits"])
def test_reason_mentions_what_is_unknown_in_advance(key):
    assert "not known beforehand" in rows_of(decide_effects(Needs(), {}))[key].why
    assert "not known beforehand" in rows_of(decide_effects(Needs(objects=(WALL,)), {}))["friction"].why


@pytest.mark.parametrize(
    ("overrides", "key", "words"),
    [
        ({}, "noise", "4 % of the least touch (2500 Pa)"),
        ({"noise": {"sd": 400.0}}, "noise", "set by the scene (sd 400), worth 16 % of the least touch"),
        ({"noise": {"sd": 400.0}, "threshold": "off"}, "noise", "40 % of the least touch (1000 Pa)"),
        ({}, "offset_drift", "at first 4 % of the least touch (2500 Pa); as large as that after 1.6e+04 s"),
        ({}, "quantisation", "an rms error of 2.3 % of the least touch"),
        ({}, "saturation", "nothing below 180000 Pa on a taxel, 72 times the least touch"),
        (
            {"dead_taxels": {"dead": 0.04, "stuck": 0.01}},
            "dead_taxels",
            "about 4 % of a contact's force goes unread; 1 %",
        ),
    ],
)
def test_reason_of_a_sensor_effect_states_its_size(overrides, key, words):
    """(400 Pa of 2,500; 200 / sqrt 12 = 57.7 Pa; sd² + walk² t = 2500² at t = 15,600 s.)"""
    row = rows_of(decide_effects(Needs(outputs=("readings",)), overrides))[key]
    assert row.on
    assert words in row.why


@pytest.mark.parametrize("name", ["full", "noisy"])
def test_all_sensor_effects_of_shipped_scenes_state_their_size(name):
    rows = rows_of(load_scene(name).decision)
    simulated = [key for key in SENSOR_KEYS if rows["shear"].on or key not in ("misorientation", "axis_crosstalk")]
    assert all(" worth " in rows[key].why for key in simulated)
