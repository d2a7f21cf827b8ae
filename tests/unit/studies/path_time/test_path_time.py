"""The study of control: what is known of a skin, gains by theory, rows and figures."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from app.studies.sweeps.control_cost import (
    BOUND,
    FACTORS,
    LAG,
    NOMINAL,
    SEEDS,
    STIFFNESS,
    STUDY,
    WRENCH_NOISE,
    SkinKnowledge,
    bootstrap_median,
    cases,
    figures,
    knowledge_with,
    least_time,
    result_row,
    setup_knowing,
    tune_gains,
)

from app.contacts.pipeline import ReadingSettings
from app.control.command import ControlSettings
from app.control.controller_registry import check_settings
from app.control.controllers import CONTROL_SCHEMES
from app.control.limits import Limit, LimitKind
from app.studies.figures import BarChart, Figure
from app.studies.path_time.speed_search import CourseFault, SpeedSearchResult
from app.studies.testbeds.beside_ball import beside_ball
from app.studies.testbeds.force_loop import critical_gain
from app.studies.testbeds.path_following import PathRun
from app.tactile.sensor_effects import Noise, Sampling
from tests.numerics.control_theory.sampled_loop import sampled_loop_limit
from tests.support.pressed_arm import forearm


@pytest.fixture(scope="module")
def prepared():
    return beside_ball(forearm(), taxel=150)


@pytest.mark.parametrize(("factor", "level"), NOMINAL.items())
def test_the_nominal_level_of_each_factor_is_the_nominal(factor, level):
    assert knowledge_with(factor, level) == SkinKnowledge()
    assert level not in FACTORS[factor]
    assert all(knowledge_with(factor, other) != SkinKnowledge() for other in FACTORS[factor]) or factor == "tolerance"


def test_the_nominal_is_a_skin_that_is_read_at_once_and_believed_as_it_is(prepared):
    setup = setup_knowing(prepared, SkinKnowledge(), 0)
    assert setup.believed is None
    assert setup.sensor.noise is None
    assert setup.sensor.sampling == Sampling(50.0, 0.0)
    assert setup.reading == ReadingSettings()


def test_rate_delay_and_noise_are_the_sensors(prepared):
    setup = setup_knowing(prepared, replace(knowledge_with("rate", 20.0), delay=2, noise=100.0), 0)
    assert setup.sensor.sampling == Sampling(20.0, 0.1)
    assert setup.sensor.noise == Noise(100.0)


def test_a_misplaced_skin_is_believed_and_not_touched(prepared):
    setups = [setup_knowing(prepared, knowledge_with("misplaced", 3.0, by), 1) for by in ("taxel", "module")]
    moved = [
        np.linalg.norm(setup.map.skin.patches[0].taxels.positions - prepared.skin.patches[0].taxels.positions, axis=1)
        for setup in setups
    ]
    assert all(0.002 < np.median(away) < 0.007 for away in moved)
    assert not np.allclose(*moved)
    assert setups[0].prepared is prepared
    assert setup_knowing(prepared, knowledge_with("misplaced", 3.0), 1).believed is setups[0].believed, "made once"
    assert setup_knowing(prepared, knowledge_with("misplaced", 3.0), 2).believed is not setups[0].believed


def test_a_map_is_made_by_a_method_or_learned(prepared):
    conformal = setup_knowing(prepared, knowledge_with("map", "lscm"), 0)
    assert conformal.map.charts[0].method == "lscm"
    assert conformal.map.skin is prepared.skin
    learned = setup_knowing(prepared, knowledge_with("map", "information-distance"), 0)
    assert len(learned.map.skin) == len(prepared.skin)
    assert "information" in learned.map.charts[0].method


def test_the_lumped_sensor_has_its_own_noise(prepared):
    assert setup_knowing(prepared, knowledge_with("estimator", "lumped"), 0).reading == ReadingSettings(
        "lumped", None, WRENCH_NOISE
    )
    assert setup_knowing(prepared, knowledge_with("estimator", "tikhonov"), 0).reading == ReadingSettings("tikhonov")


NOMINAL_SETTINGS = ControlSettings(controller="hybrid", task="follow_path")


@pytest.mark.parametrize("delay", range(6))
@pytest.mark.parametrize("period", [0.001, 0.02, 0.1])
def test_no_loop_is_faster_than_it_can_be_without_overshoot(period, delay):
    settings = check_settings(tune_gains(NOMINAL_SETTINGS, period, delay))
    assert settings.position_gain * period <= critical_gain(delay)
    assert settings.force_gain * STIFFNESS * period <= critical_gain(delay)
    assert settings.force_gain * STIFFNESS * period < sampled_loop_limit(delay)


def test_a_fast_skin_leaves_the_posture_loops_lag_and_the_given_force_gain():
    settings = tune_gains(NOMINAL_SETTINGS, 1e-6, 0)
    assert settings.position_gain == pytest.approx(1 / (2.718281828 * LAG), rel=1e-3)
    assert settings.force_gain == pytest.approx(NOMINAL_SETTINGS.force_gain, rel=1e-3)
    assert settings.integral_time == pytest.approx(NOMINAL_SETTINGS.integral_time, rel=1e-3)


def test_the_integral_goes_with_the_gain():
    settings = tune_gains(NOMINAL_SETTINGS, 0.1, 2)
    assert settings.force_gain * settings.integral_time == pytest.approx(
        NOMINAL_SETTINGS.force_gain * NOMINAL_SETTINGS.integral_time
    )


def test_theorys_own_example():
    """20 Hz, one sample late, 200 mm, 2 mm: 20 s."""
    assert least_time(0.2, 0.002, 0.05, 1) == pytest.approx(20.0)


def made(controller="qp", factor="nominal", level="", seconds=3.0, **said):
    return {
        "robot": "arm",
        "controller": controller,
        "factor": factor,
        "level": level,
        "jacobian": "smoothed",
        "by": "taxel",
        "seed": 0,
        "seconds": seconds,
        "bound_s": 0.6,
    } | said


def test_every_controller_meets_every_level_of_every_factor_on_our_own_arm():
    found = [case for case in cases(False, 0) if case["robot"] == "arm" and case["seed"] == 0]
    for factor, levels in FACTORS.items():
        kinds = 4 if factor == "misplaced" else 1
        asked = Counter((case["controller"], case["level"]) for case in found if case["factor"] == factor)
        others = {key: count for key, count in asked.items() if key[1] != NOMINAL[factor]}
        assert others == {(controller, level): kinds for controller in CONTROL_SCHEMES for level in levels}
    assert {case["robot"] for case in cases(False, 0)} == {"arm", "ur5e", "icub"}
    assert {case["seed"] for case in cases(False, 7)} == set(range(7, 7 + SEEDS))


def test_no_case_is_measured_twice():
    for quick in (True, False):
        keys = [tuple(case.items()) for case in cases(quick, 0)]
        assert len(keys) == len(set(keys))
    assert len(cases(True, 0)) < 30


def course(error=0.002, finished=2.0) -> PathRun:
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


def test_a_row_tells_what_was_found():
    found = result_row(SpeedSearchResult(0.02, course(), CourseFault.ERROR, 4), ControlSettings(controller="qp"))
    assert (found["verdict"], found["limited_by"], found["why_limited"]) == ("met", "error", "joint speed")
    assert (found["seconds"], found["speed_mm_s"], found["error_mm"]) == pytest.approx((2.0, 20.0, 2.0))
    assert found["force_n"] == pytest.approx(0.1)


def test_a_row_of_what_cannot_says_so_and_tells_the_least_error():
    found = result_row(SpeedSearchResult(None, course(0.005), CourseFault.ERROR, 3), ControlSettings(controller="qp"))
    assert found["verdict"] == "cannot"
    assert found["seconds"] is None
    assert found["error_mm"] == pytest.approx(5.0)


def test_medians_count_what_cannot_as_endless():
    assert bootstrap_median([1.0, 2.0, 9.0])[0] == 2.0
    low, high = bootstrap_median([1.0, 2.0, 9.0])[1:]
    assert 1.0 <= low < 2.0 < high <= 9.0
    assert bootstrap_median([1.0, math.inf, math.inf])[0] == math.inf
    assert bootstrap_median([1.0, 1.5, math.inf])[0] == 1.5


def test_curves_hold_the_nominal_and_the_bound_of_theory():
    rows = [made(), made(factor="rate", level=10.0, seconds=5.0, bound_s=3.0),
            made(factor="rate", level=100.0, seconds=2.5, bound_s=0.3)]  # fmt: skip
    (figure,) = [figure for figure in figures(rows) if isinstance(figure, Figure)]
    (panel,) = figure.panels
    assert panel.curves["qp"] == [(10.0, 5.0), (50.0, 3.0), (100.0, 2.5)]
    assert panel.curves[BOUND] == [(10.0, 3.0), (50.0, 0.6), (100.0, 0.3)]
    assert panel.intervals["qp"][0] == (10.0, 5.0, 5.0)
    assert "posture loop" in figure.note, "why the simulator departs stands beside"


def test_each_way_of_being_misplaced_is_a_panel_that_begins_at_its_own_nominal():
    rows = [made(), made(factor="misplaced", level=0.0, jacobian="raw", seconds=3.5)]
    rows += [
        made(factor="misplaced", level=3.0, jacobian=jacobian, by=by, seconds=9.0)
        for by in ("taxel", "module")
        for jacobian in ("smoothed", "raw")
    ]
    (figure,) = figures(rows)
    assert len(figure.panels) == 4
    starts = {panel.title: panel.curves["qp"][0] for panel in figure.panels}
    assert starts["arm, by module, raw Jacobian"] == (0.25, 3.5)
    assert starts["arm, by taxel, smoothed Jacobian"] == (0.25, 3.0)


def test_names_are_bars_and_what_cannot_is_named():
    rows = [made(), made(factor="estimator", level="lumped", seconds=None)]
    (bars,) = figures(rows)
    assert isinstance(bars, BarChart)
    assert bars.amounts["qp, area-sum"] == 3.0
    assert "qp, lumped" in bars.note


def test_the_page_says_how_it_was_measured():
    assert STUDY.name == "control-cost"
    for word in ("bisection", "3 mm", "0.6 N", "bootstrap", "not possible"):
        assert word in STUDY.method
