"""A learned map is a finite place for each taxel."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.learned.learned_map import LearnedMap


def test_learned_map_copies_its_arrays():
    points = np.zeros((3, 2))
    learned = LearnedMap(points, np.ones(3, dtype=bool), "by hand", 0.0, 0.0)
    points[0] = 5
    assert not learned.points.any()
    assert not learned.points.flags.writeable


@pytest.mark.parametrize(("points", "placed"), [(np.full((3, 2), np.nan), 3), (np.zeros((3, 2)), 4)])
def test_missing_or_infinite_positions_are_rejected(points, placed):
    with pytest.raises(MapError, match="finite position"):
        LearnedMap(points, np.ones(placed, dtype=bool), "by hand", 0.0, 0.0)
