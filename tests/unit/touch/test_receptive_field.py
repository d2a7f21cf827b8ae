"""What taxels feel of forces on points: cells, discs, tables."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import SimulationError
from app.skin.skin import Skin
from app.touch.points import skin_points
from app.touch.receptive_field import as_table, discs, whole_cells
from tests.touch import arm, bar_skin, pair

SKIN = arm().skin
POINTS = skin_points(SKIN)


def felt(field, forces, skin=SKIN):
    pressures = np.zeros(len(skin))
    field.add(pressures, np.arange(len(forces)), forces)
    return pressures


def test_whole_cells_keep_the_force_and_read_a_uniform_pressure():
    forces = np.random.default_rng(0).uniform(0, 1, len(POINTS.areas))
    assert felt(whole_cells(SKIN), forces) @ SKIN.areas == pytest.approx(forces.sum(), rel=1e-13)
    assert felt(whole_cells(SKIN), 5e3 * POINTS.areas) == pytest.approx(np.full(len(SKIN), 5e3), rel=1e-12)


def test_it_adds_to_what_is_there_and_a_point_may_come_twice():
    skin = bar_skin()
    field, pressures = whole_cells(skin), np.full(len(skin), 7.0)
    field.add(pressures, np.array([3, 3]), np.array([1.0, 2.0]))
    taxel = skin_points(skin).taxel[3]
    assert pressures[taxel] == pytest.approx(7.0 + 3.0 / skin.areas[taxel])
    assert (np.delete(pressures, taxel) == 7.0).all()


@pytest.mark.parametrize("radius", [1e-4, 0.002, 0.008, 0.03, 1.0])
def test_discs_of_any_size_read_a_uniform_pressure(radius):
    assert felt(discs(SKIN, radius), 5e3 * POINTS.areas) == pytest.approx(np.full(len(SKIN), 5e3), rel=1e-12)


@pytest.mark.parametrize("radius", [0.004, 0.01])
def test_a_disc_is_the_mean_over_the_points_within_it(radius):
    forces = np.random.default_rng(1).uniform(0, 1, len(POINTS.areas))
    pressures, start = felt(discs(SKIN, radius), forces), 0
    checked = 0
    for patch, first in zip(SKIN.patches, SKIN.first[:-1], strict=True):
        points = patch.taxels.quadrature
        own = forces[start : start + len(points.areas)]
        start += len(points.areas)
        for taxel in range(0, len(patch.taxels), 7):
            near = np.linalg.norm(points.positions - patch.taxels.positions[taxel], axis=1) < radius
            near &= points.normals @ patch.taxels.normals[taxel] > 0
            if near.any():
                checked += 1
                assert pressures[first + taxel] == pytest.approx(own[near].sum() / points.areas[near].sum(), rel=1e-12)
    assert checked > 15


def test_what_presses_between_discs_is_not_felt_and_overlapping_discs_both_feel():
    skin = bar_skin()
    points = skin_points(skin)
    small, large = discs(skin, 0.004), discs(skin, 0.03)
    heard = [np.unique(field.taxels[field.weights > 0]).size for field in (small, large)]
    assert heard == [len(skin), len(skin)]
    unheard = np.flatnonzero(~(small.weights > 0).any(axis=1))
    assert unheard.size > 100
    assert not felt(small, np.where(np.isin(np.arange(len(points.areas)), unheard), 1.0, 0.0), skin).any()
    one = np.zeros(len(points.areas))
    one[0] = 1.0
    assert np.count_nonzero(felt(large, one, skin)) > 1


def test_a_disc_stays_on_its_patch_and_its_side():
    _, skin = pair()
    count = len(skin.patches[0].taxels.quadrature.areas)
    forces = np.zeros(len(skin_points(skin).areas))
    forces[:count] = 1.0
    assert not felt(discs(skin, 1.0), forces, skin)[skin.first[1] :].any()
    field = discs(SKIN, 0.2)  # reaches the other side of every link
    facing = np.einsum("qwi,qi->qw", _taxel_normals()[field.taxels], POINTS.normals) > 0
    assert facing[field.weights > 0].all()


def _taxel_normals():
    return np.concatenate([patch.taxels.normals for patch in SKIN.patches])


def test_a_table_holds_its_entries():
    points, taxels, weights = np.array([2, 0, 2, 2]), np.array([5, 1, 3, 4]), np.array([1.0, 2.0, 3.0, 4.0])
    field = as_table(4, points, taxels, weights)
    assert field.taxels.shape == (4, 3)
    pressures = np.zeros(6)
    field.add(pressures, np.array([2, 0, 1]), np.array([1.0, 10.0, 100.0]))
    assert pressures.tolist() == [0, 20.0, 0, 3.0, 4.0, 1.0]
    empty = as_table(2, np.zeros(0, int), np.zeros(0, int), np.zeros(0))
    assert empty.weights.tolist() == [[0.0], [0.0]]


def test_a_skin_without_taxels_has_fields_without_points():
    assert discs(Skin(()), 0.01).taxels.size == 0
    assert whole_cells(Skin(())).taxels.size == 0


@pytest.mark.parametrize("radius", [0.0, -1.0, float("nan"), float("inf")])
def test_a_disc_that_is_none_is_refused(radius):
    with pytest.raises(SimulationError, match="electrode"):
        discs(SKIN, radius)
