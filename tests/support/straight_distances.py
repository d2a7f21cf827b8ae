"""Distances of taxels in a straight line, instead of over the body."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.maps.evaluation.topography import _MOST, BodyDistances, PatchDistances, _some


def straight_distances(
    positions: FloatArray, *, first: Sequence[int] | None = None, pair: float = 0.008
) -> BodyDistances:
    """Return straight distances from taxel positions alone, which are too short around a body.

    Args:
        positions: (n, 3) [m].
        first: Index of each patch's first taxel, and n; by default all are one patch.
        pair: Distance below which taxels of a patch are neighbours [m].
    """
    made = BodyDistances.__new__(BodyDistances)
    starts = np.array([0, len(positions)] if first is None else first, dtype=np.int64)
    parts = [positions[a:b] for a, b in pairwise(starts)]
    pairs = [_closer_than(part, pair) + a for part, a in zip(parts, starts[:-1], strict=True)]
    made.patches = tuple(_through_space(part) for part in parts)
    made.first = readonly(starts, np.int64)
    made.pairs = readonly(np.concatenate(pairs), np.int64)
    ends = positions[made.pairs]
    made.lengths = readonly(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1))
    made.findings = ()
    return made


def _through_space(positions: FloatArray) -> PatchDistances:
    count = len(positions)
    rows = _some(count, max(_MOST // max(count, 1), 1), np.random.default_rng(0))
    distances = cdist(positions[rows], positions)
    return PatchDistances(rows, distances, rows, distances)


def _closer_than(positions: FloatArray, reach: float) -> IntArray:
    found = cKDTree(positions).query_pairs(reach, output_type="ndarray") if len(positions) else np.zeros((0, 2))
    return np.unique(found.astype(np.int64).reshape(-1, 2), axis=0)
