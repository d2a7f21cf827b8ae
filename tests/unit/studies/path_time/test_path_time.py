"""Cases of path time, and the row of one."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.studies.path_time import force_feedback, representation
from tactile_maps.studies.path_time.conditions import Conditions
from tactile_maps.studies.path_time.path_time import FEW_SEEDS, NOMINAL, SEEDS, conditions_of, list_cases, result_row
from tactile_maps.studies.path_time.speed_search import CourseFault, SpeedSearchResult
from tactile_maps.studies.testbeds.path_following import PathRun

STUDIES = (representation, force_feedback)


@pytest.mark.parametrize("study", STUDIES)
def test_every_level_is_met_with_as_many_seeds(study):
    found = list_cases(study.FACTORS, False, 7)
    asked = {(case["factor"], case["level"], case["jacobian"]) for case in found if case["robot"] == "arm"}
    levels = {(f.name, level, jacobian) for f in study.FACTORS for level in f.levels for jacobian in f.jacobians}
    assert {key for key in asked if key[0] != NOMINAL} == levels
    assert {case["seed"] for case in found} == set(range(7, 7 + SEEDS))
    others = [case for case in found if case["robot"] == "icub"]
    assert {case["seed"] for case in others} == set(range(7, 7 + FEW_SEEDS))
    assert {case["factor"] for case in others} == {NOMINAL, *(factor.name for factor in study.FACTORS if factor.few)}


@pytest.mark.parametrize("study", STUDIES)
def test_no_case_is_measured_twice_and_whole_seeds_come_first(study):
    for quick in (True, False):
        cases = list_cases(study.FACTORS, quick, 0)
        assert len({tuple(case.items()) for case in cases}) == len(cases)
        assert [case["seed"] for case in cases] == sorted(case["seed"] for case in cases)
    assert len(list_cases(study.FACTORS, True, 0)) < 16


@pytest.mark.parametrize("study", STUDIES)
def test_each_level_is_another_condition_and_the_nominal_one_is_none(study):
    for factor in study.FACTORS:
        made = [factor.conditions(level) for level in factor.levels]
        assert len(set(made)) == len(made)
        assert Conditions() not in made
        if factor.nominal is not None:
            assert factor.nominal not in factor.levels
            assert set(factor.few) <= set(factor.levels)


@pytest.mark.parametrize("study", STUDIES)
def test_the_nominal_level_of_a_factor_is_the_nominal_condition(study):
    for factor in study.FACTORS:
        # Effects that are off have no number of their own: a level of 0 is drawn for them.
        if factor.nominal and factor.name not in ("map learned",):
            assert factor.conditions(factor.nominal) == Conditions()


def test_a_case_says_its_jacobian():
    case = {"factor": "taxels misplaced", "level": 3.0, "jacobian": "raw"}
    assert conditions_of(representation.FACTORS, case) == Conditions(misplaced=0.003, jacobian="raw")
    assert conditions_of((), {"factor": NOMINAL, "level": "", "jacobian": "isometric"}).jacobian == "isometric"


def course(error=0.002, finished=2.0) -> PathRun:
    ones = np.ones(10)
    return PathRun(0.005, ones, error * ones, error * ones, 3.1 * ones, 0.1 * ones, 0.0 * ones, finished, 0.3, 0.4,
                   (Limit(LimitKind.JOINT_SPEED),))  # fmt: skip


def test_a_row_tells_what_was_found():
    found = result_row(SpeedSearchResult(0.02, course(), CourseFault.ERROR, 4), ControlSettings(controller="qp"))
    assert (found["verdict"], found["limited_by"], found["why_limited"]) == ("met", "error", "joint speed")
    assert (found["seconds"], found["speed_mm_s"], found["error_mm"]) == pytest.approx((2.0, 20.0, 2.0))
    assert found["force_n"] == pytest.approx(0.1)
    assert found["force_bias_n"] == pytest.approx(0.1)


def test_a_row_of_what_cannot_says_so_and_tells_the_least_error():
    found = result_row(SpeedSearchResult(None, course(0.005), CourseFault.ERROR, 3), ControlSettings(controller="qp"))
    assert found["verdict"] == "cannot"
    assert found["seconds"] is None
    assert found["error_mm"] == pytest.approx(5.0)


def test_the_page_says_how_it_was_measured():
    for study in STUDIES:
        for word in ("bisection", "3 mm", "0.6 N", "bootstrap", "not possible"):
            assert word in study.STUDY.method
