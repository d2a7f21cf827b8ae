"""Distances over the body, and what a map keeps of them."""

from __future__ import annotations

import numpy as np
import pytest
import scipy  # loads its parts when they are used: signal and stats take half a second
from scipy.optimize import minimize_scalar

from tactile_maps.geometry.geodesics import Geodesics
from tactile_maps.geometry.remesh.refine import insert_vertices
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation import topography
from tactile_maps.maps.evaluation.topography import (
    BodyDistances,
    PatchDistances,
    edge_lengths,
    measure_topography,
    neighbourhoods,
)
from tests.support.straight_distances import straight_distances
from tests.support.surfaces import frustum, named, sheet, skin_of


def test_distances_on_a_sheet_are_straight():
    skin = skin_of(sheet(24, 16), taxels=30)
    (patch,) = BodyDistances(skin).patches
    positions = skin.patches[0].taxels.positions
    expected = np.linalg.norm(positions[:, None] - positions[None], axis=2)
    np.testing.assert_allclose(patch.from_sources, expected, atol=2e-5)
    np.testing.assert_allclose(patch.near, expected, atol=2e-5)
    assert patch.sources.tolist() == patch.rows.tolist() == list(range(30))


@pytest.fixture
def no_budget(monkeypatch):
    """Sample the distances, as for a large skin."""
    monkeypatch.setattr(topography, "_ALL_EXACT", 0)


@pytest.mark.long
@pytest.mark.usefixtures("no_budget")
def test_distances_on_a_large_skin_are_exact_near_and_approximate_far():
    skin = skin_of(named("hemisphere"), taxels=50)
    (patch,) = BodyDistances(skin, sources=7).patches
    assert (len(patch.sources), patch.from_sources.shape, patch.near.shape) == (7, (7, 50), (50, 50))
    exact = _exact(skin)
    close = exact <= 1.19 * np.median(np.sort(exact, axis=1)[:, 1])
    i, j = skin.neighbours.T
    close[i, j] = close[j, i] = True
    assert close.sum() > 5 * 50
    np.testing.assert_allclose(patch.near[close], exact[close], atol=1e-12)
    far = exact > 0
    assert np.abs(patch.near[far] / exact[far] - 1).mean() < 0.03


@pytest.mark.long
@pytest.mark.usefixtures("no_budget")
def test_measures_from_sampled_rows_agree_with_all_exact_distances(monkeypatch):
    """Errors of the sampled measures: stress, rank correlation, trustworthiness and continuity."""
    monkeypatch.setattr(topography, "_ROWS", 40)
    skin = skin_of(named("bumpy tube"), taxels=120)
    points = build_map(skin).taxel_points
    quick = BodyDistances(skin)
    exact = _exact(skin)
    (patch,) = quick.patches
    assert patch.sources.tolist() == patch.rows.tolist()
    assert len(set(patch.rows.tolist())) == 40
    every = np.arange(120)
    known = straight_distances(skin.patches[0].taxels.positions)
    known.patches = (PatchDistances(every, exact, every, exact),)
    found = measure_topography(points, quick)
    true = measure_topography(points, known)
    assert true.stress > 0.02, "the map distorts"
    assert found.stress == pytest.approx(true.stress, rel=0.1, abs=0.01)
    assert found.spearman == pytest.approx(true.spearman, abs=0.01)
    assert found.trustworthiness == pytest.approx(true.trustworthiness, abs=0.003)
    assert found.continuity == pytest.approx(true.continuity, abs=0.02)


@pytest.mark.usefixtures("no_budget")
def test_sampled_rows_are_far_from_each_other():
    skin = skin_of(sheet(), taxels=60)
    positions = skin.patches[0].taxels.positions
    rows = topography._spread(positions, 12, np.random.default_rng(0))
    apart = np.linalg.norm(positions[rows, None] - positions[rows], axis=2)[~np.eye(12, dtype=bool)].min()
    away = np.linalg.norm(positions[:, None] - positions[rows], axis=2).min(axis=1).max()
    assert away <= apart


