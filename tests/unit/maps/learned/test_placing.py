"""From unlikeness to places."""

from __future__ import annotations

import numpy as np
from scipy.spatial.distance import cdist, pdist

from app.maps.learned.placing import place


def _lattice(columns=9, rows=7):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    return np.stack([i + 0.5 * (j % 2), np.sqrt(0.75) * j], axis=-1).reshape(-1, 2)


def test_near_distances_alone_give_the_whole():
    lattice = _lattice()
    unlike = cdist(lattice, lattice)
    unlike[unlike > 2.5] = np.inf
    assert np.isinf(unlike).mean() > 0.5
    placed = place(unlike, neighbours=12)
    assert placed.findings == ()
    assert placed.stress < 0.05
    assert np.corrcoef(pdist(placed.points), pdist(lattice))[0, 1] > 0.995


def test_islands_are_laid_side_by_side_and_said():
    lattice = _lattice()
    both = np.concatenate([lattice, lattice[:20]])
    unlike = np.full((len(both),) * 2, np.inf)
    for own in (slice(0, 63), slice(63, None)):
        unlike[own, own] = cdist(both[own], both[own])
    placed = place(unlike)
    (note,) = placed.findings
    assert (note.kind, note.where, note.count) == ("islands", "parts of 63, 20 taxels", 2)
    gap = placed.points[63:, 0].min() - placed.points[:63, 0].max()
    assert 1 < gap < 10, "beside each other, apart by more than a spacing"


def test_few_taxels_and_lone_ones_have_places_too():
    unlike = np.full((4, 4), np.inf)
    unlike[:2, :2] = 1 - np.eye(2)
    placed = place(unlike)
    assert np.isfinite(placed.points).all()
    assert placed.findings[0].count == 3
    assert placed.stress == 0
