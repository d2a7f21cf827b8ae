"""The control stage: the user's own robot, skin and map, controllers that go faster and farther off, a click into
force.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.controller_registry import check_settings, settings_from
from tactile_maps.control.controllers import CONTROL_SCHEMES
from tactile_maps.control.force_loop.sampled_loop import critical_gain
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import SimulationError
from tactile_maps.maps.build import build_map
from tactile_maps.studies.path_time.body_path import path_length
from tactile_maps.studies.stages.control import SPEEDS_MM_S, STAGE, stage_setting_of, with_stage_setting
from tactile_maps.studies.study.work_precision import Setting, Subject, run_trials
from tests.support.pressed_arm import forearm
from tests.support.touch import prepared_bar


@pytest.fixture(scope="module")
def subject():
    prepared = forearm()
    return Subject.of(prepared.map, prepared=prepared)


def at(controller, speed) -> Setting:
    return Setting("control", controller, {"path_speed_mm_s": speed})


def test_every_controller_at_every_speed_is_tried(subject):
    requested = STAGE.settings(subject)
    assert {(s.method, s.values["path_speed_mm_s"]) for s in requested} == {
        (r, v) for r in CONTROL_SCHEMES for v in SPEEDS_MM_S
    }
    assert STAGE.current(subject) is None
    assert STAGE.recipes is None
    assert 10 < STAGE.seconds(subject) < 60


@pytest.mark.long
def test_faster_path_takes_less_time_and_has_a_larger_error(subject):
    found = [next(iter(STAGE.trials(subject, at("hybrid", speed)))) for speed in (30.0, 90.0)]
    assert found[1].milliseconds < 0.5 * found[0].milliseconds
    assert found[1].errors["force_n"] > found[0].errors["force_n"]
    for trial in found:
        assert 0.1 < trial.errors["body_mm"] < 20.0
        assert trial.errors["lost_percent"] == 0.0
    assert found[0].name == "30\u202fmm/s"


def test_theory_predicts_the_lag_without_feedforward(subject):
    (theory,) = STAGE.theory(subject, "body_mm")
    length = path_length(settings_from(subject.prepared.scene.control))
    period = subject.prepared.scene.tick
    lag = period / critical_gain(0) + np.e * 0.05
    assert theory.error(np.array([1e3, 4e3])) == pytest.approx([1e3 * length * lag, 250 * length * lag])
    assert STAGE.theory(subject, "force_n") == []


def test_click_applies_controller_and_speed_but_not_the_gains(subject):
    before = ControlSettings(controller="impedance", force_goal=5.0, position_gain=2.0)
    taken = check_settings(with_stage_setting(before, at("parallel", 30.0)))
    assert (taken.controller, taken.task, taken.path_speed) == ("parallel", "follow_path", 0.03)
    assert (taken.force_goal, taken.position_gain) == (5.0, 2.0)
    assert stage_setting_of(taken) == at("parallel", 30.0), "and it is shown as the current setting"
    assert stage_setting_of(taken) in STAGE.settings(subject)


@pytest.mark.long
def test_unknown_controllers_are_rejected_without_stopping_the_others(subject):
    requested = [at("hybrid", 60.0), at("impedance", 60.0), at("magic", 60.0)]
    warm, *others = run_trials(replace(STAGE, settings=lambda _: requested), subject, progress=lambda *_: None)
    assert warm.usable
    assert [trial.usable for trial in others] == [False, False]
    assert all("unknown controller" in trial.note for trial in others)


@pytest.mark.long
def test_unfinished_trials_have_a_reason(subject):
    weak = replace(subject.prepared.scene, control={"max_force": 1.0})
    stopped = replace(subject, prepared=replace(subject.prepared, scene=weak))
    with pytest.raises(SimulationError, match="stopped: contact force too high"):
        list(STAGE.trials(stopped, at("hybrid", 60.0)))


def test_stage_without_an_actuated_robot_has_no_trials(subject):
    alone = replace(subject, prepared=None)
    assert list(STAGE.settings(alone)) == []
    assert STAGE.fingerprint(alone) == ""
    with pytest.raises(SimulationError, match="no robot to control"):
        list(STAGE.trials(alone, at("hybrid", 60.0)))
    fixed = prepared_bar(hinged=False)
    assert list(STAGE.settings(Subject.of(fixed.map, prepared=fixed))) == []


def test_measurement_depends_on_robot_sensor_gains_and_map(subject):
    assert STAGE.fingerprint(subject) == STAGE.fingerprint(replace(subject, patches=()))
    prepared = subject.prepared
    stronger = replace(prepared, scene=replace(prepared.scene, control={"force_goal": 5.0}))
    other = build_map(prepared.skin, method="tutte")
    changed = (subject, replace(subject, prepared=stronger), replace(subject, map=other))
    assert len({STAGE.fingerprint(each) for each in changed}) == 3
