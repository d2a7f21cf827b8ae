"""Non-negative pressures on a region."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.area_sum import AreaSum
from app.contacts.estimators.table import make_estimator
from tests.unit.contacts.estimators.contacts_by_hand import PITCH, SKIN, reading, without_region


@pytest.mark.parametrize("depth", [0.25 * PITCH, 0.5 * PITCH, PITCH])
def test_force_is_found_below_a_cover_and_its_peak_is_sharper(depth):
    given = reading(depth=depth)
    found, summed = make_estimator("local-nnls", SKIN, depth=depth).estimate(given), AreaSum(SKIN).estimate(given)
    assert found.force == pytest.approx(10.0, rel=0.12)
    assert (found.forces >= 0).all()
    assert found.forces.max() >= summed.forces.max()
    assert found.refused == ""
    assert found.at == given.region.at
    assert found.forces.sum() == pytest.approx(found.force)


def test_five_percent_noise_makes_little_of_a_difference():
    depth = 0.5 * PITCH
    given = reading(depth=depth, noise=0.05 * reading(depth=depth).region.peak)
    found = make_estimator("local-nnls", SKIN, depth=depth).estimate(given)
    assert found.force == pytest.approx(10.0, rel=0.12)
    assert 0.1 < found.misfit < 2.0


def test_too_deep_a_cover_tells_a_total_but_no_distribution():
    depth = 2 * PITCH
    exact = reading(depth=depth)
    given = reading(depth=depth, noise=0.1 * exact.region.peak)
    found = make_estimator("local-nnls", SKIN, depth=depth).estimate(given)
    assert "forces can be told apart" in found.refused
    assert len(found.forces) == len(found.taxels) == 0
    assert found.force == pytest.approx(10.0, rel=0.25)


def test_nothing_is_nothing():
    found = make_estimator("local-nnls", SKIN, depth=0.004).estimate(without_region(reading(depth=0.004)))
    assert found.force == 0.0
    assert np.isfinite(found.residual)
