"""Properties of every study: unique cases, and figures and verdicts from the tables that are shipped."""

from __future__ import annotations

import json
import math

import pytest

from tactile_maps.core.assets import asset
from tactile_maps.studies.base.figures import BarChart, figure_svg
from tactile_maps.studies.base.hypotheses import Verdict
from tactile_maps.studies.catalogue import STUDY_NAMES, load_study
from tactile_maps.studies.running.study_table import read_study_table

SHIPPED = sorted(path.stem for path in asset("findings").glob("*.csv"))


@pytest.mark.parametrize("name", STUDY_NAMES)
def test_cases_are_unique_and_quick_cases_are_few(name):
    study = load_study(name)
    assert study.name == name
    assert study.question.endswith("?")
    full, quick = ([json.dumps(case) for case in study.cases(quick, 3)] for quick in (False, True))
    assert 0 < len(quick) < len(full)
    assert len(set(full)) == len(full)
    assert len(set(quick)) == len(quick)
    seeds = [case["seed"] for case in study.cases(False, 3)]
    assert min(seeds) == 3
    assert all(list(case).index("seed") >= len(case) - 2 for case in study.cases(False, 3)), "tables end a case with it"


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_table_gives_figures_with_points_and_verdicts(name):
    study = load_study(name)
    rows = [row for row in read_study_table(asset("findings", f"{name}.csv")).rows if row.get("problem") is None]
    drawn = study.figures(rows)
    assert bool(drawn) == (name != "contact"), "its table is the result"
    for figure in drawn:
        if isinstance(figure, BarChart):
            assert any(amount is not None for amount in figure.amounts.values())
        else:
            points = [point for panel in figure.panels for curve in panel.curves.values() for point in curve]
            assert any(math.isfinite(y) for _, y in points)
    assert all(hypothesis.judge(rows).verdict in Verdict for hypothesis in study.hypotheses)
    if drawn:
        assert figure_svg(drawn[0]).startswith("<svg")
