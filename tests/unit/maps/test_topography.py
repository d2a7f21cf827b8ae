"""Neighbourhood measures: perfect maps score perfectly, spoiled ones as a slow, plain count says."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.stats import spearmanr

from app.maps.body_distances import BodyDistances
from app.maps.build import build_map
from app.maps.topography import edge_lengths, neighbourhoods, topography
from tests.numerics.map_surfaces import frustum, sheet, skin_of


@pytest.fixture(scope="module")
def flat():
    return build_map(skin_of(sheet(24, 16), taxels=40))


@pytest.fixture(scope="module")
def body(flat):
    return BodyDistances(flat.skin)


@pytest.fixture(scope="module")
def cloud():
    """120 taxels in space, in 10 modules, and a map of them that is not good."""
    generator = np.random.default_rng(5)
    positions = generator.normal(size=(120, 3)) * [1, 1, 0.2]
    points = positions[:, :2] + generator.normal(scale=0.15, size=(120, 2))
    return points, BodyDistances.straight(positions, pair=0.5), np.arange(120) // 12


def _slowly(points, distances, k, module):
    """Trustworthiness and continuity, counted taxel by taxel from their definition."""
    flat = np.linalg.norm(points[:, None] - points[None], axis=2)
    scores = []
    for here, there in ((flat, distances), (distances, flat)):
        lost = worst = 0
        for i in range(len(points)):
            others = [j for j in range(len(points)) if (j != i if module is None else module[j] != module[i])]
            place = {j: 1 + rank for rank, j in enumerate(sorted(others, key=lambda j: there[i, j]))}
            nearest = sorted(others, key=lambda j: here[i, j])[:k]
            lost += sum(max(place[j] - k, 0) for j in nearest)
            worst += sum(len(others) - rank - k for rank in range(k))
        scores.append(1 - lost / worst)
    return scores


@pytest.mark.parametrize("k", [3, 6, 10])
@pytest.mark.parametrize("between", [False, True])
def test_neighbourhoods_are_those_counted_slowly(cloud, k, between):
    points, distances, modules = cloud
    module = modules if between else None
    (patch,) = distances.patches
    expected = _slowly(points, patch.near, k, module)
    assert max(expected) < 0.99
    assert neighbourhoods(points, patch, module=module, k=k) == pytest.approx(expected, abs=1e-12)


def test_equal_distances_are_not_ordered_by_rounding():
    grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(9.0)), axis=-1).reshape(-1, 2)
    (patch,) = BodyDistances.straight(np.column_stack([grid, np.zeros(len(grid))]), pair=1.1).patches
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    assert neighbourhoods(grid @ turn.T / 3 + 0.1, patch) == (1.0, 1.0)


def test_rank_correlation_and_stress_are_those_of_the_definition(cloud):
    points, distances, _ = cloud
    off = ~np.eye(120, dtype=bool)
    on_map = np.linalg.norm(points[:, None] - points[None], axis=2)[off]
    true = distances.patches[0].exact[off]
    shape = topography(points, distances)
    assert shape.spearman == pytest.approx(spearmanr(on_map, true).statistic, abs=1e-12)
    least = minimize_scalar(lambda scale: (((scale * on_map - true) ** 2).sum() / (true**2).sum()) ** 0.5).fun
    assert shape.stress == pytest.approx(least, rel=1e-9)


def test_pairs_between_modules_are_told_apart(cloud):
    points, distances, modules = cloud
    across = modules[distances.pairs[:, 0]] != modules[distances.pairs[:, 1]]
    torn = np.array(
        [
            np.linalg.norm(points[i] - points[j]) > 2 * length
            for (i, j), length in zip(distances.pairs, distances.lengths, strict=True)
        ]
    )
    shape = topography(points, distances, modules=modules)
    assert (shape.pairs, shape.torn_pairs) == (len(across), torn.sum())
    assert shape.torn == pytest.approx(torn.mean())
    assert (shape.pairs_between_modules, shape.torn_between_modules) == (across.sum(), torn[across].sum())
    assert 0 < shape.torn_between_modules < shape.torn_pairs or torn[~across].sum() == 0
    alone = topography(points, distances)
    assert alone.torn_between_modules is None
    assert np.isnan(alone.continuity_between_modules)


def test_a_turned_module_shows_between_modules():
    columns, rows = np.meshgrid(np.arange(24.0), np.arange(8.0))
    grid = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    module = (grid[:, 0] // 4 + 6 * (grid[:, 1] // 4)).astype(int)
    body = BodyDistances.straight(np.column_stack([grid, np.zeros(len(grid))]), pair=1.1)
    turned = grid.copy()
    turned[module == 4] = 2 * grid[module == 4].mean(axis=0) - grid[module == 4]
    shape = topography(turned, body, modules=module)
    assert shape.torn_pairs == shape.torn_between_modules > 0
    assert shape.trustworthiness_between_modules < shape.trustworthiness < 1


def test_a_flat_patch_keeps_everything(flat, body):
    shape = topography(flat.taxel_points, body)
    assert shape.stress < 2e-5
    assert shape.edge_error < 5e-5, "taxels beside a corner of the mesh are measured from the corner"
    assert (shape.torn, shape.torn_pairs, shape.pairs) == (0, 0, len(flat.skin.neighbours))
    assert min(shape.spearman, shape.trustworthiness, shape.continuity) > 1 - 1e-3


def test_scale_does_not_matter(flat, body):
    assert topography(7 * flat.taxel_points, body).stress < 1e-4


def test_a_stretched_map_is_worse(flat, body):
    shape = topography(flat.taxel_points * [1.5, 1], body)
    assert 0.05 < shape.edge_error < 0.25
    assert shape.stress > 0.05


def test_a_folded_map_has_false_neighbours(flat, body):
    points = flat.taxel_points
    assert topography(np.abs(points - points.mean(axis=0)), body).trustworthiness < 0.97


def test_a_seam_loses_neighbours_but_makes_no_false_ones():
    map_ = build_map(skin_of(frustum(around=40, along=24), taxels=80))
    shape = topography(map_.taxel_points, BodyDistances(map_.skin))
    assert shape.torn > 0.02
    assert shape.continuity < shape.trustworthiness - 0.005
    assert shape.edge_error < 0.004, "a tube is laid flat without any stretch; straight lines would give 0.008"


def test_patches_count_by_their_taxels(flat):
    skin = skin_of(sheet(24, 16), sheet(24, 16), taxels=30)
    body = BodyDistances(skin)
    good = np.concatenate([patch.taxels.positions[:, :2] for patch in skin.patches])
    bad = good.copy()
    bad[30:] = np.random.default_rng(0).permutation(bad[30:])
    half = topography(bad, body).trustworthiness
    (worse,) = {round(neighbourhoods(bad[30:], body.patches[1])[0], 12)}
    assert half == pytest.approx(0.5 * (worse + neighbourhoods(good[:30], body.patches[0])[0]))


def test_patches_too_small_to_rank_are_unknown_not_perfect():
    map_ = build_map(skin_of(sheet(), taxels=6))
    assert np.isnan(topography(map_.taxel_points, BodyDistances(map_.skin)).trustworthiness)


def test_a_single_taxel_has_no_lengths():
    map_ = build_map(skin_of(sheet(), taxels=1))
    body = BodyDistances(map_.skin)
    error, torn = edge_lengths(map_.taxel_points, body)
    assert (error, len(torn)) == (0.0, 0)
    shape = topography(map_.taxel_points, body)
    assert (shape.stress, shape.torn) == (0.0, 0.0)
    assert np.isnan(shape.spearman)


def test_a_map_of_one_point_is_unknown(flat, body):
    shape = topography(np.zeros_like(flat.taxel_points), body)
    assert np.isnan([shape.stress, shape.spearman, shape.edge_error]).all()
