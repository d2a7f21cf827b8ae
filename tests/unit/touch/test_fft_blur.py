"""The blur of a grid is the sum over its cells, and nothing wraps round its borders."""

from __future__ import annotations

import numpy as np
import pytest

from app.touch.fft_blur import GridBlur
from app.touch.love import point_stress, rectangle_stress

SHAPE, PITCH, DEPTH = (17, 24), (0.0012, 0.001), 0.002


@pytest.fixture(scope="module")
def pressures():
    return np.random.default_rng(0).uniform(0, 1e4, SHAPE) * (np.random.default_rng(1).random(SHAPE) < 0.2)


def summed(pressures, stress):
    """Cell by cell; ``stress`` of a cell at steps up and across from it [m]."""
    i, j = np.indices(SHAPE)
    felt = np.zeros(SHAPE)
    for row, column in np.argwhere(pressures):
        felt += pressures[row, column] * stress(PITCH[0] * np.abs(i - row), PITCH[1] * np.abs(j - column))
    return felt


def test_it_is_the_sum_over_all_cells(pressures):
    sides = np.array(PITCH[0]), np.array(PITCH[1])
    plain = summed(pressures, lambda up, across: rectangle_stress(up, across, DEPTH, sides=sides))
    np.testing.assert_allclose(GridBlur(SHAPE, PITCH, DEPTH).felt(pressures), plain, atol=1e-9 * plain.max())


def test_on_a_bent_grid_distances_are_those_given(pressures):
    def chord(up, around):
        return np.hypot(up, 2 * 0.005 * np.sin(np.minimum(around / 0.01, np.pi / 2)))

    plain = summed(pressures, lambda *steps: np.prod(PITCH) * point_stress(chord(*steps), DEPTH))
    found = GridBlur(SHAPE, PITCH, DEPTH, distance=chord).felt(pressures)
    np.testing.assert_allclose(found, plain, atol=1e-9 * plain.max())


def test_a_load_at_a_border_is_not_felt_at_the_opposite_one():
    grid = GridBlur((64, 64), (0.001, 0.001), DEPTH)
    pressures = np.zeros((64, 64))
    pressures[:, 0] = 1e4
    felt = grid.felt(pressures)
    assert felt[32, 0] > 1e3
    assert abs(felt[:, -1]).max() < 1e-4 * felt[32, 0], "63 mm away, at a depth of 2 mm"
    assert felt[32, -1] == pytest.approx(felt[31, -1])
    assert (np.diff(felt[32]) < 0).all(), "ever less with the distance"


def test_pressure_all_over_is_felt_whole_in_the_middle_and_half_at_a_border():
    felt = GridBlur((201, 201), (0.0005, 0.0005), DEPTH).felt(np.ones((201, 201)))
    assert felt[100, 100] == pytest.approx(1, abs=2e-3)
    assert felt[100, 0] == pytest.approx(0.5, abs=0.1)
