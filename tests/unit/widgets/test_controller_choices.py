"""What the controller panel offers is what the controller takes."""

from __future__ import annotations

from dataclasses import asdict, replace

import pytest

from app.control.command import ControlSettings
from app.control.laws import heeded
from app.control.settings_check import CHOICES as TAKEN
from app.control.settings_check import RANGES, check_settings
from widgets.panels.controller_choices import CHOICES, LAWS, SLIDERS


def test_every_law_and_choice_is_offered():
    assert tuple(LAWS) == TAKEN["law"]
    for name, (tip, words) in CHOICES.items():
        assert tip
        assert tuple(words) == TAKEN[name]


def test_every_number_has_a_slider_whose_ends_are_taken():
    assert set(SLIDERS) == set(RANGES)
    for name, spec in SLIDERS.items():
        for end in (spec.low, spec.high):
            check_settings(replace(ControlSettings(), **{name: end / spec.scale}))
        assert spec.low <= getattr(ControlSettings(), name) * spec.scale <= spec.high


@pytest.mark.parametrize("law", LAWS)
def test_whatever_is_heeded_can_be_turned(law):
    for task in TAKEN["task"]:
        shown = {*SLIDERS, *CHOICES, "law", "path"}
        assert heeded(ControlSettings(law=law, task=task)) <= shown
    assert set(asdict(ControlSettings())) == shown | {"starts"}
