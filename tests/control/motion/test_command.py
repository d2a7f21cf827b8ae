"""Joint commands, and settings that are checked when they are read."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest

from tactile_maps.control.controller_registry import check_settings, scene_values, settings_from
from tactile_maps.control.motion.command import CHOICES, MOST_POINTS, RANGES, ControlSettings, JointCommand
from tactile_maps.core.errors import SceneError


def test_command_owns_its_arrays():
    posture = np.zeros(2)
    command = JointCommand(posture, posture, posture, posture)
    posture[0] = 1
    assert command.posture[0] == 0
    assert not command.torque.flags.writeable


@pytest.mark.parametrize("name", RANGES)
def test_number_is_checked_against_its_range(name):
    ends = RANGES[name]
    for end in ends:
        assert getattr(check_settings(ControlSettings(**{name: end})), name) == end
    for bad in (ends[0] - 1.0, float("nan"), *([] if np.isinf(ends[1]) else [1e9]), True, "much", None):
        with pytest.raises(SceneError, match=f"control.{name}"):
            check_settings(replace(ControlSettings(), **{name: bad}))


@pytest.mark.parametrize("name", CHOICES)
def test_every_choice_is_allowed_and_no_other(name):
    for choice in CHOICES[name]:
        assert getattr(check_settings(replace(ControlSettings(), **{name: choice})), name) == choice
    with pytest.raises(SceneError, match=rf"control.{name}.*magic.*{CHOICES[name][-1]}"):
        check_settings(replace(ControlSettings(), **{name: "magic"}))


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        ("path", path)
        for path in (
            ((0.0,),),
            ((0.0, float("nan")),),
            ((0.0, "x"),),
            ((True, 0.0), (0.1, 0.1)),
            ((0.0, 0.0),) * (MOST_POINTS + 1),
        )
    ]
    + [("starts", starts) for starts in (-1, 1.0, True, 10**9 + 1)],
)
def test_path_has_finite_points_and_starts_are_counted(name, bad):
    assert set(asdict(ControlSettings())) == {*RANGES, *CHOICES, "path", "starts"}, "every setting is checked"
    with pytest.raises(SceneError, match=rf"control\.{name}"):
        check_settings(ControlSettings(**{name: bad}))


def test_table_of_a_scene_contains_the_differences_from_the_defaults():
    path = ((0.01, 0.02), (0.03, 0.02))
    settings = ControlSettings(controller="hybrid", task="follow_path", path_kind="polyline", path=path, starts=2)
    values = scene_values(settings)
    assert set(values) == {"controller", "task", "path_kind", "path", "starts"}
    assert settings_from(values) == settings == ControlSettings(**json.loads(json.dumps(asdict(settings))))
    assert settings_from({}) == ControlSettings() != settings
    assert scene_values(ControlSettings()) == {}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"forcegoal": 5.0}, r"forcegoal.*force_goal"),
        ({"path": "here"}, r"control\.path"),
        ({"path": 3.0}, r"control\.path"),
    ],
)
def test_invalid_table_of_a_scene_raises(table, message):
    with pytest.raises(SceneError, match=message):
        settings_from(table)
