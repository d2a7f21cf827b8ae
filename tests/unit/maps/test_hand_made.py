"""A drawing's points find their taxels, and drawings of something else are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.errors import MapError
from app.maps.hand_made import hand_made
from app.skin.exchange.taxel_set import TaxelSet
from tests.numerics.map_surfaces import sheet, skin_of


@pytest.fixture
def skin():
    return skin_of(sheet())


@pytest.fixture
def drawn(skin):
    positions = skin.patches[0].taxels.positions
    points = positions[:, :2] * 2.0
    points[3] = np.nan
    order = np.random.default_rng(0).permutation(len(positions))
    return TaxelSet("drawn", "patch", np.arange(len(order)), positions[order], points=points[order])


def test_each_point_goes_to_its_own_taxel(skin, drawn):
    layout = hand_made(drawn, skin)
    positions = skin.patches[0].taxels.positions
    assert len(layout.points) == len(positions) - 1
    assert 3 not in layout.numbers
    np.testing.assert_allclose(layout.points, 2 * positions[layout.numbers, :2])


def test_a_taxel_drawn_twice_counts_once(skin, drawn):
    assert drawn.points is not None
    twice = TaxelSet(
        "twice",
        "patch",
        np.arange(2 * len(drawn)),
        np.tile(drawn.positions, (2, 1)),
        points=np.tile(drawn.points, (2, 1)),
    )
    numbers = hand_made(twice, skin).numbers
    assert len(np.unique(numbers)) == len(numbers)


def test_a_drawing_of_another_body_is_refused(skin, drawn):
    with pytest.raises(MapError, match=r"not of this skin.*mm from"):
        hand_made(replace(drawn, positions=drawn.positions + 0.5), skin)


def test_a_file_without_points_is_refused(skin, drawn):
    with pytest.raises(MapError, match="no map points"):
        hand_made(replace(drawn, points=None), skin)
