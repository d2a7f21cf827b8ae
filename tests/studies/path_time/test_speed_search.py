"""The search for the highest speed, against a course that is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.path_time.speed_search import FASTEST, SLOWEST, RunFault, Tolerances, bisect_speed
from tactile_maps.studies.testbeds.path_following import PathRun


def lagging(speed: float, *, floor=0.0005, lag=0.1, force=0.1, lost=0.0, finished=1.0) -> PathRun:
    """Errors of floor + lag times speed."""
    error = np.full(100, floor + lag * speed)
    touching = np.arange(100) >= round(100 * lost)
    error[~touching] = np.nan
    none = np.zeros(100)
    return PathRun(0.005, touching, error, error, np.full(100, 3.0 + force), none, none, finished, 0.3, 0.4)


def found(run, *, refinements=5, expected=Tolerances()):  # noqa: B008 - frozen
    return bisect_speed(run, expected, 3.0, refinements)


def test_speed_at_which_the_error_is_the_tolerance_is_found():
    result = found(lagging)
    assert result.speed == pytest.approx(0.025, rel=0.03)
    assert result.speed <= 0.025
    assert result.run.error_p95 <= 0.003
    assert result.limit is RunFault.ERROR


def test_each_refinement_halves_the_interval_by_ratio():
    coarse, fine = (found(lagging, refinements=count) for count in (0, 2))
    assert coarse.speed == pytest.approx(0.016)
    assert fine.speed / coarse.speed == pytest.approx(2**0.5)
    assert fine.runs == coarse.runs + 2


def test_case_that_fails_at_every_speed_gives_its_smallest_error():
    result = found(lambda speed: lagging(speed, floor=0.004))
    assert result.speed is None
    assert result.run.error_p95 == pytest.approx(0.004 + 0.1 * SLOWEST)
    assert result.limit is RunFault.ERROR


def test_fastest_speed_is_found_without_a_limit():
    result = found(lambda speed: lagging(speed, lag=0.0))
    assert result.speed == pytest.approx(FASTEST)
    assert result.limit is None


@pytest.mark.parametrize(
    ("fault", "output"),
    [
        ({"force": 0.7}, RunFault.FORCE),
        ({"lost": 0.02}, RunFault.CONTACT_LOST),
        ({"finished": None}, RunFault.NOT_FINISHED),
    ],
)
def test_insufficient_results_are_reported(fault, output):
    assert found(lambda speed: lagging(speed, lag=0.0, **fault)).limit is output
