"""Runs within a budget: whole seeds first, the same results as the full study, and open questions are reported."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

from tactile_maps.studies.running.case_run import CaseRun
from tactile_maps.studies.running.sequential import Outcome, PairedEffect, Settled, run_within

SEEDS = 20
EFFECTS = {"nominal": 0.0, "same": 0.0, "near": 0.01, "large": 0.5, "small": 0.2, "smaller": -0.3, "cannot": math.inf}
EFFECT = PairedEffect(("robot", "factor"), lambda row: row["value"], {"factor": "nominal"}, band=0.1)
CASES = [
    {"robot": robot, "factor": factor, "seed": seed}
    for robot in ("arm", "other")
    for factor in EFFECTS
    for seed in range(SEEDS)
]
MEASURED = []


def measure(case):
    """Common effect of a seed, larger than most effects; its residue is smaller."""
    MEASURED.append(case)
    of_seed = np.random.default_rng(case["seed"]).normal()
    own = np.random.default_rng([case["seed"], len(case["robot"]), len(case["factor"])]).normal(scale=0.04)
    return [{"value": of_seed + own + EFFECTS[case["factor"]]}]


@pytest.fixture(autouse=True)
def nothing_measured():
    MEASURED.clear()


def ever():
    return time.monotonic() + 1000.0


def results(rows):
    return {group: EFFECT.verdict(known)[0] for group, known in EFFECT.effects(rows).items()}


def test_sequential_verdict_equals_the_full_one_with_fewer_cases():
    full = CaseRun("x", measure, CASES)
    full.go_on()
    run = CaseRun("x", measure, CASES)
    outcome = run_within(run, until=ever(), effect=EFFECT)
    assert results(run.rows) == results(full.rows)
    output = list(results(full.rows).values())
    assert {Settled.DIFFERS, Settled.EQUIVALENT} == set(output)
    assert output.count(Settled.EQUIVALENT) == 4
    assert outcome == Outcome(len(CASES) - run.done, ())
    assert run.done < 0.7 * len(CASES)


def test_complete_seeds_come_first_and_omitted_cases_are_reported(monkeypatch):
    now = 0.0

    def slow(case):
        nonlocal now
        now += 1.0
        return measure(case)

    monkeypatch.setattr(time, "monotonic", lambda: now)
    run = CaseRun("x", slow, CASES)
    outcome = run_within(run, until=30.0)
    each = len(CASES) // SEEDS
    assert [case["seed"] for case in MEASURED] == [0] * each + [1] * each + [2] * (30 - 2 * each)
    assert outcome.undecided == (
        f"The time is over, and {len(CASES) - 30} of {len(CASES)} cases are missing: 2 of 20 seeds are complete.",
    )
    outcome = run_within(run, until=30.0, effect=EFFECT)
    assert outcome.undecided[1].startswith("arm, same: the effect is between ")
    assert outcome.undecided[1].endswith("; seeds: 3.")
    nothing = run_within(CaseRun("x", slow, CASES), until=0.0, effect=EFFECT)
    assert nothing.undecided == ("The time is over, and 280 of 280 cases are missing: 0 of 20 seeds are complete.",)


def test_few_seeds_and_wide_intervals_give_no_decision():
    assert EFFECT.verdict([]) == (Settled.OPEN, None)
    assert EFFECT.verdict([9.0] * 4)[0] is Settled.OPEN
    assert EFFECT.verdict([9.0] * 5)[0] is Settled.DIFFERS
    assert EFFECT.verdict([-9.0] * 5)[0] is Settled.DIFFERS
    assert EFFECT.verdict([0.01] * 5)[0] is Settled.EQUIVALENT
    assert EFFECT.verdict([0.06, 0.03, 0.07, 0.2, 0.3])[0] is Settled.OPEN
    assert EFFECT.verdict([math.inf] * 5)[0] is Settled.DIFFERS


def test_nominal_group_runs_as_long_as_a_group_requires_it():
    rows = [
        {"robot": "arm", "factor": factor, "seed": seed, "value": value}
        for factor, value in (("nominal", 0.0), ("large", 1.0))
        for seed in range(5)
    ]
    assert EFFECT.settled(rows) == {EFFECT.group(row) for row in rows}
    rows += [{"robot": "arm", "factor": "new", "seed": 0, "value": 0.0}]
    assert EFFECT.settled(rows) == {EFFECT.group(rows[5])}
