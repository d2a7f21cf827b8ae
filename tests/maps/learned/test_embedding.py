"""Embedding of distances: classical scaling, SMACOF, the neighbour graph, and all in a row."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.distance import cdist, pdist, squareform

from tactile_maps.geometry.geodesics import all_path_lengths
from tactile_maps.maps.learned.embedding import (
    classical_mds,
    connected_islands,
    embed,
    knn_graph,
    kruskal_stress,
    smacof,
)


def _drawn(count=30, dimensions=3):
    return np.random.default_rng(4).exponential(size=(count, dimensions)) * [3.0, 2.0, 1.0][:dimensions]


def test_embedding_reproduces_distances_of_points():
    distances = cdist(*2 * [_drawn()])
    points = classical_mds(distances, dimensions=3)
    assert np.allclose(cdist(points, points), distances)
    assert np.allclose(points.mean(axis=0), 0)


def test_axes_are_principal_and_in_order():
    points = classical_mds(cdist(*2 * [_drawn()]), dimensions=3)
    assert np.allclose(points.T @ points, np.diag((points**2).sum(axis=0)))
    assert (np.diff((points**2).sum(axis=0)) < 0).all()
    assert ((points**3).sum(axis=0) > 0).all()
    mirrored = classical_mds(cdist(*2 * [-_drawn()]), dimensions=3)
    assert np.allclose(mirrored, points)


def test_embedding_does_not_depend_on_numbering():
    distances = cdist(*2 * [_drawn()])
    order = np.random.default_rng(5).permutation(30)
    assert np.allclose(classical_mds(distances[np.ix_(order, order)]), classical_mds(distances)[order])


def test_axes_without_extent_are_zero():
    points = classical_mds(cdist(*2 * [_drawn(2, 1)]), dimensions=3)
    assert points.shape == (2, 3)
    assert np.allclose(points[:, 1:], 0, atol=1e-7)


@pytest.fixture(scope="module")
def drawn():
    generator = np.random.default_rng(6)
    return generator.normal(size=(25, 3)), generator.normal(size=(25, 2))


def test_loss_never_increases(drawn):
    ball, start = drawn
    distances = pdist(ball)
    fits = [smacof(squareform(distances), start, rounds=rounds) for rounds in range(12)]
    losses = np.array([((pdist(points) / distances - 1) ** 2).sum() for points in fits])
    assert (np.diff(losses) <= 0).all()
    assert losses[-1] < 0.5 * losses[0]


def test_points_of_the_plane_are_recovered(drawn):
    _, plane = drawn
    distances = squareform(pdist(plane))
    near = plane + 0.1 * np.random.default_rng(7).normal(size=plane.shape)
    fitted = smacof(distances, near, rounds=5000, tolerance=1e-12)
    assert cdist(fitted, fitted) == pytest.approx(distances, abs=1e-4)
    assert kruskal_stress(fitted, distances) < 1e-5


def test_general_optimiser_finds_no_better_embedding(drawn):
    ball, start = drawn
    distances = pdist(ball)

    def loss(flat):
        return ((pdist(flat.reshape(-1, 2)) / distances - 1) ** 2).sum()

    ours = smacof(squareform(distances), start, rounds=5000, tolerance=1e-12)
    better = minimize(loss, ours.ravel(), method="BFGS")
    assert loss(ours.ravel()) <= better.fun * (1 + 1e-5)


def test_coincident_start_points_give_finite_results(drawn):
    start = drawn[1].copy()
    start[1] = start[0]
    assert np.isfinite(smacof(squareform(pdist(drawn[0])), start)).all()


def test_stress_does_not_depend_on_scale(drawn):
    ball, plane = drawn
    distances = squareform(pdist(ball))
    stress = kruskal_stress(plane, distances)
    assert 0.1 < stress < 1
    assert kruskal_stress(7 * plane, distances) == pytest.approx(stress)
    assert kruskal_stress(0 * plane, distances) is None
    scales = np.linspace(0.1, 3, 3000)[:, None, None]
    tried = np.sqrt(((scales * squareform(pdist(plane)) - distances) ** 2).sum(axis=(1, 2)) / (distances**2).sum())
    assert stress == pytest.approx(tried.min(), rel=1e-5)


def test_progress_may_cancel(drawn):
    def cancel(_text, _fraction):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        smacof(squareform(pdist(drawn[0])), drawn[1], progress=cancel)


def test_neighbour_graph_contains_nearest_neighbours_in_both_directions():
    apart = cdist(*2 * [np.array([[0.0], [1], [2.1], [5]])])
    joined = knn_graph(apart, neighbours=1).toarray() > 0
    assert joined.tolist() == [[0, 1, 0, 0], [1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0]]


def test_all_tied_neighbours_are_included():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    assert knn_graph(cdist(square, square), neighbours=1).nnz == 8


def test_path_lengths_are_sums_of_edge_lengths():
    line = np.arange(6.0)[:, None]
    assert np.allclose(all_path_lengths(knn_graph(cdist(line, line), neighbours=2)), cdist(line, line))


def test_unknown_pairs_are_not_connected():
    apart = cdist(*2 * [np.arange(6.0)[:, None]])
    apart[:2, 2:] = apart[2:, :2] = np.inf
    graph = knn_graph(apart, neighbours=5)
    assert [part.tolist() for part in connected_islands(graph)] == [[2, 3, 4, 5], [0, 1]]
    assert np.isinf(all_path_lengths(graph)[0, 5])


def test_edges_between_coincident_points_have_positive_length():
    same = knn_graph(np.zeros((3, 3)), neighbours=2)
    assert same.nnz == 6
    assert (same.data > 0).all()


def test_single_node_is_a_component():
    graph = knn_graph(np.zeros((1, 1)))
    assert [part.tolist() for part in connected_islands(graph)] == [[0]]


def _lattice(columns=9, rows=7):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    return np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=-1).reshape(-1, 2)


def test_short_distances_alone_determine_the_embedding():
    lattice = _lattice()
    unlike = cdist(lattice, lattice)
    unlike[unlike > 2.5] = np.inf
    assert np.isinf(unlike).mean() > 0.5
    placed = embed(unlike, neighbours=12)
    assert placed.findings == ()
    assert placed.stress < 0.05
    assert np.corrcoef(pdist(placed.points), pdist(lattice))[0, 1] > 0.995


def test_separate_components_are_placed_side_by_side_and_reported():
    lattice = _lattice()
    both = np.concatenate([lattice, lattice[:20]])
    unlike = np.full((len(both),) * 2, np.inf)
    for own in (slice(0, 63), slice(63, None)):
        unlike[own, own] = cdist(both[own], both[own])
    placed = embed(unlike)
    (note,) = placed.findings
    assert (note.kind, note.where, note.count) == ("islands", "parts of 63, 20 taxels", 2)
    gap = placed.points[63:, 0].min() - placed.points[:63, 0].max()
    assert 1 < gap < 10, "side by side, with a gap of more than a spacing"


def test_few_and_isolated_taxels_get_positions():
    unlike = np.full((4, 4), np.inf)
    unlike[:2, :2] = 1 - np.eye(2)
    placed = embed(unlike)
    assert np.isfinite(placed.points).all()
    assert placed.findings[0].count == 3
    assert placed.stress == 0
