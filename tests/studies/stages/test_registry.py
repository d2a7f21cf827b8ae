"""The stages in the order of touch, each drawn in all its errors; whether their settings edit the map."""

from __future__ import annotations

import pickle
from dataclasses import replace

import pytest

from tactile_maps.studies.stages.registry import STAGES, edits_map
from tactile_maps.studies.study.work_precision import Setting, diagram, run_trials


def test_stages_are_in_the_order_of_touch():
    assert list(STAGES) == ["cut", "flatten", "image", "touch", "simulation", "control"]
    assert all(stage.name == name for name, stage in STAGES.items())


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] if name in ("cut", "image") else []) for name in STAGES]
)
def test_each_error_of_a_stage_can_be_drawn(name, tube):
    stage = STAGES[name]
    trials = list(run_trials(stage, tube, progress=lambda *_: None))
    assert [t.setting for t in trials if t.usable] == list(stage.settings(tube)), "each once, none failed"
    for kind in stage.errors:
        made = diagram(stage, trials, error=kind.key)
        assert made.error_name == kind.name
        assert {p.setting.method for p in made.points} == {s.method for s in stage.settings(tube)}
    legend = stage.certainty.startswith("Upright lines are 95\u202f% intervals")
    assert legend or "there is no interval" in stage.certainty
    assert all(bool(trial.intervals) is legend for trial in trials if trial.usable), "what is said of them is so"
    assert stage.seconds(tube) > 0
    assert pickle.loads(pickle.dumps(trials)) == trials, "they cross from the process that measured them"
    assert pickle.loads(pickle.dumps(tube)).title == tube.title == "tube"


def test_only_map_settings_are_edits():
    assert [edits_map(Setting(name, "any")) for name in STAGES] == [True, True, False, False, False, False]


def test_subject_has_a_short_name(bodies, tube):
    assert tube.title == "tube"
    assert replace(tube, patches=(0, 1)).title == "all patches"
    assert replace(tube, patches=()).title == "no patch"
    assert replace(tube, patches=(0, 1)).faces == sum(len(patch.surface.faces) for patch in bodies.skin.patches)
