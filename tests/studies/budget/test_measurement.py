"""Measurements for a budget are taken in the scene itself."""

from __future__ import annotations

import pytest

from tactile_maps.core.errors import BudgetError
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepared_cache import prepare_cached
from tactile_maps.studies.budget.measurement import measure_for_budget, tick_ms
from tactile_maps.studies.budget.proposal import LIVE_STAGES, Budget, propose
from tactile_maps.studies.study.work_precision import Subject
from tests.support.touch import prepared_bar


def silent(_text, _fraction):
    return


def test_stages_of_a_tick_are_timed_under_a_finger():
    bar = prepared_bar(hinged=True)
    spent = tick_ms(bar, {"integrator": "euler", "timestep": 0.0005}, ticks=5)
    assert spent["physics"] > 0
    assert spent["touch"] > 0, "a finger presses the skin"


def test_measurement_without_a_robot_is_rejected():
    with pytest.raises(BudgetError, match="no skin on a robot"):
        measure_for_budget(Subject.of(prepared_bar(hinged=False).map), paths=False, progress=silent)


@pytest.mark.long
@pytest.mark.parametrize("name", ["ur5e", "icub"])
def test_real_robots_have_settings_of_every_stage(name):
    prepared = prepare_cached(load_scene(name))
    reports = []
    subject = Subject.of(prepared.map, prepared=prepared)
    measured = measure_for_budget(subject, paths=False, progress=lambda _text, share: reports.append(share))
    assert tuple(measured.options) == LIVE_STAGES
    assert {option.trial.setting.method for option in measured.options["simulation"]} >= {"implicitfast", "discrete"}
    assert reports == sorted(reports)
    found = propose(Budget(milliseconds=50.0), measured.options, pitch_mm=measured.pitch_mm, force=measured.force)
    assert found.cost == pytest.approx(found.finest)
