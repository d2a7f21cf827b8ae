"""Figures of path time."""

from __future__ import annotations

from tactile_maps.studies.base.figures import BarChart, Figure
from tactile_maps.studies.path_time.charts import BOUND, factor_figures
from tactile_maps.studies.path_time.force_feedback import FACTORS as FEEDBACK
from tactile_maps.studies.path_time.path_time import NOMINAL
from tactile_maps.studies.path_time.representation import FACTORS as REPRESENTATION


def made(factor=NOMINAL, level="", seconds=3.0, **output):
    row = {"robot": "arm", "factor": factor, "level": level, "jacobian": "smoothed", "seed": 0, "seconds": seconds}
    return row | {"bound_s": 0.6} | output


def test_curves_contain_the_nominal_case_and_the_theoretical_bound():
    rows = [made(), made("rate", 10.0, 5.0, bound_s=3.0), made("rate", 100.0, 2.5, bound_s=0.3)]
    (figure,) = factor_figures(FEEDBACK, rows)
    assert isinstance(figure, Figure)
    (panel,) = figure.panels
    assert panel.curves["measured"] == [(10.0, 5.0), (50.0, 3.0), (100.0, 2.5)]
    assert panel.curves[BOUND] == [(10.0, 3.0), (50.0, 0.6), (100.0, 0.3)]
    assert panel.intervals["measured"][0] == (10.0, 5.0, 5.0)
    assert "posture loop" in figure.note, "the note says why the simulator differs"


def test_each_jacobian_has_a_curve_that_starts_at_its_nominal_case():
    rows = [made(), made(jacobian="raw", seconds=3.5)]
    rows += [made("taxels misplaced", 3.0, 9.0, jacobian=jacobian) for jacobian in ("smoothed", "raw")]
    (figure,) = factor_figures(REPRESENTATION, rows)
    (panel,) = figure.panels
    assert panel.curves["raw Jacobian"] == [(0.25, 3.5), (3.0, 9.0)]
    assert panel.curves["smoothed Jacobian"] == [(0.25, 3.0), (3.0, 9.0)]


def test_levels_are_bars_and_failures_are_named():
    (bars,) = factor_figures(FEEDBACK, [made(), made("estimator", "lumped", None)])
    assert isinstance(bars, BarChart)
    assert bars.amounts["area-sum"] == 3.0
    assert "lumped" in bars.note
