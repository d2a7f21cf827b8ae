"""The quadrature points of a skin, and what its taxels feel of forces on them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SimulationError
from tactile_maps.skin.model.skin import BarePoints, Skin
from tactile_maps.tactile.mechanics.receptive_field import (
    cell_field,
    disc_field,
    field_from_entries,
    load_points,
    pad_displacements,
    points_of_link,
    quadrature_points,
    sparse_pads_findings,
)
from tests.support.touch import arm, bar_skin, pair


def test_fields_are_ordered_by_patch_and_use_taxel_numbers():
    _, skin = pair()
    points = quadrature_points(skin)
    second = skin.patches[1].taxels.quadrature
    assert len(skin.patches) == 2
    np.testing.assert_array_equal(points.positions[-len(second.areas) :], second.positions)
    np.testing.assert_array_equal(points.taxel[-len(second.areas) :], second.taxel + skin.first[1])
    np.testing.assert_allclose(np.bincount(points.taxel, points.areas), skin.areas, rtol=1e-12)
    assert np.linalg.norm(points.normals, axis=1).min() > 0.99


def test_bare_points_follow_the_points_read_by_taxels():
    _, skin = pair()
    bare = BarePoints("left", np.ones((3, 3)), np.tile([0.0, 0.0, 1.0], (3, 1)), np.array([1.0, 2.0, 3.0]))
    read = quadrature_points(skin)
    loaded = load_points(replace(skin, bare_points=(bare,)))
    assert load_points(skin) is read
    np.testing.assert_array_equal(loaded.areas, [*read.areas, 1, 2, 3])
    np.testing.assert_array_equal(loaded.taxel[-3:], -1)
    count = len(read.areas)
    points = points_of_link(replace(skin, bare_points=(bare,)), "left")
    assert set(points[-3:]) == {count, count + 1, count + 2}
    assert len(points) == 3 + len(skin.patches[0].taxels.quadrature.areas)
    assert points_of_link(replace(skin, bare_points=(bare,)), "right").max() < count


SKIN = arm().skin
POINTS = quadrature_points(SKIN)


def felt(field, forces, skin=SKIN):
    pressures = np.zeros(len(skin))
    field.add(pressures, np.arange(len(forces)), forces)
    return pressures


def test_whole_cells_keep_the_force_and_read_a_uniform_pressure():
    forces = np.random.default_rng(0).uniform(0, 1, len(POINTS.areas))
    assert felt(cell_field(SKIN), forces) @ SKIN.areas == pytest.approx(forces.sum(), rel=1e-13)
    assert felt(cell_field(SKIN), 5e3 * POINTS.areas) == pytest.approx(np.full(len(SKIN), 5e3), rel=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("radius", [1e-4, 0.002, 0.008, 0.03, 1.0])
def test_discs_of_any_size_read_a_uniform_pressure(radius):
    assert felt(disc_field(SKIN, radius), 5e3 * POINTS.areas) == pytest.approx(np.full(len(SKIN), 5e3), rel=1e-12)


@pytest.mark.parametrize("radius", [0.004, 0.01])
def test_disc_is_the_mean_over_the_points_within_it(radius):
    forces = np.random.default_rng(1).uniform(0, 1, len(POINTS.areas))
    pressures = felt(disc_field(SKIN, radius), forces)
    start = 0
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


@pytest.mark.long
def test_disc_stays_on_its_patch_and_its_side():
    _, skin = pair()
    count = len(skin.patches[0].taxels.quadrature.areas)
    forces = np.zeros(len(quadrature_points(skin).areas))
    forces[:count] = 1.0
    assert not felt(disc_field(skin, 1.0), forces, skin)[skin.first[1] :].any()
    field = disc_field(SKIN, 0.2)  # reaches the other side of every link
    facing = np.einsum("qwi,qi->qw", _taxel_normals()[field.taxels], POINTS.normals) > 0
    assert facing[field.weights > 0].all()


def _taxel_normals():
    return np.concatenate([patch.taxels.normals for patch in SKIN.patches])


def test_table_contains_its_entries():
    points = np.array([2, 0, 2, 2])
    taxels = np.array([5, 1, 3, 4])
    weights = np.array([1.0, 2.0, 3.0, 4.0])
    field = field_from_entries(4, points, taxels, weights)
    assert field.taxels.shape == (4, 3)
    pressures = np.zeros(6)
    field.add(pressures, np.array([2, 0, 1]), np.array([1.0, 10.0, 100.0]))
    assert pressures.tolist() == [0, 20.0, 0, 3.0, 4.0, 1.0]
    empty = field_from_entries(2, np.zeros(0, int), np.zeros(0, int), np.zeros(0))
    assert empty.weights.tolist() == [[0.0], [0.0]]


def test_skin_without_taxels_has_fields_without_points():
    assert disc_field(Skin(()), 0.01).taxels.size == 0
    assert cell_field(Skin(())).taxels.size == 0


@pytest.mark.parametrize("radius", [0.0, -1.0, float("nan"), float("inf")])
def test_invalid_pad_radius_is_rejected(radius):
    with pytest.raises(SimulationError, match="pad radius"):
        disc_field(SKIN, radius)


def test_pad_with_one_point_uses_the_point_nearest_to_its_taxel():
    skin = bar_skin(100)
    taxels = skin.patches[0].taxels
    points = quadrature_points(skin)
    nearest = np.linalg.norm(taxels.positions[:, None] - points.positions, axis=2).min(axis=1)
    np.testing.assert_allclose(pad_displacements(skin, 1e-4), nearest**2, rtol=1e-9, atol=1e-18)


def test_pads_that_cover_little_of_a_link_are_reported():
    _, skin = pair()
    area = float(skin.areas.mean())
    radius = (0.1 * area / np.pi) ** 0.5
    (finding,) = sparse_pads_findings(skin, radius)
    assert (finding.kind, finding.where, finding.count) == ("sparse-pads", "left, right", 2)
    assert "cover 10 % of the skin" in finding.action
    assert f"taxels are {1e3 * area**0.5:.2g} mm apart" in finding.action
    assert "up to 10 times" in finding.action
    assert not sparse_pads_findings(skin, 1.5 * radius)
