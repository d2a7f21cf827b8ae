"""The report of control against theory: its cases, rows, figures, and a line that says why they part."""

from __future__ import annotations

import pytest

from tests.numerics.control_theory.predictions import COMPARISONS, FAST_SERVO, IDEAL_JOINTS, OUR_SERVO, PERIOD, PLANTS
from tests.numerics.control_theory.theory_report import FIGURES, STUDY, cases, figures, measure


def row(figure, plant, measured, theory, explained, **said):
    off, left = (100 * (measured / each - 1) if each else None for each in (theory, explained))
    case = {"figure": figure, "what": "force", "controller": "hybrid", "plant": plant, "x": 0.5}
    told = {"measured": measured, "theory": theory, "explained": explained}
    return case | told | {"off_percent": off, "explained_off_percent": left} | said


def test_a_figure_has_theory_each_plant_and_the_theory_of_ours():
    rows = [row("onset", IDEAL_JOINTS, 4120.0, 4000.0, 4000.0), row("onset", OUR_SERVO, 9800.0, 4000.0, 10000.0)]
    (figure,) = figures(rows)
    (panel,) = figure.panels
    assert figure.title == FIGURES["onset"].title
    assert panel.curves["theory"] == [(0.5, 4000.0)]
    assert panel.curves[IDEAL_JOINTS] == [(0.5, 4120.0)]
    assert panel.curves[OUR_SERVO] == [(0.5, 9800.0)]
    assert panel.curves["theory with that loop"] == [(0.5, 10000.0)]


def test_its_note_says_why_and_how_far():
    rows = [row("onset", IDEAL_JOINTS, 4120.0, 4000.0, 4000.0), row("onset", OUR_SERVO, 9800.0, 4000.0, 10000.0)]
    note = figures(rows)[0].note
    assert note.startswith(FIGURES["onset"].why)
    assert "ideal joints 3 %;" in note
    assert f"{OUR_SERVO} 145 %, 2 % of the theory with it" in note


def test_whole_arms_have_a_panel_a_robot_and_a_curve_a_law():
    rows = [row("arms", robot, 0.01, 0.07, 0.011, what=robot, controller=controller) for robot in ("arm", "ur5e")
            for controller in ("hybrid", "qp")]  # fmt: skip
    (figure,) = figures(rows)
    assert [panel.title for panel in figure.panels] == ["arm", "ur5e"]
    assert list(figure.panels[0].curves) == ["theory with all joints", "hybrid", "qp"]


def test_what_the_theory_has_as_nothing_is_no_departure():
    (figure,) = figures([row("behind", OUR_SERVO, 0.5, 0.0, 0.5)])
    assert "Farthest off" not in figure.note


def test_every_figure_has_its_cases_once():
    for quick in (True, False):
        asked = cases(quick, 3)
        assert len({tuple(sorted(case.items(), key=lambda item: item[0])) for case in asked}) == len(asked)
        assert {case["figure"] for case in asked} == set(FIGURES) == set(COMPARISONS)
        assert {case["seed"] for case in asked} == {3}


def test_all_is_measured_with_ideal_joints_and_simulated_ones():
    plants = {case["plant"] for case in cases(False, 0) if case["figure"] == "stability"}
    assert plants == set(PLANTS)
    assert {case["delay"] for case in cases(False, 0) if case["figure"] == "stability"} == set(range(5))
    assert FAST_SERVO not in {case["plant"] for case in cases(True, 0)}


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
    assert STUDY.name == "control-theory"
    assert OUR_SERVO in {case["plant"] for case in STUDY.cases(True, 0)}
