"""Cases of path time, and the row of one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.studies.path_time import force_feedback, representation
from tactile_maps.studies.path_time.conditions import Conditions
from tactile_maps.studies.path_time.path_time import FEW_SEEDS, NOMINAL, SEEDS, conditions_of, list_cases, result_row
from tactile_maps.studies.path_time.speed_search import RunFault, SpeedSearchResult
from tactile_maps.studies.testbeds.path_following import PathRun
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import Noise, SensorEffects

STUDIES = (representation, force_feedback)


@pytest.mark.parametrize("study", STUDIES)
def test_every_level_has_the_same_number_of_seeds(study):
    found = list_cases(study.FACTORS, False, 7)
    requested = {(case["factor"], case["level"], case["jacobian"]) for case in found if case["robot"] == "arm"}
    levels = {(f.name, level, jacobian) for f in study.FACTORS for level in f.levels for jacobian in f.jacobians}
    assert {key for key in requested if key[0] != NOMINAL} == levels
    assert {case["seed"] for case in found} == set(range(7, 7 + SEEDS))
    others = [case for case in found if case["robot"] == "icub"]
    assert {case["seed"] for case in others} == set(range(7, 7 + FEW_SEEDS))
    assert {case["factor"] for case in others} == {NOMINAL, *(factor.name for factor in study.FACTORS if factor.few)}


@pytest.mark.parametrize("study", STUDIES)
def test_levels_are_distinct_conditions_and_differ_from_nominal(study):
    for factor in study.FACTORS:
        made = [factor.conditions(level) for level in factor.levels]
        assert len(set(made)) == len(made)
        assert Conditions() not in made
        if factor.nominal is not None:
            assert factor.nominal not in factor.levels
            assert set(factor.few) <= set(factor.levels)


@pytest.mark.parametrize(
    ("study", "factor", "level", "expected"),
    [
        (representation, "taxels misplaced", 3.0, Conditions(misplaced=0.003)),
        (representation, "modules misplaced", 3.0, Conditions(misplaced=0.003, by="module")),
        (representation, "sleeve shifted", 5.0, Conditions(sleeve_shift=0.005)),
        (representation, "sleeve turned", 15.0, Conditions(sleeve_turn=math.radians(15.0))),
        (
            representation,
            "map learned",
            "som, two far places always touched together",
            Conditions(map="som", touch="biased"),
        ),
        (representation, "cover", 2.0, Conditions(layer=replace(ElasticLayer(), thickness=0.016, depth=0.008))),
        (representation, "pixel, nearest", 2.0, Conditions(pixel=0.002, interpolation="nearest")),
        (representation, "cuts", 2, Conditions(cuts=2)),
        (force_feedback, "noise", 100.0, Conditions(sensor=SensorEffects(noise=Noise(100.0)))),
        (force_feedback, "estimator", "lumped", Conditions(estimator="lumped")),
        (force_feedback, "estimator", "lumped, a finger elsewhere", Conditions(estimator="lumped", touched=True)),
        (force_feedback, "controller", "qp", Conditions(controller="qp")),
    ],
)
def test_level_changes_the_stated_conditions(study, factor, level, expected):
    case = {"factor": factor, "level": level, "jacobian": "raw"}
    assert conditions_of(study.FACTORS, case) == replace(expected, jacobian="raw")


@pytest.mark.parametrize("study", STUDIES)
def test_nominal_level_of_a_factor_is_the_nominal_condition(study):
    for factor in study.FACTORS:
        # Effects that are off have no number of their own: a level of 0 is drawn for them.
        if factor.nominal and factor.name not in ("map learned",):
            assert factor.conditions(factor.nominal) == Conditions()


def path_run(error=0.002, finished=2.0) -> PathRun:
    ones = np.ones(10)
    return PathRun(
        0.005,
        ones,
        error * ones,
        error * ones,
        3.1 * ones,
        0.1 * ones,
        0.0 * ones,
        finished,
        0.3,
        0.4,
        (Limit(LimitKind.JOINT_SPEED),),
    )


def test_row_of_a_successful_search_has_the_speed_found():
    found = result_row(SpeedSearchResult(0.02, path_run(), RunFault.ERROR, 4), ControlSettings(controller="qp"))
    assert (found["verdict"], found["limited_by"], found["why_limited"]) == ("met", "error", "joint speed")
    assert (found["seconds"], found["speed_mm_s"], found["error_mm"]) == pytest.approx((2.0, 20.0, 2.0))
    assert found["force_n"] == pytest.approx(0.1)
    assert found["force_bias_n"] == pytest.approx(0.1)


def test_row_of_a_failed_search_has_the_smallest_error():
    found = result_row(SpeedSearchResult(None, path_run(0.005), RunFault.ERROR, 3), ControlSettings(controller="qp"))
    assert found["verdict"] == "cannot"
    assert found["seconds"] is None
    assert found["error_mm"] == pytest.approx(5.0)
