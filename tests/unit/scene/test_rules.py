"""Each effect from the needs alone: on where something calls for it, and always with a reason."""

from __future__ import annotations

import pytest

from app.scene.decide import decide
from app.scene.effect_table import EFFECTS, SENSOR_KEYS
from app.scene.needs import Needs
from app.scene.objects import ObjectSpec
from app.scene.rules import RULES
from app.touch.layer import Layer

BOX = ObjectSpec("box", "box", size=(0.1, 0.1, 0.1), mass=1.0)
WALL = ObjectSpec("wall", "box", size=(0.1, 0.1, 0.1))
PROBE = ObjectSpec("probe", "probe", size=(0.01,))
VIEW = Needs(task="view", outputs=("posture",))
ALL = ("posture", "pressure", "readings", "force", "centre_of_pressure", "pressure_shape", "joint_torque")


def test_every_effect_has_a_rule_in_the_order_of_the_table():
    assert list(RULES) == list(EFFECTS)


@pytest.mark.parametrize(("needs", "expected"), [
    (VIEW, {"dynamics": False, "fingers": False, "contact": "off", "gravity": "off", "friction": False,
            "joint_limits": False, "joint_friction": False, "skin": "off", "timestep": 0.005}),
    (Needs(task="view", outputs=("joint_torque",)),
     {"dynamics": True, "joint_friction": True, "gravity": "compensated"}),
    (Needs(task="view", outputs=("pressure",)), {"dynamics": False, "fingers": True, "skin": "water-fill"}),
    (Needs(), {"dynamics": True, "fingers": True, "contact": "off", "gravity": "off", "friction": False,
               "joint_limits": True, "skin": "water-fill", "timestep": 0.001, "integrator": "implicitfast"}),
    (Needs(objects=(PROBE,)), {"contact": "probe", "friction": False, "gravity": "off"}),
    (Needs(objects=(WALL, PROBE)), {"contact": "environment", "friction": False, "gravity": "off"}),
    (Needs(objects=(BOX,)), {"contact": "environment", "friction": True, "gravity": "compensated"}),
    (Needs(task="self-touch"), {"contact": "self", "friction": False}),
    (Needs(task="self-touch", objects=(PROBE,)), {"contact": "all"}),
    (Needs(task="slide", objects=(WALL,)), {"contact": "environment", "friction": True, "gravity": "off"}),
    (Needs(task="push", objects=(BOX,)), {"friction": True, "gravity": "compensated"}),
    (Needs(outputs=("joint_torque",), objects=(WALL,)), {"friction": True, "joint_friction": True, "skin": "off"}),
    (Needs(outputs=("posture",), scripted=True), {"fingers": True, "skin": "off"}),
    (Needs(outputs=("posture",), law="hold_force"), {"fingers": True, "skin": "water-fill"}),
    (Needs(outputs=("posture", "force")), {"skin": "point"}),
    (Needs(outputs=("force",), law="hold_force"), {"skin": "water-fill"}),
    (Needs(outputs=("centre_of_pressure",)), {"skin": "punch"}),
    (Needs(outputs=("centre_of_pressure", "pressure_shape")), {"skin": "half-space"}),
    (Needs(tick=0.008), {"timestep": 0.001}),
    (Needs(tick=0.0005), {"timestep": 0.0005}),
    (Needs(task="view", outputs=("posture",), tick=0.1), {"timestep": 0.02}),
    (Needs(layer=Layer(stiffness=1e7), objects=(WALL,)), {"integrator": "discrete"}),
    (Needs(layer=Layer(stiffness=1e8), objects=(WALL,)), {"integrator": "discrete"}),
    (Needs(layer=Layer(stiffness=1e7)), {"integrator": "implicitfast"}),
])  # fmt: skip
def test_effects_follow_from_the_needs(needs, expected):
    effects = decide(needs, {}).effects
    assert {key: getattr(effects, key) for key in expected} == pytest.approx(expected)


def test_the_sensor_is_simulated_where_its_readings_are_wanted():
    on = vars(decide(Needs(outputs=("readings",)), {}).effects.sensor)
    assert [key for key in SENSOR_KEYS if on[key] is None] == ["dead_taxels"]
    assert not any(vars(decide(Needs(), {}).effects.sensor).values())
    assert not any(vars(decide(Needs(outputs=("readings",)), {"skin": "off"}).effects.sensor).values())


def test_everything_wanted_is_everything_on():
    needs = Needs(task="self-touch", outputs=ALL, objects=(BOX, PROBE))
    off = [row.name for row in decide(needs, {}).rows if not row.on]
    assert off == ["dead_taxels"]


def test_a_rule_sees_the_wishes_above_it():
    effects = decide(Needs(objects=(BOX,)), {"contact": "off", "fingers": "off"}).effects
    assert not effects.friction
    assert effects.skin == "off"
    coarse = decide(Needs(), {"timestep": 0.005}).effects
    assert coarse.integrator == "discrete"


@pytest.mark.parametrize("needs", [VIEW, Needs(), Needs(task="self-touch", outputs=ALL, objects=(BOX, PROBE))])
def test_every_effect_says_why(needs):
    for row in decide(needs, {}).rows:
        assert row.why
        assert not row.wished
        assert row.value in EFFECTS[row.name].choices or row.name == "timestep"
