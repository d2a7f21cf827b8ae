"""Joint commands, and settings that are checked where they come in."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from tactile_maps.control.controller_registry import check_settings, scene_values, settings_from
from tactile_maps.control.motion.command import CHOICES, MOST_POINTS, RANGES, ControlSettings, JointCommand
from tactile_maps.core.errors import SceneError


def test_a_command_owns_its_arrays():
    posture = np.zeros(2)
    command = JointCommand(posture, posture, posture, posture)
    posture[0] = 1
    assert command.posture[0] == 0
    assert not command.torque.flags.writeable


def test_settings_compare_by_value():
    assert ControlSettings() == ControlSettings(controller="impedance")
    assert ControlSettings(force_goal=5.0) != ControlSettings()


@pytest.mark.parametrize("name", RANGES)
@pytest.mark.parametrize("bad", [-1.0, float("nan"), 1e9, "much"])
def test_a_number_out_of_range_is_named(name, bad):
    if name == "integral_time" and bad == 1e9:
        bad = 0.0
    with pytest.raises(SceneError, match=f"control.{name}"):
        check_settings(replace(ControlSettings(), **{name: bad}))


@pytest.mark.parametrize("bad", [True, "much", None])
@pytest.mark.parametrize("name", RANGES)
def test_what_is_no_number_is_refused_at_once(name, bad):
    with pytest.raises(SceneError, match=f"control.{name}"):
        ControlSettings(**{name: bad})


def test_truth_values_are_no_places_of_a_path():
    with pytest.raises(SceneError, match="control.path"):
        check_settings(ControlSettings(path=((True, 0.0), (0.1, 0.1))))


def test_the_ends_of_the_ranges_are_allowed():
    for name, ends in RANGES.items():
        for end in ends:
            check_settings(replace(ControlSettings(), **{name: end}))


@pytest.mark.parametrize("name", CHOICES)
def test_every_choice_is_allowed_and_no_other(name):
    for choice in CHOICES[name]:
        assert getattr(check_settings(replace(ControlSettings(), **{name: choice})), name) == choice
    with pytest.raises(SceneError, match=rf"control.{name}.*magic.*{CHOICES[name][-1]}"):
        check_settings(replace(ControlSettings(), **{name: "magic"}))


def test_every_setting_is_checked():
    assert set(asdict(ControlSettings())) == {*RANGES, *CHOICES, "path", "starts"}


@pytest.mark.parametrize("path", [((0.0,),), ((0.0, float("nan")),), ((0.0, "x"),), ((0.0, 0.0),) * (MOST_POINTS + 1)])
def test_a_path_is_finite_points_of_two(path):
    with pytest.raises(SceneError, match=r"control\.path"):
        check_settings(ControlSettings(path=path))


@pytest.mark.parametrize("starts", [-1, 1.0, True, 10**9 + 1])
def test_starts_are_counted(starts):
    assert check_settings(ControlSettings(starts=3)).starts == 3
    with pytest.raises(SceneError, match=r"control\.starts"):
        check_settings(ControlSettings(starts=starts))


def test_the_table_of_a_scene_says_what_differs_and_is_read_back():
    assert scene_values(ControlSettings()) == {}
    path = ((0.01, 0.02), (0.03, 0.02))
    settings = ControlSettings(controller="hybrid", task="follow_path", path_kind="polyline", path=path, starts=2)
    values = scene_values(settings)
    assert set(values) == {"controller", "task", "path_kind", "path", "starts"}
    assert settings_from(values) == settings


def test_settings_from_a_scene():
    assert settings_from({}) == ControlSettings()
    assert settings_from({"controller": "hold_force", "force_goal": 5.0}) == ControlSettings(
        controller="hold_force", force_goal=5.0
    )
    assert settings_from({"controller": "qp", "task": "follow_path", "path_kind": "raster"}).path_kind == "raster"
    with pytest.raises(SceneError, match=r"forcegoal.*force_goal"):
        settings_from({"forcegoal": 5.0})
    for path in ("here", 3.0):
        with pytest.raises(SceneError, match=r"control\.path"):
            settings_from({"path": path})


def test_settings_survive_json():
    settings = ControlSettings(controller="qp", path=((0.1, 0.2), (0.3, 0.4)))
    assert ControlSettings(**json.loads(json.dumps(asdict(settings)))) == settings
