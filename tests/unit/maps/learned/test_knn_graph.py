"""The neighbour graph: symmetric, with ties, and cut where nothing is known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from app.maps.learned.knn_graph import islands, knn_graph, path_lengths


def test_each_has_its_nearest_and_those_that_chose_it():
    apart = cdist(*2 * [np.array([[0.0], [1], [2.1], [5]])])
    joined = knn_graph(apart, neighbours=1).toarray() > 0
    assert joined.tolist() == [[0, 1, 0, 0], [1, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0]]


def test_ties_are_all_taken_whatever_the_numbering():
    square = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    assert knn_graph(cdist(square, square), neighbours=1).nnz == 8


def test_paths_are_sums_of_sides():
    line = np.arange(6.0)[:, None]
    assert np.allclose(path_lengths(knn_graph(cdist(line, line), neighbours=2)), cdist(line, line))


def test_unknown_pairs_are_never_joined():
    apart = cdist(*2 * [np.arange(6.0)[:, None]])
    apart[:2, 2:] = apart[2:, :2] = np.inf
    graph = knn_graph(apart, neighbours=5)
    assert [part.tolist() for part in islands(graph)] == [[2, 3, 4, 5], [0, 1]]
    assert np.isinf(path_lengths(graph)[0, 5])


def test_no_way_is_free():
    same = knn_graph(np.zeros((3, 3)), neighbours=2)
    assert same.nnz == 6
    assert (same.data > 0).all()


def test_a_single_node_is_an_island():
    graph = knn_graph(np.zeros((1, 1)))
    assert [part.tolist() for part in islands(graph)] == [[0]]
