"""Colours of a tactile image distinguish pressure, missing skin and missing readings."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.pressure_colours import COLOURS, colour_image, rounded_scale
from tests.support.recordings import small_arm


@pytest.fixture(scope="module")
def image():
    return TactileImage(small_arm().map, width=48)


def test_zero_pressure_is_pale_and_full_scale_dark_red(image):
    taxels = image.weights.shape[1]
    assert (colour_image(image, np.zeros(taxels), 5.0)[image.inside] == COLOURS[0]).all()
    for pressure in (5_000.0, 50_000.0):
        assert (colour_image(image, np.full(taxels, pressure), 5.0)[image.inside] == COLOURS[255]).all()


def test_background_is_white_and_a_dead_taxel_grey(image):
    pressures = np.zeros(image.weights.shape[1])
    pressures[7] = np.nan
    picture = colour_image(image, pressures, 5.0)
    assert (picture[~image.shown] == 255).all()
    row, column = image.pixel(image.map.taxel_points[7])
    assert tuple(picture[row, column]) == (128, 128, 128)


def test_higher_pressure_is_darker(image):
    shades = [
        colour_image(image, np.full(image.weights.shape[1], p), 10.0)[image.inside][0].sum() for p in (0, 2e3, 9e3)
    ]
    assert shades[0] > shades[1] > shades[2]


@pytest.mark.parametrize(
    ("largest", "scale"), [(0.0, 1), (1.0, 1), (1.01, 2), (4.0, 5), (5.0, 5), (7.0, 10), (10.0, 10), (101.0, 200)]
)
def test_scale_ends_at_the_next_round_number(largest, scale):
    assert rounded_scale(largest) == scale
