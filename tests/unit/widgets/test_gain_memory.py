"""Each law keeps its own gains."""

from __future__ import annotations

from dataclasses import asdict, replace

from app.control.command import ControlSettings
from app.control.laws import heeded
from app.control.settings_check import CHOICES
from app.session.side_by_side import TASK
from widgets.panels.gain_memory import GAINS, GainMemory

HYBRID = ControlSettings(law="hybrid", force_gain=0.01)


def test_a_law_tried_for_the_first_time_takes_the_gains_of_now():
    assert GainMemory().switched(HYBRID, "qp") == replace(HYBRID, law="qp")


def test_switched_to_and_fro_each_has_its_own_gains_and_the_task_stays():
    memory = GainMemory()
    qp = replace(memory.switched(HYBRID, "qp"), force_gain=0.03, force_goal=6.0, task="retreat")
    back = memory.switched(qp, "hybrid")
    assert back == replace(HYBRID, force_goal=6.0, task="retreat")
    assert memory.switched(back, "qp") == qp


def test_a_reset_is_to_where_the_scene_began():
    memory = GainMemory()
    memory.begin(ControlSettings(stiffness=20.0, force_goal=9.0))
    assert memory.reset(replace(HYBRID, task="guide")) == ControlSettings(law="hybrid", stiffness=20.0, task="guide")


def test_another_scene_forgets_the_gains():
    memory = GainMemory()
    memory.switched(HYBRID, "qp")
    memory.begin(ControlSettings())
    assert memory.switched(ControlSettings(law="qp"), "hybrid").force_gain == ControlSettings().force_gain


def test_every_setting_is_a_gain_or_says_what_is_to_be_done():
    assert {*GAINS, *TASK, "law", "max_force"} == set(asdict(ControlSettings()))
    assert not set(GAINS) & set(TASK)
    for law in CHOICES["law"]:
        assert heeded(ControlSettings(law=law)) & set(GAINS)
