"""The experiment that holds laws to theory: its cases, rows and figures."""

from __future__ import annotations

import pytest

from app.experiments.control_theory import EXPERIMENT, cases, measure
from app.experiments.theory_figures import FIGURES
from app.experiments.theory_rows import FAST, IDEAL_JOINTS, OURS, PERIOD, PLANTS, ROWS


def test_every_figure_has_its_cases_once():
    for quick in (True, False):
        asked = cases(quick, 3)
        assert len({tuple(sorted(case.items(), key=lambda item: item[0])) for case in asked}) == len(asked)
        assert {case["figure"] for case in asked} == set(FIGURES) == set(ROWS)
        assert {case["seed"] for case in asked} == {3}


def test_all_is_measured_with_ideal_joints_and_simulated_ones():
    plants = {case["plant"] for case in cases(False, 0) if case["figure"] == "stability"}
    assert plants == set(PLANTS)
    assert {case["delay"] for case in cases(False, 0) if case["figure"] == "stability"} == set(range(5))
    assert FAST not in {case["plant"] for case in cases(True, 0)}


def test_a_row_says_what_was_measured_and_how_far_it_is_off():
    (case,) = [
        case
        for case in cases(True, 0)
        if (case["figure"], case["plant"], case["delay"], case["what"]) == ("settling", IDEAL_JOINTS, 2, "place")
    ]
    (row,) = measure(case)
    assert row["x"] == pytest.approx(2.5 * PERIOD)
    assert row["measured"] == row["theory"] == row["explained"] == 16 * PERIOD
    assert row["off_percent"] == 0
    assert measure(case) == [row], "the same each time"


def test_the_experiment_is_called_as_it_is_asked_for():
    assert EXPERIMENT.name == "control-theory"
    assert OURS in {case["plant"] for case in EXPERIMENT.cases(True, 0)}