@pytest.mark.long
@pytest.mark.usefixtures("no_budget")
def test_every_patch_gets_its_share_of_sources_and_two_at_least():
    skin = skin_of(sheet(), named("saddle"), taxels=40)
    assert [len(patch.sources) for patch in BodyDistances(skin, sources=10).patches] == [5, 5]
    assert [len(patch.sources) for patch in BodyDistances(skin, sources=1).patches] == [2, 2]


@pytest.mark.usefixtures("no_budget")
def test_same_seed_selects_the_same_taxels():
    skin = skin_of(named("saddle"), taxels=40)
    one, same, other = (BodyDistances(skin, sources=4, seed=seed).patches[0] for seed in (3, 3, 4))
    np.testing.assert_array_equal(one.from_sources, same.from_sources)
    assert one.sources.tolist() != other.sources.tolist()


def test_distances_of_many_taxels_use_some_rows(monkeypatch):
    monkeypatch.setattr(topography, "_ALL_EXACT", 0)
    monkeypatch.setattr(topography, "_MOST", 400)
    (patch,) = BodyDistances(skin_of(sheet(), taxels=40)).patches
    assert patch.near.shape == (10, 40)
    assert np.take_along_axis(patch.near, patch.rows[:, None], axis=1).max() == 0


def _exact(skin):
    taxels = skin.patches[0].taxels
    mesh, vertices = insert_vertices(skin.patches[0].surface, taxels.faces, taxels.weights)
    return np.array([Geodesics(mesh).from_vertex(int(v), vertices) for v in vertices])


@pytest.mark.long
@pytest.mark.usefixtures("no_budget")
@pytest.mark.parametrize("name", ["tube", "saddle"])
def test_distances_of_neighbours_are_exact_at_any_distance(name, monkeypatch):
    monkeypatch.setattr(topography, "_REACH", 0.5)
    tube = frustum(0.03, 0.03, length=0.06, around=30, along=12)
    skin = skin_of(tube if name == "tube" else named("saddle"), taxels=40)
    body = BodyDistances(skin)
    np.testing.assert_array_equal(body.pairs, skin.neighbours)
    np.testing.assert_allclose(body.lengths, _exact(skin)[tuple(body.pairs.T)], atol=1e-12)


def test_approximate_distance_of_neighbours_is_an_arc():
    skin = skin_of(named("thin faces"), taxels=40)
    body = BodyDistances(skin)
    i, j = body.pairs.T
    positions = skin.patches[0].taxels.positions
    straight = np.linalg.norm(positions[i] - positions[j], axis=1)
    assert (body.lengths >= straight * (1 - 1e-12)).all()
    assert (body.lengths < 1.05 * straight).all()
    assert body.lengths.sum() < body.patches[0].from_sources[i, j].sum()


def test_inexact_distances_have_a_finding():
    (note,) = BodyDistances(skin_of(named("thin faces"))).findings
    assert note.kind == "inexact-distance"


def test_isolated_taxel_has_no_neighbours():
    body = BodyDistances(skin_of(sheet(), taxels=1))
    assert body.pairs.shape == (0, 2)
    assert body.patches[0].from_sources.tolist() == [[0.0]]


def test_isolated_taxels_are_measured_through_space():
    positions = np.random.default_rng(0).uniform(0, 0.03, (20, 3))
    body = straight_distances(positions, first=[0, 12, 20], pair=0.01)
    assert [patch.near.shape for patch in body.patches] == [(12, 12), (8, 8)]
    assert body.patches[1].from_sources[2, 5] == pytest.approx(np.linalg.norm(positions[14] - positions[17]))
    expected = {
        (i, j)
        for j in range(20)
        for i in range(j)
        if (i < 12) == (j < 12) and np.linalg.norm(positions[i] - positions[j]) < 0.01
    }
    assert {tuple(pair) for pair in body.pairs.tolist()} == expected
    assert len(expected) > 3
    np.testing.assert_allclose(body.lengths, np.linalg.norm(np.diff(positions[body.pairs], axis=1)[:, 0], axis=1))


