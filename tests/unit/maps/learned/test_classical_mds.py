"""Classical scaling is exact where an exact answer exists."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist

from app.maps.learned.classical_mds import classical_mds


def _drawn(count=30, dimensions=3):
    return np.random.default_rng(4).exponential(size=(count, dimensions)) * [3.0, 2.0, 1.0][:dimensions]


def test_distances_of_points_come_back():
    wanted = cdist(*2 * [_drawn()])
    points = classical_mds(wanted, dimensions=3)
    assert np.allclose(cdist(points, points), wanted)
    assert np.allclose(points.mean(axis=0), 0)


def test_axes_are_principal_and_in_order():
    points = classical_mds(cdist(*2 * [_drawn()]), dimensions=3)
    assert np.allclose(points.T @ points, np.diag((points**2).sum(axis=0)))
    assert (np.diff((points**2).sum(axis=0)) < 0).all()
    assert ((points**3).sum(axis=0) > 0).all()
    mirrored = classical_mds(cdist(*2 * [-_drawn()]), dimensions=3)
    assert np.allclose(mirrored, points)


def test_numbering_does_not_matter():
    wanted, order = cdist(*2 * [_drawn()]), np.random.default_rng(5).permutation(30)
    assert np.allclose(classical_mds(wanted[np.ix_(order, order)]), classical_mds(wanted)[order])


def test_axes_without_extent_are_zero():
    points = classical_mds(cdist(*2 * [_drawn(2, 1)]), dimensions=3)
    assert points.shape == (2, 3)
    assert np.allclose(points[:, 1:], 0, atol=1e-7)
