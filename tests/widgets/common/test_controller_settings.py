"""The controls offer the settings of the controller, and each controller keeps its own gains."""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import pytest

from tactile_maps.control.controller_registry import CONTROLLERS, check_settings, effective_settings
from tactile_maps.control.motion.command import CHOICES, RANGES, ControlSettings
from tactile_maps.control.motion.command import CHOICES as TAKEN
from tactile_maps.studies.controller_comparison import TASK_FIELDS
from tactile_widgets.common.controller_settings import GAIN_SETTINGS, SETTING_CHOICES, SLIDERS, GainsByController


def test_every_controller_and_choice_is_offered():
    assert tuple(CONTROLLERS) == TAKEN["controller"]
    for name, (tip, words) in SETTING_CHOICES.items():
        assert tip
        assert tuple(words) == TAKEN[name]


def test_every_number_has_a_slider_with_valid_ends():
    assert set(SLIDERS) == set(RANGES)
    for name, spec in SLIDERS.items():
        for end in (spec.low, spec.high):
            check_settings(replace(ControlSettings(), **{name: end / spec.scale}))
        default = getattr(ControlSettings(), name) * spec.scale
        assert spec.low <= default <= spec.high or default == math.inf, "no limit"


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_every_effective_setting_has_a_control(controller):
    for task in TAKEN["task"]:
        shown = {*SLIDERS, *SETTING_CHOICES, "controller", "path"}
        assert effective_settings(ControlSettings(controller=controller, task=task)) <= shown
    assert set(asdict(ControlSettings())) == shown | {"starts"}


HYBRID = ControlSettings(controller="hybrid", force_gain=0.01)


def test_new_controller_keeps_the_current_gains():
    assert GainsByController().switched(HYBRID, "qp") == replace(HYBRID, controller="qp")


def test_each_controller_keeps_its_gains_and_the_task_does_not_change():
    memory = GainsByController()
    qp = replace(memory.switched(HYBRID, "qp"), force_gain=0.03, force_goal=6.0, task="retreat")
    back = memory.switched(qp, "hybrid")
    assert back == replace(HYBRID, force_goal=6.0, task="retreat")
    assert memory.switched(back, "qp") == qp


def test_reset_restores_the_gains_of_the_scene():
    memory = GainsByController()
    memory.begin(ControlSettings(stiffness=20.0, force_goal=9.0))
    assert memory.reset(replace(HYBRID, task="guide")) == ControlSettings(
        controller="hybrid", stiffness=20.0, task="guide"
    )


def test_another_scene_resets_the_gains():
    memory = GainsByController()
    memory.switched(HYBRID, "qp")
    memory.begin(ControlSettings())
    assert memory.switched(ControlSettings(controller="qp"), "hybrid").force_gain == ControlSettings().force_gain


def test_every_setting_is_a_gain_or_part_of_the_task():
    others = {"controller", "max_force", "max_impact", "friction_use", "max_shear", "shear_threshold"}
    assert {*GAIN_SETTINGS, *TASK_FIELDS, *others} == set(asdict(ControlSettings()))
    assert not set(GAIN_SETTINGS) & set(TASK_FIELDS)
    for controller in CHOICES["controller"]:
        assert effective_settings(ControlSettings(controller=controller)) & set(GAIN_SETTINGS)
