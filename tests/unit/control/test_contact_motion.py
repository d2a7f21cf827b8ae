"""The controller a session asks: settings are checked, laws switch without a jolt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.contact_motion import RANGES, ContactMotionController, check_settings, settings_from
from app.errors import SceneError
from tests.touch import bar


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("bad", [-1.0, float("nan"), 1e9, "much"])
def test_a_setting_out_of_range_is_named_and_the_last_good_ones_stay(name, bad):
    if name == "integral_time" and bad == 1e9:
        bad = 0.0
    controller = ContactMotionController(bar(), ControlSettings())
    with pytest.raises(SceneError, match=f"control.{name}"):
        controller.settings = replace(ControlSettings(), **{name: bad})
    assert controller.settings == ControlSettings()


def test_the_ends_of_the_ranges_are_allowed():
    for name, ends in RANGES.items():
        for end in ends:
            check_settings(replace(ControlSettings(), **{name: end}))


def test_settings_from_a_scene():
    assert settings_from({}) == ControlSettings()
    assert settings_from({"law": "hold_force", "force_goal": 5.0}) == ControlSettings(law="hold_force", force_goal=5.0)
    with pytest.raises(SceneError, match=r"forcegoal.*force_goal"):
        settings_from({"forcegoal": 5.0})
    with pytest.raises(SceneError, match=r"magic.*impedance or hold_force"):
        settings_from({"law": "magic"})


def test_switching_the_law_starts_from_the_posture_found():
    controller = ContactMotionController(bar(), ControlSettings())
    bent, still = np.array([0.7]), np.zeros(1)
    assert controller.command(bent, still, (), 0.005).posture[0] == 0
    controller.settings = ControlSettings(law="hold_force")
    assert controller.command(bent, still, (), 0.005).posture[0] == pytest.approx(0.7, abs=1e-2)
    controller.settings = ControlSettings(law="hold_force", force_goal=5.0)
    assert controller.command(bent, still, (), 0.005).posture[0] < 0.7, "other gains do not start it afresh"
    controller.reset()
    assert controller.settings.force_goal == 5.0
    assert controller.why_limited == ()


def test_a_rest_posture_holds_under_every_law():
    controller, posture, still = ContactMotionController(bar(), ControlSettings()), np.zeros(1), np.zeros(1)
    assert controller.rest == [0.0], "the robot's home, until it is set"
    controller.rest = np.array([0.3])
    assert controller.command(posture, still, (), 0.005).posture == [0.3]
    controller.settings = ControlSettings(law="hold_force")
    assert controller.rest == [0.3]
    for _ in range(800):
        posture = controller.command(posture, still, (), 0.005).posture
    assert posture == pytest.approx([0.3], abs=1e-2), "it comes back to rest, not home"
