"""Estimators of force below a cover, and the whole map as their peer."""

from __future__ import annotations

import pytest

from tactile_maps.studies.base.hypotheses import Verdict
from tactile_maps.studies.sweeps.force_estimators import ESTIMATORS, REGIONAL, STUDY, WHOLE, cases, measure


def row(estimator, bias, *, seed=0, depth=0.5, noise=0.05):
    return {"estimator": estimator, "depth": depth, "noise": noise, "seed": seed, "bias": bias, "rms": bias}


@pytest.mark.long
def test_noise_becomes_force_on_the_whole_map_but_not_in_the_region():
    found = {case["estimator"]: measure(case)[0]["bias"] for case in cases(True, 0)}
    assert set(found) == set(ESTIMATORS)
    assert found[WHOLE] > 0.5
    assert all(abs(bias) < 0.12 for name, bias in found.items() if name != WHOLE)


@pytest.mark.parametrize(("bias", "verdict"), [(0.05, Verdict.HELD), (0.2, Verdict.NOT_HELD)])
def test_region_estimate_must_be_five_times_better_at_every_depth(bias, verdict):
    rows = [row(WHOLE, 0.6, seed=seed, depth=depth) for seed in range(3) for depth in (0.5, 1.0)]
    rows += [row(REGIONAL, bias, seed=seed, depth=depth) for seed in range(3) for depth in (0.5, 1.0)]
    judged = STUDY.hypotheses[0].judge(rows)
    assert judged.verdict is verdict
    assert judged.rows == 12
    assert STUDY.hypotheses[0].judge([]).verdict is Verdict.NOT_DECIDED
    half = [one for one in rows if one["estimator"] == WHOLE or one["depth"] == 1.0]
    decided = Verdict.NOT_DECIDED if verdict is Verdict.HELD else verdict
    assert STUDY.hypotheses[0].judge(half).verdict is decided, "rows of one depth are missing"
