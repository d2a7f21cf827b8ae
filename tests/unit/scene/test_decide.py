"""Decisions: wishes win, rows tell, nothing is forgotten."""

from __future__ import annotations

from app.scene.decide import WISHED, decide
from app.scene.effect_table import EFFECTS
from app.scene.needs import Needs
from app.touch.sensor.noise import Noise


def rows_of(decision):
    return {row.name: row for row in decision.rows}


def test_there_is_a_row_an_effect():
    assert [row.name for row in decide(Needs(), {}).rows] == list(EFFECTS)


def test_a_wish_wins_and_says_so():
    decision = decide(Needs(), {"gravity": "on", "timestep": 0.0005, "joint_limits": "off", "noise": {"sd": 150.0}})
    assert decision.effects.gravity == "on"
    assert decision.effects.timestep == 0.0005
    assert not decision.effects.joint_limits
    assert decision.effects.sensor.noise == Noise(sd=150.0)
    rows = rows_of(decision)
    assert rows["gravity"].wished
    assert rows["gravity"].why == WISHED
    assert rows["timestep"].value == "0.0005 s"
    assert (rows["joint_limits"].on, rows["joint_limits"].value) == (False, "off")
    assert rows["noise"].value == "on"
    assert "sd 150" in rows["noise"].why
    assert not rows["skin"].wished


def test_auto_is_no_wish():
    assert decide(Needs(), {"skin": "auto"}) == decide(Needs(), {})
