"""The estimators by name: each answers the same question."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.names import ESTIMATORS
from app.contacts.estimators.table import make_estimator
from app.contacts.estimators.wrench import Wrench
from app.errors import MapError
from tests.unit.contacts.estimators.contacts_by_hand import PLACE, SKIN, UP, reading


@pytest.mark.parametrize("name", ESTIMATORS)
def test_each_finds_the_force(name):
    given = reading(depth=0.003, wrench=Wrench(-10.0 * UP, np.cross(PLACE, -10.0 * UP)))
    found = make_estimator(name, SKIN, depth=0.003).estimate(given)
    assert found.force == pytest.approx(10.0, rel=0.1)
    assert found.refused == ""
    assert np.linalg.norm(SKIN.position(found.at) - PLACE) < 0.004


@pytest.mark.parametrize("name", ["local-nnls", "tikhonov"])
def test_a_depth_that_is_none_is_refused(name):
    with pytest.raises(MapError, match="deep"):
        make_estimator(name, SKIN, depth=0.0)
