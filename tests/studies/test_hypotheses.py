"""Medians over seeds, paired ratios, and when a hypothesis held."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tactile_maps.studies.base.hypotheses import (
    Interval,
    Verdict,
    all_of,
    bootstrap_median,
    paired_difference,
    paired_ratio,
    within,
)


def test_failures_count_as_infinite_in_medians():
    assert bootstrap_median([1.0, 2.0, 9.0]).middle == 2.0
    _, low, high = bootstrap_median([1.0, 2.0, 9.0])
    assert 1.0 <= low < 2.0 < high <= 9.0
    assert bootstrap_median([1.0, math.inf, math.inf]).middle == math.inf
    assert bootstrap_median([1.0, 1.5, math.inf]).middle == 1.5


def test_effects_of_a_seed_cancel_in_pairs():
    seeds = np.linspace(1.0, 5.0, 9)
    assert paired_ratio(2.0 * seeds, seeds) == pytest.approx((2.0, 2.0, 2.0))
    assert paired_difference(0.5 + seeds, seeds) == pytest.approx((0.5, 0.5, 0.5))
    unpaired = bootstrap_median((2.0 * seeds).tolist())
    assert unpaired.high - unpaired.low > 1.0


def test_intervals_cover_the_median_at_their_level():
    random = np.random.default_rng(3)
    held = sum(low <= 0.0 <= high for _ in range(200) for _, low, high in [bootstrap_median(random.normal(size=15))])
    assert 180 <= held <= 200


@pytest.mark.parametrize(
    ("interval", "verdict"),
    [
        ((1.0, 0.95, 1.05), Verdict.HELD),
        ((1.0, 0.95, 1.2), Verdict.NOT_DECIDED),
        ((1.3, 1.15, 1.5), Verdict.NOT_HELD),
        ((math.inf, math.inf, math.inf), Verdict.NOT_HELD),
        ((1.0, 1.0, math.inf), Verdict.NOT_DECIDED),
    ],
)
def test_interval_decides_the_hypothesis(interval, verdict):
    assert within(Interval(*interval), 0.9, 1.1) is verdict


def test_one_failed_part_fails_the_hypothesis():
    held = Verdict.HELD
    failed = Verdict.NOT_HELD
    open_ = Verdict.NOT_DECIDED
    assert [all_of(parts) for parts in ([held, held], [held, failed, open_], [held, open_], [])] == [
        held,
        failed,
        open_,
        open_,
    ]
