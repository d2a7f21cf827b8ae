"""The experiment: its cases, one of them measured, and how rows are drawn."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.laws import RULES
from app.experiments.bars import Bars
from app.experiments.control_cost import EXPERIMENT, SEEDS, cases, row
from app.experiments.control_course import Course
from app.experiments.control_factors import FACTORS, NOMINAL
from app.experiments.control_figures import BOUND, figures, sure
from app.experiments.plot import Figure
from app.experiments.speed_search import Found


def made(law="qp", factor="nominal", level="", seconds=3.0, **said):
    return {"robot": "arm", "law": law, "factor": factor, "level": level, "jacobian": "smoothed", "by": "taxel",
            "seed": 0, "seconds": seconds, "bound_s": 0.6} | said  # fmt: skip


def test_every_law_meets_every_level_of_every_factor_on_our_own_arm():
    found = [case for case in cases(False, 0) if case["robot"] == "arm" and case["seed"] == 0]
    for factor, levels in FACTORS.items():
        kinds = 4 if factor == "misplaced" else 1
        asked = Counter((case["law"], case["level"]) for case in found if case["factor"] == factor)
        others = {key: count for key, count in asked.items() if key[1] != NOMINAL[factor]}
        assert others == {(law, level): kinds for law in RULES for level in levels}
    assert {case["robot"] for case in cases(False, 0)} == {"arm", "ur5e", "icub"}
    assert {case["seed"] for case in cases(False, 7)} == set(range(7, 7 + SEEDS))


def test_no_case_is_measured_twice():
    for quick in (True, False):
        keys = [tuple(case.items()) for case in cases(quick, 0)]
        assert len(keys) == len(set(keys))
    assert len(cases(True, 0)) < 30


def course(error=0.002, finished=2.0) -> Course:
    ones = np.ones(10)
    return Course(0.005, error * ones, error * ones, 3.1 * ones, 0.1 * ones, 0.0 * ones, finished, 0.3, 0.4, ("slow",))


def test_a_row_tells_what_was_found():
    found = row(Found(0.02, course(), "error", 4), ControlSettings(law="qp"))
    assert (found["verdict"], found["limited_by"], found["why_limited"]) == ("met", "error", "slow")
    assert (found["seconds"], found["speed_mm_s"], found["error_mm"]) == pytest.approx((2.0, 20.0, 2.0))
    assert found["force_n"] == pytest.approx(0.1)


def test_a_row_of_what_cannot_says_so_and_tells_the_least_error():
    found = row(Found(float("nan"), course(0.005), "error", 3), ControlSettings(law="qp"))
    assert found["verdict"] == "cannot"
    assert math.isnan(found["seconds"])
    assert found["error_mm"] == pytest.approx(5.0)


def test_medians_count_what_cannot_as_endless():
    assert sure([1.0, 2.0, 9.0])[0] == 2.0
    low, high = sure([1.0, 2.0, 9.0])[1:]
    assert 1.0 <= low < 2.0 < high <= 9.0
    assert sure([1.0, math.inf, math.inf])[0] == math.inf
    assert sure([1.0, 1.5, math.inf])[0] == 1.5


def test_curves_hold_the_nominal_and_the_bound_of_theory():
    rows = [made(), made(factor="rate", level=10.0, seconds=5.0, bound_s=3.0),
            made(factor="rate", level=100.0, seconds=2.5, bound_s=0.3)]  # fmt: skip
    (figure,) = [figure for figure in figures(rows) if isinstance(figure, Figure)]
    (panel,) = figure.panels
    assert panel.curves["qp"] == [(10.0, 5.0), (50.0, 3.0), (100.0, 2.5)]
    assert panel.curves[BOUND] == [(10.0, 3.0), (50.0, 0.6), (100.0, 0.3)]
    assert panel.spreads["qp"][0] == (10.0, 5.0, 5.0)
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
    rows = [made(), made(factor="estimator", level="lumped", seconds=float("nan"))]
    (bars,) = figures(rows)
    assert isinstance(bars, Bars)
    assert bars.amounts["qp, area-sum"] == 3.0
    assert "qp, lumped" in bars.note


def test_the_page_says_how_it_was_measured():
    assert EXPERIMENT.name == "control-cost"
    for word in ("bisection", "3 mm", "0.6 N", "bootstrap", "not possible"):
        assert word in EXPERIMENT.method
