"""Milliseconds in words: live where an effect is a stage, beside where it is not, nothing where it is off."""

from __future__ import annotations

from app.scene.scene import Scene
from app.timing import Timings
from widgets.panels.effect_costs import EffectCosts

ROWS = {row.name: row for row in Scene("s", "arm", wishes={"noise": "on", "gravity": "on"}).decision.rows}


def test_a_stage_costs_its_median_here_and_now():
    costs = EffectCosts()
    for milliseconds in (0.1, 0.3, 9.0):
        costs.add(Timings({"physics": 1.0, "touch": milliseconds, "noise": 0.02}))
    costs.prices = {"skin": 7.0, "noise": 7.0}
    assert (costs.of(ROWS["skin"]).words, costs.of(ROWS["skin"]).beside) == ("0.30", False)
    assert (costs.of(ROWS["noise"]).words, costs.of(ROWS["noise"]).beside) == ("0.02", False)


def test_what_is_no_stage_costs_what_was_measured_beside():
    costs = EffectCosts()
    assert costs.of(ROWS["gravity"]).words == "…"
    costs.prices = {"gravity": 0.123}
    assert (costs.of(ROWS["gravity"]).words, costs.of(ROWS["gravity"]).beside) == ("0.12", True)
    costs.prices = {"gravity": -0.001}
    assert costs.of(ROWS["gravity"]).words == "<0.01"
    assert costs.of(ROWS["timestep"]).words == "–", "it cannot be left out"


def test_what_is_off_costs_nothing_whatever_was_measured():
    costs = EffectCosts()
    costs.add(Timings({"crosstalk": 1.0}))
    costs.prices = {"crosstalk": 1.0}
    assert costs.of(ROWS["crosstalk"]).words == "–"


def test_a_stage_that_was_switched_off_is_forgotten():
    costs = EffectCosts()
    costs.add(Timings({"touch": 0.2, "noise": 0.5}))
    costs.add(Timings({"touch": 0.2}))
    costs.prices = {"noise": 0.1}
    assert costs.of(ROWS["noise"]).beside


def test_the_total_is_told_beside_the_time_there_is():
    costs = EffectCosts()
    assert costs.total == ""
    costs.clear(0.005)
    costs.add(Timings({"physics": 1.0, "touch": 0.25}))
    assert costs.total == "1.25 of 5\u2009ms a tick"
    costs.clear(0.01)
    assert costs.total == ""
