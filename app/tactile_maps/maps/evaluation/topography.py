"""Topography: how well a map preserves neighbourhoods and distances of the body.

``BodyDistances`` are the distances between the taxels on the body, the reference for all maps of a skin.
``measure_topography`` depends only on the map points of the taxels, so a hand-drawn map is evaluated like any other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding
from tactile_maps.geometry.geodesics import Geodesics
from tactile_maps.geometry.remesh.refine import insert_vertices
from tactile_maps.maps.model.tactile_map import SEAM_RATIO
from tactile_maps.skin.model.skin import Patch, Skin, Taxels

_ALL_EXACT = 60_000
"""Number of faces times taxels up to which all distances are exact; 0.2 s."""
_PAIRS_EXACT = 40_000_000
"""Number of faces times taxels up to which distances between neighbours are exact; 0.7 s for 1000 taxels."""
_ROWS = 250
"""Number of taxels of a patch from which distances to all others are computed. On real links of 1000 taxels, compared
with all rows, this many evenly distributed ones give stress within 2 % and continuity within 0.003; 12 random ones gave
an error of 14 %."""
_FACES_EXACT = 100_000
_FACES_QUICK = 20_000_000
"""Limits of rows times faces of a patch for exact distances over the whole patch, and for the heat method."""
_MOST = 10_000_000
"""Largest number of distances stored for one patch; beyond, fewer rows are used."""
_REACH = 1.2
_LONGER = 1.05
"""Distances are exact within ``_REACH`` pitches and within ``_LONGER`` times the arcs to a taxel's neighbours."""


@dataclass(frozen=True, eq=False)
class PatchDistances(ArrayFields):
    """Distances of one patch with n taxels, numbered within it.

    Attributes:
        sources: (s,) taxels from which distances to all others are compared with those on the map.
        from_sources: (s, n) [m] exact if requested or if the patch is small; else the ``near`` ones.
        rows: (r,) taxels whose neighbourhoods are compared: all of a small patch, else some, evenly distributed.
        near: (r, n) [m] exact for close taxels, within about 1 % (rms 1 to 2 %) for distant ones.
    """

    sources: IntArray
    from_sources: FloatArray
    rows: IntArray
    near: FloatArray


class BodyDistances:
    """Distances between the taxels of each patch over the uncut body. Built once for a skin, used for each map.

    Args:
        skin: The skin.
        sources: Number of taxels of the whole skin from which exact distances to all others are computed for stress and
            rank correlation, where all would take too long; at least two per patch. None: from ``rows``, by the heat
            method. On a real link with a stress of 0.14 and 0.30, five exact sources have random errors of 0.04 and
            0.05, the rows of 0.003. A stress below 0.01 cannot then be distinguished from zero.
        seed: Seed for the first row and the sources.

    Attributes:
        patches: Distances of each patch with taxels.
        first: (patches + 1,) index of each patch's first taxel.
        pairs: (e, 2) taxels that are neighbours on the body.
        lengths: (e,) [m] exact distance of each pair, or that of the arc between the two if not available.
        findings: Patches whose distances are not exact.

    Cost: 1 s for 1000 taxels on 18,000 faces; an exact source takes 0.3 s there. Fine meshes use fewer sources and
    rows, at least two per patch.
    """

    def __init__(self, skin: Skin, *, sources: int | None = None, seed: int = 0) -> None:
        generator = np.random.default_rng(seed)
        findings = []
        patches = []
        lengths = [np.zeros(0)]
        for patch in skin.patches:
            exact_sources = None if sources is None else max(2, round(sources * len(patch.taxels) / max(len(skin), 1)))
            surface = _PatchSurface(patch)
            made = surface.distances(exact_sources, generator)
            patches.append(made)
            lengths.append(surface.lengths(made))
            if not surface.exact:
                findings.append(Finding("inexact-distance", patch.name, "body distances taken along edges"))
        self.patches: tuple[PatchDistances, ...] = tuple(patches)
        self.first = skin.first
        self.pairs = skin.neighbours
        self.lengths = readonly(np.concatenate(lengths))
        self.findings = tuple(findings)