def test_no_taxels_have_no_distances():
    body = straight_distances(np.zeros((0, 3)))
    assert body.pairs.shape == (0, 2)


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
    return points, straight_distances(positions, pair=0.5), np.arange(120) // 12


def _slowly(points, distances, k):
    """Trustworthiness and continuity, counted taxel by taxel from their definition."""
    flat = np.linalg.norm(points[:, None] - points[None], axis=2)
    scores = []
    for here, there in ((flat, distances), (distances, flat)):
        lost = worst = 0
        for i in range(len(points)):
            others = [j for j in range(len(points)) if j != i]
            place = {j: 1 + rank for rank, j in enumerate(sorted(others, key=lambda j: there[i, j]))}
            nearest = sorted(others, key=lambda j: here[i, j])[:k]
            lost += sum(max(place[j] - k, 0) for j in nearest)
            worst += sum(len(others) - rank - k for rank in range(k))
        scores.append(1 - lost / worst)
    return scores


@pytest.mark.parametrize("k", [3, 6, 10])
def test_neighbourhoods_agree_with_brute_force(cloud, k):
    points, distances, _ = cloud
    (patch,) = distances.patches
    expected = _slowly(points, patch.near, k)
    assert max(expected) < 0.99
    assert neighbourhoods(points, patch, k=k) == pytest.approx(expected, abs=1e-12)


def test_equal_distances_are_not_ordered_by_rounding():
    grid = np.stack(np.meshgrid(np.arange(12.0), np.arange(9.0)), axis=-1).reshape(-1, 2)
    (patch,) = straight_distances(np.column_stack([grid, np.zeros(len(grid))]), pair=1.1).patches
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    assert neighbourhoods(grid @ turn.T / 3 + 0.1, patch) == (1.0, 1.0)


def test_rank_correlation_and_stress_follow_their_definitions(cloud):
    points, distances, _ = cloud
    off = ~np.eye(120, dtype=bool)
    on_map = np.linalg.norm(points[:, None] - points[None], axis=2)[off]
    true = distances.patches[0].from_sources[off]
    shape = measure_topography(points, distances)
    assert shape.spearman == pytest.approx(scipy.stats.spearmanr(on_map, true).statistic, abs=1e-12)
    least = minimize_scalar(lambda scale: (((scale * on_map - true) ** 2).sum() / (true**2).sum()) ** 0.5).fun
    assert shape.stress == pytest.approx(least, rel=1e-9)


def test_torn_pairs_are_counted(cloud):
    points, distances, _ = cloud
    torn = np.array(
        [
            np.linalg.norm(points[i] - points[j]) > 2 * length
            for (i, j), length in zip(distances.pairs, distances.lengths, strict=True)
        ]
    )
    shape = measure_topography(points, distances)
    assert (shape.pairs, shape.torn_pairs) == (len(torn), torn.sum())
    assert 0 < shape.torn_pairs < shape.pairs
    assert shape.torn == pytest.approx(torn.mean())


