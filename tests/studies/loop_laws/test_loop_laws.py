"""The study of the laws of sampled loops: its cases, and when a law is said to hold."""

from __future__ import annotations

import pytest

from tactile_maps.studies.base.hypotheses import Verdict
from tactile_maps.studies.loop_laws.loop_laws import LOOP_GAINS, STUDY, figures
from tactile_maps.studies.loop_laws.predictions import IDEAL_JOINTS, PERIOD


def judged(name, rows):
    return next(hypothesis for hypothesis in STUDY.hypotheses if hypothesis.name == name).judge(rows)


def row(theory, measured, *, predicted=1.0, delay=1, x=0.0, seed=0):
    output = {"law": theory, "plant": IDEAL_JOINTS, "what": "force", "delay": delay, "x": x, "seed": seed}
    return output | {"measured": measured, "predicted": predicted, "explained": predicted}


@pytest.mark.parametrize(("times", "verdict"), [(1.05, Verdict.HELD), (1.2, Verdict.NOT_HELD)])
def test_settling_with_delayed_readings_must_match_within_ten_percent(times, verdict):
    rows = [row("settling", times * 6.4 * (delay + 0.5) * PERIOD, delay=delay) for delay in (1, 2, 3)]
    rows.append(row("settling", PERIOD, delay=0))
    assert judged("H3", rows).verdict is verdict
    assert judged("H3", rows).rows == 3


@pytest.mark.parametrize(("found", "verdict"), [(0.95, Verdict.HELD), (0.8, Verdict.NOT_HELD)])
def test_stiffness_of_onset_must_match_within_ten_percent(found, verdict):
    assert judged("H5", [row("onset", found), row("onset", 1.0, delay=0)]).verdict is verdict


def test_ripple_independent_of_the_loop_gain_contradicts_the_hypothesis():
    lawful = [row("ripple", (x / (2 - x)) ** 0.5, x=x, seed=seed) for x in LOOP_GAINS for seed in range(3)]
    constant = [{**one, "measured": 0.3} for one in lawful]
    assert judged("H4", lawful).verdict is Verdict.HELD
    assert judged("H4", constant).verdict is Verdict.NOT_HELD


@pytest.mark.parametrize("name", ["H3", "H4", "H5"])
def test_hypotheses_without_rows_are_undecided(name):
    assert judged(name, []).verdict is Verdict.NOT_DECIDED


def test_figures_show_theory_and_measurement():
    settling, onset = figures([row("settling", 2.0, delay=1), row("onset", 3.0, predicted=2.0)])
    assert settling.panels[0].curves["measured"] == [(1.5, 2.0)]
    assert onset.panels[0].curves["theory"] == [(1.5, 2.0)]