class _PatchSurface:
    """A patch with its taxels as vertices, for distances between them."""

    def __init__(self, patch: Patch) -> None:
        taxels = patch.taxels
        mesh, self._vertices = insert_vertices(patch.surface, taxels.faces, taxels.weights)
        self._geodesics = Geodesics(mesh)
        self._taxels = taxels
        self._faces = len(mesh.faces)
        self._arcs = _arcs(taxels)
        self._reach = np.zeros(len(taxels))
        np.maximum.at(self._reach, taxels.neighbours.T.ravel(), np.tile(_LONGER * self._arcs, 2))

    @property
    def exact(self) -> bool:
        """Whether exact distances are available."""
        return self._geodesics.exact

    def distances(self, sources: int | None, generator: np.random.Generator) -> PatchDistances:
        """Return distances, exact from ``sources`` taxels or None of them; all exact for a small patch."""
        count = len(self._taxels)
        positions = self._taxels.positions
        if count * self._faces <= _ALL_EXACT:
            every = np.arange(count)
            exact = self._afar(every)
            return PatchDistances(every, exact, every, exact)
        pitch = float(np.median(cKDTree(positions).query(positions, 2)[0][:, 1]))
        most = max(1, min(_ROWS, _MOST // count, _FACES_QUICK // self._faces))
        rows = _spread(positions, most, generator)
        every = np.arange(count)
        near = _rows([self._near(k, every, max(_REACH * pitch, self._reach[k])) for k in rows.tolist()], count)
        if sources is None:
            return PatchDistances(rows, near, rows, near)
        chosen = _some(count, max(2, min(sources, _FACES_EXACT // self._faces)), generator)
        return PatchDistances(chosen, self._afar(chosen), rows, near)

    def lengths(self, known: PatchDistances) -> FloatArray:
        """Return lengths (e,) between neighbours [m]: exact, or of arcs if that is impossible or would take too long.

        Args:
            known: Distances of the patch; the near ones are exact within each taxel's reach.
        """
        pairs = self._taxels.neighbours
        if not self.exact or len(self._taxels) * self._faces > _PAIRS_EXACT:
            return self._arcs
        row = np.full(len(self._taxels), -1)
        row[known.rows] = np.arange(len(known.rows))
        source = _covering_ends(pairs, row >= 0)
        target = pairs.sum(axis=1) - source
        order = np.argsort(source, kind="stable")
        result = known.near[row[source], target]
        open_ = (row[source] < 0) | (result >= self._reach[source])
        order = order[open_[order]]
        for mine in np.split(order, np.flatnonzero(np.diff(source[order])) + 1):
            if len(mine):
                start = int(source[mine[0]])
                result[mine] = self._near(start, target[mine], self._reach[start])
                far = mine[result[mine] >= self._reach[start]]  # the skin is bent more than its arc
                if len(far):
                    result[far] = self._near(start, target[far], 2 * self._reach[start])
        return result

    def _afar(self, taxels: IntArray) -> FloatArray:
        """Return exact distances (t, n)."""
        starts = self._vertices[taxels].tolist()
        return _rows([self._geodesics.from_vertex(k, self._vertices) for k in starts], len(self._vertices))

    def _near(self, taxel: int, others: IntArray, reach: float) -> FloatArray:
        """Return distances (t,) that are exact within ``reach`` and approximate but longer than it beyond."""
        source = int(self._vertices[taxel])
        targets = self._vertices[others]
        found = self._geodesics.from_vertex_within(source, targets, reach)
        if np.isinf(found).any():
            found = np.minimum(found, np.maximum(self._geodesics.approximate_from_vertex(source, targets), reach))
        return found


def _covering_ends(pairs: IntArray, taken: BoolArray) -> IntArray:
    """Return one end (e,) of each of ``pairs`` (e, 2): one of those ``taken`` (n,) if possible, else of few others.

    The others are the taxels outside a set without neighbours in it.
    """
    alone = ~taken
    for low, high in sorted(np.sort(pairs, axis=1).tolist()):
        alone[high] &= not alone[low]
    return np.where(taken[pairs[:, 1]] | alone[pairs[:, 0]], pairs[:, 1], pairs[:, 0])


def _arcs(taxels: Taxels) -> FloatArray:
    """Return the lengths (e,) of circular arcs between neighbours that turn by the angle of their normals [m].

    Exact on a sphere and around a tube, where the straight line is too short.
    """
    if not len(taxels.neighbours):
        return np.zeros(0)
    positions = taxels.positions[taxels.neighbours]
    normals = taxels.normals[taxels.neighbours]
    half = 0.5 * np.arccos(np.clip(normals.prod(axis=1).sum(axis=1), -1.0, 1.0))
    return np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1) / np.sinc(half / np.pi)


def _some(count: int, most: int, generator: np.random.Generator) -> IntArray:
    """Return ``most`` random indices in order, or all."""
    if most >= count:
        return np.arange(count)
    return np.sort(generator.choice(count, most, replace=False))


def _spread(positions: FloatArray, most: int, generator: np.random.Generator) -> IntArray:
    """Return indices of ``most`` positions in order, each farthest from those before (Gonzalez 1985), or all."""
    count = len(positions)
    if most >= count:
        return np.arange(count)
    chosen = [int(generator.integers(count))]
    distance = np.full(count, np.inf)
    while len(chosen) < most:
        distance = np.minimum(distance, np.linalg.norm(positions - positions[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return np.sort(np.array(chosen))


def _rows(rows: list[FloatArray], count: int) -> FloatArray:
    return np.stack(rows) if rows else np.zeros((0, count))


NEIGHBOURS = 6
_ALIKE = 1e-6
"""Relative difference below which distances are equal: on a regular skin only rounding would order them."""


@dataclass(frozen=True)
class Topography:
    """Topography measures of a map. None where unknown, with too few taxels.

    Attributes:
        edge_error: Rms relative error of lengths between neighbouring taxels at the best scale, without torn pairs.
        pairs: Number of neighbouring taxels on the body.
        torn_pairs: Number of pairs more than twice as far apart on the map.
        torn: Their share.
        stress: Kruskal's stress-1 against distances over the uncut body, at the best scale, within patches.
        spearman: Rank correlation of the same distances; 1 if the map preserves their order.
        trustworthiness: 1 if the six nearest taxels on the map are the nearest on the body.
        continuity: 1 if the six nearest taxels on the body are the nearest on the map.
    """

    edge_error: float | None
    pairs: int
    torn_pairs: int
    torn: float
    stress: float | None
    spearman: float | None
    trustworthiness: float | None
    continuity: float | None

    def to_json(self) -> dict[str, Any]:
        """Return plain values for JSON; null is unknown or infinite, as the angle of a face collapsed to a line."""
        return {key: json_value(value) for key, value in asdict(self).items()}


def measure_topography(points: FloatArray, distances: BodyDistances) -> Topography:
    """Compare distances on map and body, patch by patch, weighted by the patches' taxels.

    Args:
        points: (n, 2) map points of the taxels [m].
        distances: Body distances.

    Cost: 25 ms for 1000 taxels.
    """
    edge_error, torn = edge_lengths(points, distances)
    parts = [points[a:b] for a, b in pairwise(distances.first)]
    counts = np.diff(distances.first).astype(np.float64)
    rows = [
        (*_agreement(part, body), *neighbourhoods(part, body))
        for part, body in zip(parts, distances.patches, strict=True)
    ]
    stress, spearman, trust, continuity = (_mean(column, counts) for column in zip(*rows, strict=True))
    share = float(torn.mean()) if len(torn) else 0.0
    return Topography(edge_error, len(torn), int(torn.sum()), share, stress, spearman, trust, continuity)


def json_value(value: Any) -> Any:
    """Return ``value`` for JSON, with None for non-finite numbers."""
    if isinstance(value, dict):
        return {key: json_value(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def edge_lengths(points: FloatArray, distances: BodyDistances) -> tuple[float | None, BoolArray]:
    """Return the rms relative error of neighbours' distances at the best common scale, and a mask (e,) of torn pairs.

    The error is None if all are torn or the map is one point.
    """
    ends = points[distances.pairs]
    on_map = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    on_body = distances.lengths
    torn = on_map > SEAM_RATIO * on_body
    kept = ~torn & (on_body > 0)
    if not kept.any():
        return None if len(torn) else 0.0, torn
    ratio = on_map[kept] / on_body[kept]
    square = (ratio**2).sum()
    # The scale s that makes mean((ratio / s - 1)²) least is sum(ratio²) / sum(ratio).
    return float(np.sqrt(np.mean((ratio * ratio.sum() / square - 1) ** 2))) if square else None, torn


def neighbourhoods(
    points: FloatArray, body: PatchDistances, *, k: int = NEIGHBOURS
) -> tuple[float, float] | tuple[None, None]:
    """Return trustworthiness (no false neighbours on the map) and continuity (none lost); Venna and Kaski 2001.

    Both are 1 - sum(ranks beyond k there of the k nearest here) / largest such sum. Equal distances share the better
    rank, so that rounding on a regular skin does not matter.

    Args:
        points: (n, 2) map points of the patch's taxels.
        body: Their distances on the body.
        k: Number of neighbours.

    Returns:
        Both values; None if a taxel has fewer than 3 k - 1 others to rank.
    """
    others = len(points) - 1
    if others < 3 * k - 1:
        return None, None
    own = body.rows[:, None] == np.arange(len(points))
    flat = np.where(own, np.inf, np.linalg.norm(points[body.rows, None] - points[None], axis=2))
    near = np.where(own, np.inf, body.near)
    largest = len(body.rows) * k * (2 * others - 3 * k + 1) / 2
    return 1 - _beyond(flat, near, k) / largest, 1 - _beyond(near, flat, k) / largest


def _beyond(here: FloatArray, there: FloatArray, k: int) -> float:
    """Return the sum over rows of the ranks beyond k by ``there`` of the k nearest by ``here``."""
    nearest = np.argpartition(here, k - 1, axis=1)[:, :k]
    limits = np.take_along_axis(there, nearest, axis=1) * (1 - _ALIKE)
    places = np.stack([(there < limits[:, c, None]).sum(axis=1) for c in range(k)]) + 1
    return float(np.maximum(places - k, 0).sum())


def _agreement(points: FloatArray, body: PatchDistances) -> tuple[float | None, float | None]:
    """Return Kruskal's stress-1 at the best scale and Spearman's rank correlation of map and body distances."""
    if len(points) < 2:
        return 0.0, None
    on_map = np.linalg.norm(points[body.sources, None] - points[None], axis=2)
    other = body.sources[:, None] != np.arange(len(points))
    flat = on_map[other]
    true = body.from_sources[other]
    square = (flat**2).sum()
    if square == 0:
        return None, None
    scale = (flat * true).sum() / square
    return float(np.sqrt(((scale * flat - true) ** 2).sum() / (true**2).sum())), _spearman(flat, true)


def _spearman(a: FloatArray, b: FloatArray) -> float | None:
    """Return Pearson's correlation of the ranks; equal values share their mean rank."""
    first = _ranks(a)
    second = _ranks(b)
    first = first - first.mean()
    second = second - second.mean()
    size = np.sqrt((first**2).sum() * (second**2).sum())
    return float((first * second).sum() / size) if size > 0 else None


def _ranks(values: FloatArray) -> FloatArray:
    """Return ascending ranks. ``scipy.stats`` is not used because it takes 0.2 s to import."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    middle: FloatArray = np.cumsum(counts) - 0.5 * (counts - 1)
    return middle[place]


def _mean(values: Sequence[float | None], weights: FloatArray) -> float | None:
    """Return the weighted mean of the known values; None if there are none."""
    known = [(value, weight) for value, weight in zip(values, weights, strict=True) if value is not None and weight > 0]
    return float(np.average([v for v, _ in known], weights=[w for _, w in known])) if known else None
