"""Theoretical expectations of path times, judged seed by seed on our own arm."""

from __future__ import annotations

import pytest

from tactile_maps.studies.base.hypotheses import Verdict
from tactile_maps.studies.path_time.expectations import (
    EFFECT,
    OF_FORCE_FEEDBACK,
    OF_REPRESENTATION,
    time_effect,
    time_ratio,
)
from tactile_maps.studies.path_time.path_time import NOMINAL

SEEDS = range(5)


def times(factor, level, seconds, *, jacobian="smoothed", robot="arm"):
    """The times of the seeds, which differ by as much as they may."""
    return [
        {
            "robot": robot,
            "factor": factor,
            "level": level,
            "jacobian": jacobian,
            "seed": seed,
            "seconds": None if seconds is None else seconds * (1 + seed),
        }
        for seed in SEEDS
    ]


NOMINALS = times(NOMINAL, "", 2.0)


def judged(name, rows):
    every = (*OF_REPRESENTATION, *OF_FORCE_FEEDBACK)
    return next(hypothesis for hypothesis in every if hypothesis.name == name).judge(rows)


def test_ratios_are_computed_for_each_seed_of_the_arm():
    rows = NOMINALS + times("pitch", 16.0, 6.0) + times("pitch", 16.0, 99.0, robot="icub")
    assert time_ratio(rows, "pitch", 16.0) == pytest.approx((3.0, 3.0, 3.0))
    assert time_ratio(rows[:-7], "pitch", 16.0) == pytest.approx((3.0, 3.0, 3.0)), "the last seeds were spared"
    assert time_ratio(rows[:5] + rows[6:], "pitch", 16.0) is None, "a seed is missing"
    assert time_ratio(rows, "pitch", 4.0) is None
    assert time_ratio([row for row in rows if row["seed"] < 2], "pitch", 16.0) is None, "of two seeds"


def test_effect_is_in_seconds_for_each_seed():
    rows = NOMINALS + times("pitch", 16.0, 6.0) + times("pitch", 4.0, None)
    assert time_effect(rows, "pitch", 16.0).middle == pytest.approx(4.0 * 3), "the middle seed takes thrice as long"
    assert time_effect(rows, "pitch", 4.0).middle == float("inf")
    assert time_effect(rows[:5] + rows[6:10], "pitch", 16.0) is None, "a seed is missing"


@pytest.mark.parametrize(("lscm", "verdict"), [(2.1, Verdict.HELD), (3.0, Verdict.NOT_HELD)])
def test_slower_path_on_a_map_of_known_stretch_contradicts_the_expectation(lscm, verdict):
    rows = NOMINALS + times("map by geometry", "lscm", lscm) + times("map by geometry", "arap", 2.0)
    assert judged("H1", rows).verdict is verdict


def test_single_triangles_must_fail_where_two_rings_succeed():
    rows = NOMINALS + times("taxels misplaced", 2.0, 4.0, jacobian="raw") + times("taxels misplaced", 7.0, 5.0)
    failing = rows + times("taxels misplaced", 3.0, None, jacobian="raw")
    assert judged("H2", failing).verdict is Verdict.HELD
    assert judged("H2", rows + times("taxels misplaced", 3.0, 4.0, jacobian="raw")).verdict is Verdict.NOT_HELD
    assert judged("H2", rows).verdict is Verdict.NOT_DECIDED


def test_learned_maps_from_biased_touch_must_fail():
    biased = "self-organising, two far places always touched together"
    good = NOMINALS + times("map learned", "self-organising", 2.0)
    assert judged("H7", good + times("map learned", biased, None)).verdict is Verdict.HELD
    assert judged("H7", good + times("map learned", biased, 2.0)).verdict is Verdict.NOT_HELD


@pytest.mark.parametrize(("name", "factor"), [("H6", "sleeve shifted"), ("H6, of force", "gain error")])
def test_constant_error_that_costs_time_contradicts_the_expectation(name, factor):
    assert judged(name, NOMINALS + times(factor, 5.0, 2.0)).verdict is Verdict.HELD
    assert judged(name, NOMINALS + times(factor, 5.0, 4.0)).verdict is Verdict.NOT_HELD
    assert judged(name, NOMINALS).verdict is Verdict.NOT_DECIDED
    assert judged(name, NOMINALS + times(factor, 5.0, 2.0)).rows == 2 * len(SEEDS)


def test_decided_level_needs_no_more_seeds():
    rows = NOMINALS + times("pitch", 16.0, 6.0) + times("pitch", 4.0, 2.1) + times("cover", 1.0, None)
    settled = EFFECT.settled(rows)
    assert {row["level"] for row in rows if EFFECT.group(row) in settled} == {16.0, 4.0, 1.0, ""}
    rows[7]["seconds"] = rows[8]["seconds"] = 2.0
    assert EFFECT.group(rows[5]) not in EFFECT.settled(rows)