def test_rotated_module_tears_pairs_and_reduces_trustworthiness():
    columns, rows = np.meshgrid(np.arange(24.0), np.arange(8.0))
    grid = np.stack([columns, rows], axis=-1).reshape(-1, 2)
    module = (grid[:, 0] // 4 + 6 * (grid[:, 1] // 4)).astype(int)
    body = straight_distances(np.column_stack([grid, np.zeros(len(grid))]), pair=1.1)
    turned = grid.copy()
    turned[module == 4] = 2 * grid[module == 4].mean(axis=0) - grid[module == 4]
    shape = measure_topography(turned, body)
    assert shape.torn_pairs > 0
    assert shape.trustworthiness < 1


def test_flat_patch_preserves_all_distances(flat, body):
    shape = measure_topography(flat.taxel_points, body)
    assert shape.stress < 2e-5
    assert shape.edge_error < 5e-5, "taxels near a corner of the mesh are measured from the corner"
    assert (shape.torn, shape.torn_pairs, shape.pairs) == (0, 0, len(flat.skin.neighbours))
    assert min(shape.spearman, shape.trustworthiness, shape.continuity) > 1 - 1e-3


def test_measures_do_not_depend_on_scale(flat, body):
    assert measure_topography(7 * flat.taxel_points, body).stress < 1e-4


def test_stretched_map_is_worse(flat, body):
    shape = measure_topography(flat.taxel_points * [1.5, 1], body)
    assert 0.05 < shape.edge_error < 0.25
    assert shape.stress > 0.05


def test_folded_map_has_false_neighbours(flat, body):
    points = flat.taxel_points
    assert measure_topography(np.abs(points - points.mean(axis=0)), body).trustworthiness < 0.97


def test_seam_loses_neighbours_but_makes_no_false_ones():
    map_ = build_map(skin_of(frustum(around=40, along=24), taxels=80))
    shape = measure_topography(map_.taxel_points, BodyDistances(map_.skin))
    assert shape.torn > 0.02
    assert shape.continuity < shape.trustworthiness - 0.005
    assert shape.edge_error < 0.004, "a tube is flattened without any stretch; straight lines would give 0.008"


@pytest.mark.long
def test_patches_are_weighted_by_their_number_of_taxels(flat):
    skin = skin_of(sheet(24, 16), sheet(24, 16), taxels=30)
    body = BodyDistances(skin)
    good = np.concatenate([patch.taxels.positions[:, :2] for patch in skin.patches])
    bad = good.copy()
    bad[30:] = np.random.default_rng(0).permutation(bad[30:])
    half = measure_topography(bad, body).trustworthiness
    (worse,) = {round(neighbourhoods(bad[30:], body.patches[1])[0], 12)}
    assert half == pytest.approx(0.5 * (worse + neighbourhoods(good[:30], body.patches[0])[0]))


def test_measures_of_patches_too_small_to_rank_are_unknown():
    map_ = build_map(skin_of(sheet(), taxels=6))
    assert measure_topography(map_.taxel_points, BodyDistances(map_.skin)).trustworthiness is None


@pytest.mark.sampled(1)
@pytest.mark.usefixtures("no_budget")
@pytest.mark.parametrize("rows", [0, 5, 40])
def test_distances_of_neighbours_across_a_sharp_bend_are_exact(monkeypatch, rows):
    monkeypatch.setattr(topography, "_ROWS", rows)
    skin = skin_of(sheet(36, 24, shape=lambda x, y: 3 * np.abs(x - 0.06)), taxels=45)
    body = BodyDistances(skin)
    exact = _exact(skin)
    i, j = skin.neighbours.T
    assert (exact[i, j] > 1.1 * topography._arcs(skin.patches[0].taxels)).any()
    np.testing.assert_allclose(body.lengths, exact[i, j], atol=1e-12)


def test_measures_of_a_single_taxel_are_unknown():
    map_ = build_map(skin_of(sheet(), taxels=1))
    body = BodyDistances(map_.skin)
    error, torn = edge_lengths(map_.taxel_points, body)
    assert (error, len(torn)) == (0.0, 0)
    shape = measure_topography(map_.taxel_points, body)
    assert (shape.stress, shape.torn) == (0.0, 0.0)
    assert shape.spearman is None


def test_measures_of_a_map_collapsed_to_a_point_are_unknown(flat, body):
    shape = measure_topography(np.zeros_like(flat.taxel_points), body)
    assert (shape.stress, shape.spearman, shape.edge_error) == (None, None, None)
