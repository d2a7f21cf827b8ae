"""What the estimators that undo the blur say of themselves is true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.estimators.blur import Blur
from app.contacts.estimators.local_nnls import nonnegative
from app.contacts.estimators.table import make_estimator
from app.contacts.estimators.tikhonov import smoothed
from tests.unit.contacts.estimators.contacts_by_hand import PITCH, SKIN, reading

DEPTH = 0.5 * PITCH


@pytest.mark.parametrize("solver", [nonnegative, smoothed])
def test_the_slope_is_what_small_changes_of_readings_do(solver):
    """Against differences; for a price that stays the same."""
    random = np.random.default_rng(1)
    blur = Blur.of(np.eye(6) + 0.2 * random.random((6, 6)))
    readings = blur.matrix @ np.array([3.0, 2.0, 5.0, 0.7, 4.0, 1.0])
    found, slope = solver(blur, readings, 0.0)
    for taxel in range(6):
        nudged = readings + 1e-6 * np.eye(6)[taxel]
        assert (solver(blur, nudged, 0.0).pressures - found) / 1e-6 == pytest.approx(slope[:, taxel], abs=1e-6)


@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_the_error_bar_is_how_far_noise_moves_the_force(name):
    estimator, exact = make_estimator(name, SKIN, depth=DEPTH), reading(depth=DEPTH)
    noise = 0.02 * exact.region.peak
    random, forces = np.random.default_rng(0), []
    told = []
    for _ in range(300):
        noisy = replace(exact, noise=noise, pressures=exact.pressures + random.normal(0, noise, len(SKIN)))
        estimate = estimator.estimate(noisy)
        forces.append(estimate.force)
        told.append(estimate.force_error)
    assert np.std(forces) == pytest.approx(np.median(told), rel=0.15)


@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_the_error_bar_knows_of_gains(name):
    estimator, exact = make_estimator(name, SKIN, depth=DEPTH), reading(depth=DEPTH)
    random, forces = np.random.default_rng(0), []
    for _ in range(300):
        gains = 1 + random.normal(0, 0.05, len(SKIN))
        forces.append(estimator.estimate(replace(exact, pressures=gains * exact.pressures)).force)
    assert np.std(forces) == pytest.approx(estimator.estimate(replace(exact, gain=0.05)).force_error, rel=0.2)


def test_a_peak_and_a_mean_are_told_of_what_presses():
    found = make_estimator("local-nnls", SKIN, depth=DEPTH).estimate(reading(depth=DEPTH))
    pressures = found.forces / SKIN.areas[found.taxels]
    assert found.peak == pytest.approx(pressures.max())
    pressed = pressures > 0
    assert found.mean == pytest.approx(np.average(pressures[pressed], weights=SKIN.areas[found.taxels][pressed]))


def test_regions_that_take_turns_are_both_remembered():
    estimator = make_estimator("tikhonov", SKIN, depth=DEPTH)
    one = reading(depth=DEPTH)
    other = replace(one, region=replace(one.region, taxels=one.region.taxels[:-3]))
    first = estimator.estimate(one)
    estimator.estimate(other)
    assert estimator.estimate(one).force == first.force
