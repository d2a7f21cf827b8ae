"""Warnings: a scene that switches off what its task needs is told so; one that does not is left in peace."""

from __future__ import annotations

import re

import pytest

from app.scene.decide import decide
from app.scene.effect_table import SENSOR_KEYS
from app.scene.needs import TASKS, Needs
from app.scene.objects import ObjectSpec
from app.touch.layer import Layer

BOX = ObjectSpec("box", "box", size=(0.1, 0.1, 0.1), mass=1.0)
WALL = ObjectSpec("wall", "box", size=(0.1, 0.1, 0.1))
PROBE = ObjectSpec("probe", "probe", size=(0.01,))
SLIDE = Needs(task="slide", objects=(WALL,))


@pytest.mark.parametrize("task", TASKS)
def test_what_is_derived_lacks_nothing(task):
    for outputs in (TASKS[task].outputs, ("readings", "joint_torque")):
        assert decide(Needs(task=task, outputs=outputs, objects=(WALL, BOX)), {}).warnings == ()


@pytest.mark.parametrize(("needs", "wishes", "where", "words"), [
    (SLIDE, {"friction": "off"}, "effects.friction", "slide .* friction on"),
    (Needs(task="push", objects=(BOX,)), {"friction": "off"}, "effects.friction", "push"),
    (Needs(task="self-touch"), {"contact": "environment"}, "effects.contact", "pass through each other"),
    (Needs(task="self-touch"), {"contact": "off"}, "effects.contact", "contact self"),
    (SLIDE, {"contact": "off"}, "effects.contact", "wall is there but nothing touches it"),
    (SLIDE, {"contact": "probe"}, "effects.contact", "wall"),
    (Needs(objects=(PROBE,)), {"contact": "self"}, "effects.contact", "probe is there"),
    (Needs(), {"skin": "off"}, "effects.skin", "wants pressure"),
    (Needs(outputs=("posture",), law="hold_force"), {"skin": "off"}, "effects.skin", "wants force"),
    (Needs(outputs=("readings",)), {"skin": "off"}, "effects.skin", "wants readings"),
    (Needs(scripted=True), {"fingers": "off"}, "effects.fingers", "fingers on"),
    (Needs(task="push", objects=(BOX,)), {"gravity": "off"}, "effects.gravity", "box floats"),
    (Needs(), {"dynamics": "off"}, "effects.dynamics", "touch the skin"),
    (Needs(task="view", outputs=("joint_torque",)), {"dynamics": "off"}, "effects.dynamics", "joint torques"),
    (Needs(task="slide"), {}, "objects", "nothing"),
    (Needs(task="crowd", objects=(PROBE,)), {}, "objects", "crowd|many"),
])  # fmt: skip
def test_what_is_lacking_is_told(needs, wishes, where, words):
    found = decide(needs, wishes).warnings
    assert where in [finding.where for finding in found]
    (finding,) = [finding for finding in found if finding.where == where]
    assert finding.kind == "scene-lacks"
    assert re.search(words, finding.action)


def test_an_ideal_sensor_gives_no_real_readings():
    wishes = dict.fromkeys(SENSOR_KEYS, "off")
    assert [finding.where for finding in decide(Needs(outputs=("readings",)), wishes).warnings] == ["effects"]


def test_looking_needs_nothing():
    assert decide(Needs(task="view", outputs=("posture",)), {"skin": "off", "contact": "off"}).warnings == ()


@pytest.mark.parametrize(("needs", "wishes"), [
    (SLIDE, {"timestep": 0.005, "integrator": "implicitfast"}),
    (Needs(objects=(WALL,), layer=Layer(stiffness=1e7)), {"integrator": "euler"}),
])  # fmt: skip
def test_an_unsteady_corner_is_told(needs, wishes):
    (finding,) = decide(needs, wishes).warnings
    assert finding.kind == "unstable-corner"
    assert wishes["integrator"] in finding.where
    assert not decide(needs, wishes | {"integrator": "auto"}).warnings
