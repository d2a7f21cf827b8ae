"""How well a map keeps the body's neighbourhoods and distances: what makes it topographic.

``BodyDistances`` says how far the taxels are from each other on the body: what every map is compared with, and no map
changes. ``measure_topography`` compares: pure functions of where the taxels lie on the map, so that a map drawn by hand
is judged like our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays, readonly
from tactile_maps.core.errors import Finding
from tactile_maps.geometry.geodesics import Geodesics
from tactile_maps.geometry.remesh.refine import insert_vertices
from tactile_maps.maps.model.tactile_map import SEAM_RATIO
from tactile_maps.skin.model.skin import Patch, Skin, Taxels

NEAR_PAIR = 0.008
"""Taxels closer than this [m] in space are a pair, where nothing is known about the surface between them."""
_ALL_EXACT = 60_000
"""Up to so many faces times taxels all distances are exact; 0.2 s."""
_PAIRS_EXACT = 40_000_000
"""Up to so many faces times taxels those between neighbours are; 0.7 s for 1000 taxels."""
_ROWS = 250
"""Taxels of a patch from which distances to all others are taken. On real links of 1000 taxels, against all rows, so
many spread evenly give stress within 2 % of its value and continuity within 0.003; 12 at random gave 14 %."""
_FACES_EXACT = 100_000
_FACES_QUICK = 20_000_000
"""So many faces are looked at for a patch's exact distances from afar, and for those by the heat method."""
_MOST = 10_000_000
"""Largest number of distances kept for one patch; beyond, fewer rows are taken."""
_REACH = 1.2
_LONGER = 1.05
"""Within so many pitches, and as far as a taxel's neighbours by their arcs and a little more, distances are exact."""


@dataclass(frozen=True, eq=False)
class PatchDistances:
    """Of one patch with n taxels, numbered within it.

    Attributes:
        sources: (s,) taxels whose distances to all are compared with those on the map.
        from_sources: (s, n) [m] exact where that was asked for or the patch is small; else the near ones.
        rows: (r,) taxels whose neighbourhoods are looked at: all of a small patch, else some spread evenly.
        near: (r, n) [m] exact for near taxels, within about 1 % (rms 1 to 2 %) for far ones.
    """

    sources: IntArray
    from_sources: FloatArray
    rows: IntArray
    near: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "from_sources", "near")
        freeze_arrays(self, "sources", "rows", dtype=np.int64)


class BodyDistances:
    """Distances between the taxels of each patch over the uncut body. Built once for a skin, asked for each map.

    Args:
        skin: The body.
        sources: How many taxels of the whole skin exact distances to all others are taken from for stress and rank
            correlation, where all would take too long; at least two of each patch. None: from ``rows``, by the heat
            method. On a real link, where stress is 0.14 and 0.30, five exact sources miss it by 0.04 and 0.05, as so
            few are chance; the rows by 0.003. A stress below 0.01 is then not told from none.
        seed: Chooses the first row, and the sources.

    Attributes:
        patches: One for each patch with taxels.
        first: (patches + 1,) number of each patch's first taxel.
        pairs: (e, 2) taxels that are neighbours on the body.
        lengths: (e,) [m] exact distance of each pair; where there are none, that of the arc between the two.
        findings: Where the distances are not exact.

    Cost: 1 s for 1000 taxels on 18,000 faces; an exact source takes 0.3 s there. On fine meshes fewer sources and
    fewer rows are asked, at least two of each patch.
    """

    def __init__(self, skin: Skin, *, sources: int | None = None, seed: int = 0) -> None:
        generator = np.random.default_rng(seed)
        findings = []
        patches = []
        lengths = [np.zeros(0)]
        for patch in skin.patches:
            wanted = None if sources is None else max(2, round(sources * len(patch.taxels) / max(len(skin), 1)))
            surface = _PatchSurface(patch)
            made = surface.distances(wanted, generator)
            patches.append(made)
            lengths.append(surface.lengths(made))
            if not surface.exact:
                findings.append(Finding("inexact-distance", patch.name, "body distances taken along edges"))
        self.patches: tuple[PatchDistances, ...] = tuple(patches)
        self.first = skin.first
        self.pairs = skin.neighbours
        self.lengths = readonly(np.concatenate(lengths))
        self.findings = tuple(findings)

    @classmethod
    def straight(
        cls, positions: FloatArray, *, first: Sequence[int] | None = None, pair: float = NEAR_PAIR
    ) -> BodyDistances:
        """From taxel positions alone: straight through space, which is too short around a body.

        Args:
            positions: (n, 3) [m].
            first: Number of each patch's first taxel, and n; by default all are one patch.
            pair: Taxels of a patch closer than this [m] are neighbours.
        """
        made = cls.__new__(cls)
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


