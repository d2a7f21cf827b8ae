"""The cover's blur as a matrix."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.spread import Spread
from app.errors import MapError
from app.touch.buried import buried
from app.touch.points import skin_points
from tests.unit.contacts.estimators.contacts_by_hand import SKIN

ALL = np.arange(len(SKIN))


@pytest.mark.parametrize("depth", [0.002, 0.008])
def test_its_columns_keep_force(depth):
    """What an area bears is felt by all taxels together, whatever the depth."""
    matrix = Spread(SKIN, depth).blur(ALL).matrix
    np.testing.assert_allclose(SKIN.areas @ matrix, SKIN.areas, rtol=1e-9)
    assert (matrix >= 0).all()
    assert np.diag(matrix).min() > 0.1


def test_it_says_what_the_half_space_model_feels():
    pressures = np.random.default_rng(0).random(len(SKIN))
    points, felt = skin_points(SKIN), np.zeros(len(SKIN))
    buried(SKIN, 0.004).add(felt, np.arange(len(points.areas)), pressures[points.taxel] * points.areas)
    np.testing.assert_allclose(Spread(SKIN, 0.004).blur(ALL).matrix @ pressures, felt, rtol=1e-9)


def test_a_part_is_a_part_of_the_whole_and_is_kept():
    spread, part = Spread(SKIN, 0.004), np.array([3, 17, 40])
    np.testing.assert_array_equal(spread.blur(part).matrix, spread.blur(ALL).matrix[np.ix_(part, part)])
    assert spread.blur(part) is spread.blur(part)


def test_the_newest_parts_are_kept():
    spread = Spread(SKIN, 0.004)
    parts = [np.array([k, k + 1, k + 2]) for k in range(40)]
    kept = [spread.blur(part) for part in parts]
    assert all(spread.blur(part) is blur for part, blur in zip(parts[-10:], kept[-10:], strict=True))


@pytest.mark.parametrize("depth", [0.0, -1.0, float("nan"), float("inf")])
def test_a_depth_that_is_none_is_refused(depth):
    with pytest.raises(MapError, match="deep"):
        Spread(SKIN, depth)
