"""The sum of pressure times area."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.area_sum import AreaSum
from tests.unit.contacts.estimators.contacts_by_hand import SKIN, reading, without_region


@pytest.mark.parametrize("depth", [0.0, 0.002, 0.005])
def test_it_is_the_regions_force(depth):
    given = reading(depth=depth)
    found = AreaSum(SKIN).estimate(given)
    assert found.force == pytest.approx(given.region.force, rel=1e-12)
    assert found.force == pytest.approx(10.0, rel=0.05)
    assert found.at == given.region.at
    assert found.forces.sum() == pytest.approx(found.force)
    assert (found.condition, found.effective_rank) == (1.0, found.unknowns)
    assert found.refused == ""
    assert found.misfit == 0.0


def test_what_lies_in_the_noise_has_no_rank():
    found = AreaSum(SKIN).estimate(without_region(reading(noise=100.0)))
    assert found.force == 0.0
    assert found.effective_rank == 0
    assert np.isfinite(found.misfit)