class _PatchSurface:
    """A patch with its taxels as vertices, asked for distances between them."""

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
        """Whether exact distances can be had at all."""
        return self._geodesics.exact

    def distances(self, sources: int | None, generator: np.random.Generator) -> PatchDistances:
        """With exact ones from so many ``sources``; None for the near ones in their place. All where they are few."""
        count = len(self._taxels)
        positions = self._taxels.positions
        if count * self._faces <= _ALL_EXACT:
            every = np.arange(count)
            exact = self._afar(every)
            return PatchDistances(every, exact, every, exact)
        pitch = float(np.median(cKDTree(positions).query(positions, 2)[0][:, 1]))
        wanted = max(1, min(_ROWS, _MOST // count, _FACES_QUICK // self._faces))
        rows = _spread(positions, wanted, generator)
        every = np.arange(count)
        near = _rows([self._near(k, every, max(_REACH * pitch, self._reach[k])) for k in rows.tolist()], count)
        if sources is None:
            return PatchDistances(rows, near, rows, near)
        chosen = _some(count, max(2, min(sources, _FACES_EXACT // self._faces)), generator)
        return PatchDistances(chosen, self._afar(chosen), rows, near)

    def lengths(self, known: PatchDistances) -> FloatArray:
        """(e,) between neighbours [m]: exact, or of arcs where that is not possible or would take too long.

        Args:
            known: Of the patch; its near ones are exact within each taxel's reach.
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
                asked = int(source[mine[0]])
                result[mine] = self._near(asked, target[mine], self._reach[asked])
                far = mine[result[mine] >= self._reach[asked]]  # where the skin turns more sharply than its arc
                if len(far):
                    result[far] = self._near(asked, target[far], 2 * self._reach[asked])
        return result

    def _afar(self, taxels: IntArray) -> FloatArray:
        """(t, n) exact ones."""
        asked = self._vertices[taxels].tolist()
        return _rows([self._geodesics.from_vertex(k, self._vertices) for k in asked], len(self._vertices))

    def _near(self, taxel: int, others: IntArray, reach: float) -> FloatArray:
        """(t,) exact within ``reach``; beyond it the quick ones, which are then known to be longer than it."""
        source = int(self._vertices[taxel])
        targets = self._vertices[others]
        found = self._geodesics.from_vertex_within(source, targets, reach)
        if np.isinf(found).any():
            found = np.minimum(found, np.maximum(self._geodesics.approximate_from_vertex(source, targets), reach))
        return found


def _covering_ends(pairs: IntArray, taken: BoolArray) -> IntArray:
    """(e,) an end of each of ``pairs`` (e, 2): of those ``taken`` (n,) where one is, else of few others.

    These are the taxels outside a set without neighbours in it.
    """
    alone = ~taken
    for low, high in sorted(np.sort(pairs, axis=1).tolist()):
        alone[high] &= not alone[low]
    return np.where(taken[pairs[:, 1]] | alone[pairs[:, 0]], pairs[:, 1], pairs[:, 0])


def _through_space(positions: FloatArray) -> PatchDistances:
    count = len(positions)
    rows = _some(count, max(_MOST // max(count, 1), 1), np.random.default_rng(0))
    distances = cdist(positions[rows], positions)
    return PatchDistances(rows, distances, rows, distances)


def _closer_than(positions: FloatArray, reach: float) -> IntArray:
    found = cKDTree(positions).query_pairs(reach, output_type="ndarray") if len(positions) else np.zeros((0, 2))
    return np.unique(found.astype(np.int64).reshape(-1, 2), axis=0)


def _arcs(taxels: Taxels) -> FloatArray:
    """(e,) lengths of the circular arcs between neighbouring taxels that turn by the angle of their normals [m].

    Exact on a sphere and straight around a tube, where the straight line is too short.
    """
    if not len(taxels.neighbours):
        return np.zeros(0)
    positions = taxels.positions[taxels.neighbours]
    normals = taxels.normals[taxels.neighbours]
    half = 0.5 * np.arccos(np.clip(normals.prod(axis=1).sum(axis=1), -1.0, 1.0))
    return np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1) / np.sinc(half / np.pi)


def _some(count: int, wanted: int, generator: np.random.Generator) -> IntArray:
    """All, or ``wanted`` of them, in order."""
    if wanted >= count:
        return np.arange(count)
    return np.sort(generator.choice(count, wanted, replace=False))


def _spread(positions: FloatArray, wanted: int, generator: np.random.Generator) -> IntArray:
    """All of ``positions`` (n, 3), or ``wanted`` of them, each farthest from those before (Gonzalez 1985), in order."""
    count = len(positions)
    if wanted >= count:
        return np.arange(count)
    chosen = [int(generator.integers(count))]
    distance = np.full(count, np.inf)
    while len(chosen) < wanted:
        distance = np.minimum(distance, np.linalg.norm(positions - positions[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return np.sort(np.array(chosen))


def _rows(rows: list[FloatArray], count: int) -> FloatArray:
    return np.stack(rows) if rows else np.zeros((0, count))


NEIGHBOURS = 6
_ALIKE = 1e-6
"""Distances that differ by less than this share are equal: on a regular skin only rounding orders them."""


@dataclass(frozen=True)
class Topography:
    """What a map keeps of the body. None where it cannot be known: too few taxels, or no modules.

    Attributes:
        edge_error: Rms relative error of the lengths between neighbouring taxels at the best scale, without torn ones.
        pairs: Neighbouring taxels on the body.
        torn_pairs: How many of them are more than twice as far apart on the map.
        torn: Their share.
        stress: Kruskal's stress-1 against distances over the uncut body, at the best scale, within patches.
        spearman: Rank correlation of the same distances; 1 if the map orders them alike.
        trustworthiness: 1 if the six nearest taxels on the map are so on the body.
        continuity: 1 if the six nearest taxels on the body are so on the map.
        pairs_between_modules: Neighbours that belong to different modules.
        torn_between_modules: How many of these are torn apart; None without modules.
        trustworthiness_between_modules: As above, counting only taxels of other modules than one's own.
        continuity_between_modules: Likewise.
    """

    edge_error: float | None
    pairs: int
    torn_pairs: int
    torn: float
    stress: float | None
    spearman: float | None
    trustworthiness: float | None
    continuity: float | None
    pairs_between_modules: int = 0
    torn_between_modules: int | None = None
    trustworthiness_between_modules: float | None = None
    continuity_between_modules: float | None = None

    def to_json(self) -> dict[str, Any]:
        """The same as plain values; null is unknown, or infinite, as the angle of a face that the map makes a line."""
        return {key: json_value(value) for key, value in asdict(self).items()}


def measure_topography(points: FloatArray, distances: BodyDistances, *, modules: IntArray | None = None) -> Topography:
    """Compare distances on map and body, patch by patch; patches count by their taxels.

    Args:
        points: (n, 2) each taxel on the map [m].
        distances: The body's.
        modules: (n,) the module that carries each taxel. A module is rigid, so that pairs within one can hardly go
            wrong and flatter every score; with modules the scores between them are told apart.

    Cost: 25 ms for 1000 taxels.
    """
    edge_error, torn = edge_lengths(points, distances)
    parts = [points[a:b] for a, b in pairwise(distances.first)]
    counts = np.diff(distances.first).astype(np.float64)
    rows = [(*_agreement(part, body), *neighbourhoods(part, body)) for part, body in _by_patch(parts, distances)]
    stress, spearman, trust, continuity = (_mean(column, counts) for column in zip(*rows, strict=True))
    between = _between_modules(parts, distances, torn, modules) if modules is not None else ()
    share = float(torn.mean()) if len(torn) else 0.0
    return Topography(edge_error, len(torn), int(torn.sum()), share, stress, spearman, trust, continuity, *between)


def json_value(value: Any) -> Any:
    """``value`` for JSON, in which there is no infinity."""
    if isinstance(value, dict):
        return {key: json_value(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(entry) for entry in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def edge_lengths(points: FloatArray, distances: BodyDistances) -> tuple[float | None, BoolArray]:
    """Rms relative error of the lengths between neighbours at the best common scale, and which (e,) are torn apart.

    The error is None where all are torn apart or the map is one point.
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
    points: FloatArray, body: PatchDistances, *, module: IntArray | None = None, k: int = NEIGHBOURS
) -> tuple[float, float] | tuple[None, None]:
    """Trustworthiness (no false neighbours on the map) and continuity (none lost); Venna and Kaski 2001.

    Both are 1 - sum of how far the k nearest here are beyond place k there / the largest such sum. Taxels equally far
    share the better place, so that a regular skin is not judged by rounding.

    Args:
        points: (n, 2) the patch's taxels on the map.
        body: Their distances.
        module: (n,) if given, a taxel's own module is left out of its row.
        k: Neighbours looked at.

    Returns:
        Both; None where every taxel has fewer than 3 k - 1 others to be ranked.
    """
    flat = np.linalg.norm(points[body.rows, None] - points[None], axis=2)
    shut = body.rows[:, None] == np.arange(len(points)) if module is None else module[body.rows, None] == module
    others = len(points) - shut.sum(axis=1)
    asked = others >= 3 * k - 1
    if not asked.any():
        return None, None
    flat, near, others = (array[asked] for array in (np.where(shut, np.inf, flat), body.near, others))
    near = np.where(shut[asked], np.inf, near)
    largest = float((k * (2 * others - 3 * k + 1) / 2).sum())
    return 1 - _beyond(flat, near, k) / largest, 1 - _beyond(near, flat, k) / largest


def _beyond(here: FloatArray, there: FloatArray, k: int) -> float:
    """Sum over rows of how far the k nearest by ``here`` are beyond place k by ``there``."""
    nearest = np.argpartition(here, k - 1, axis=1)[:, :k]
    limits = np.take_along_axis(there, nearest, axis=1) * (1 - _ALIKE)
    places = np.stack([(there < limits[:, c, None]).sum(axis=1) for c in range(k)]) + 1
    return float(np.maximum(places - k, 0).sum())


def _agreement(points: FloatArray, body: PatchDistances) -> tuple[float | None, float | None]:
    """Kruskal's stress-1 at the best scale and Spearman's rank correlation, of map and body distances."""
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
    """Pearson's correlation of the ranks; equal values share their mean rank."""
    first = _ranks(a)
    second = _ranks(b)
    first = first - first.mean()
    second = second - second.mean()
    size = np.sqrt((first**2).sum() * (second**2).sum())
    return float((first * second).sum() / size) if size > 0 else None


def _ranks(values: FloatArray) -> FloatArray:
    """Places in ascending order. Not by ``scipy.stats``, which takes 0.2 s to import and is used for nothing else."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    middle: FloatArray = np.cumsum(counts) - 0.5 * (counts - 1)
    return middle[place]


def _between_modules(
    parts: list[FloatArray], distances: BodyDistances, torn: BoolArray, modules: IntArray
) -> tuple[int, int, float | None, float | None]:
    counts = np.diff(distances.first).astype(np.float64)
    own = [modules[a:b] for a, b in pairwise(distances.first)]
    rows = [
        neighbourhoods(part, body, module=m) for (part, body), m in zip(_by_patch(parts, distances), own, strict=True)
    ]
    trust, continuity = (_mean(column, counts) for column in zip(*rows, strict=True))
    across = np.diff(modules[distances.pairs], axis=1)[:, 0] != 0
    return int(across.sum()), int(torn[across].sum()), trust, continuity


def _by_patch(parts: list[FloatArray], distances: BodyDistances) -> list[tuple[FloatArray, PatchDistances]]:
    return list(zip(parts, distances.patches, strict=True))


def _mean(values: Sequence[float | None], weights: FloatArray) -> float | None:
    """Weighted mean of what could be measured; None where nothing could."""
    known = [(value, weight) for value, weight in zip(values, weights, strict=True) if value is not None and weight > 0]
    return float(np.average([v for v, _ in known], weights=[w for _, w in known])) if known else None
