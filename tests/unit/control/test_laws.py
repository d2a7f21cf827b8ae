"""All laws by name, and what each heeds: a setting that is shown changes something, one that is hidden nothing."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.laws import RULES, build_law, heeded
from app.control.map_sight import MapSight
from app.control.settings_check import CHOICES
from app.control.task_keeper import TaskKeeper
from tests.touch import arm
from tests.unit.control.touched import TICK, touch_on

OTHER = {
    "stiffness": 20.0, "damping_ratio": 0.3, "force_goal": 2.0, "force_gain": 0.03, "integral_time": 0.1,
    "position_gain": 9.0, "inertia_time": 0.3, "jacobian": "raw", "path_kind": "raster", "path_size": 0.1,
    "path_speed": 0.1, "max_force": 3.5,
}  # fmt: skip


def answers(settings: ControlSettings) -> np.ndarray:
    """What a law asks of the joints while a contact wanders to and fro and presses, and once it is lost."""
    prepared = arm()
    law = build_law(settings.law, prepared.robot, TaskKeeper(), MapSight(prepared.map))
    pairs, posture, rows = prepared.skin.neighbours, prepared.robot.home + 0.02, []
    here, there = (int(taxel) for taxel in pairs[pairs[:, 0] > prepared.skin.first[1] + 40][0])
    for tick in range(40):
        regions = (touch_on(prepared.map, here if tick < 20 else there, 1.0 + 0.1 * tick),)
        command = law.command(settings, posture, np.full(7, 0.01), regions, TICK)
        rows.append(np.concatenate([command.posture, command.stiffness, command.damping]))
    return np.array(rows)


@pytest.mark.parametrize("task", CHOICES["task"])
@pytest.mark.parametrize("law", CHOICES["law"])
def test_what_is_heeded_makes_a_difference_and_nothing_else_does(law, task):
    settings = ControlSettings(law=law, task=task)
    assert {*OTHER, "law", "task", "path", "starts", "gains"} == set(asdict(settings))  # gains: the controller's matter
    usual = answers(settings)
    for name, value in OTHER.items():
        same = np.array_equal(answers(replace(settings, **{name: value})), usual)
        assert same == (name not in heeded(settings)), f"{name} under {law}, {task}"


def test_the_size_of_a_path_counts_until_one_is_drawn():
    settings = ControlSettings(law="qp", task="follow_path")
    assert "path_size" in heeded(settings)
    assert "path_size" not in heeded(replace(settings, path=((0.0, 0.0), (0.1, 0.0))))


def test_laws_with_a_task_are_choices():
    assert set(RULES) < set(CHOICES["law"])
    assert all("task" in heeded(ControlSettings(law=law)) for law in RULES)
