"""How far the taxels are from each other on the body: what every map is compared with, and no map changes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding
from app.maps.geodesics import Geodesics
from app.maps.insert import insert_points
from app.skin.skin import Patch, Skin
from app.skin.taxels import Taxels

NEAR_PAIR = 0.008
"""Taxels closer than this [m] in space are a pair, where nothing is known about the surface between them."""
_ALL_EXACT = 60_000
"""Up to so many faces times taxels all distances are exact; 0.2 s."""
_FACES_EXACT, _FACES_QUICK = 100_000, 20_000_000
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
        sources: (s,) taxels with exact distances to all.
        exact: (s, n) [m].
        rows: (r,) taxels with near distances to all; every one unless there are thousands.
        near: (r, n) [m] exact for near taxels, within about 1 % for far ones.
    """

    sources: IntArray
    exact: FloatArray
    rows: IntArray
    near: FloatArray

    def __post_init__(self) -> None:
        for name in ("exact", "near"):
            object.__setattr__(self, name, readonly(getattr(self, name)))
        for name in ("sources", "rows"):
            object.__setattr__(self, name, readonly(getattr(self, name), np.int64))


class BodyDistances:
    """Distances between the taxels of each patch over the uncut body. Built once for a skin, asked for each map.

    Args:
        skin: The body.
        sources: How many taxels of the whole skin exact distances to all others are taken from, where all would take
            too long; at least two of each patch.
        seed: Chooses them.

    Attributes:
        patches: One for each patch with taxels.
        first: (patches + 1,) number of each patch's first taxel.
        pairs: (e, 2) taxels that are neighbours on the body.
        lengths: (e,) [m] exact distance of each pair; where there are none, that of the arc between the two.
        findings: Where the distances are not exact.

    Cost: 3 s for 1000 taxels on 21,000 faces, half of it for the sources. On fine meshes fewer sources and fewer taxels
    are asked, at least two of each patch, so that it grows little beyond 10 s.
    """

    def __init__(self, skin: Skin, *, sources: int = 12, seed: int = 0) -> None:
        generator, findings, patches, lengths = np.random.default_rng(seed), [], [], [np.zeros(0)]
        for patch in skin.patches:
            wanted = max(2, round(sources * len(patch.taxels) / max(len(skin), 1)))
            arcs = _arcs(patch.taxels)
            made, exact = _over_surface(patch, arcs, wanted, generator)
            patches.append(made)
            known = exact and len(made.rows) == len(patch.taxels)
            lengths.append(made.near[tuple(patch.taxels.neighbours.T)] if known else arcs)
            if not exact:
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


def _over_surface(
    patch: Patch, arcs: FloatArray, sources: int, generator: np.random.Generator
) -> tuple[PatchDistances, bool]:
    taxels, count = patch.taxels, len(patch.taxels)
    mesh, vertices = insert_points(patch.surface, taxels.faces, taxels.weights)
    geodesics = Geodesics(mesh)
    if count * len(mesh.faces) <= _ALL_EXACT:
        every = np.arange(count)
        exact = _rows([geodesics.from_vertex(int(v), vertices) for v in vertices], count)
        return PatchDistances(every, exact, every, exact), geodesics.exact
    chosen = _some(count, max(2, min(sources, _FACES_EXACT // len(mesh.faces))), generator)
    rows = _some(count, max(1, min(_MOST // count, _FACES_QUICK // len(mesh.faces))), generator)
    reach = np.full(count, _REACH * np.median(cKDTree(taxels.positions).query(taxels.positions, 2)[0][:, 1]))
    np.maximum.at(reach, taxels.neighbours.T.ravel(), np.tile(_LONGER * arcs, 2))
    exact = _rows([geodesics.from_vertex(int(vertices[k]), vertices) for k in chosen], count)
    near = _rows([_near(geodesics, int(vertices[k]), vertices, float(reach[k])) for k in rows], count)
    return PatchDistances(chosen, exact, rows, near), geodesics.exact


def _near(geodesics: Geodesics, source: int, vertices: IntArray, reach: float) -> FloatArray:
    """Exact within ``reach``; beyond it the quick ones, which are then known to be longer than it."""
    far = np.maximum(geodesics.quickly_from_vertex(source, vertices), reach)
    return np.minimum(geodesics.near_vertex(source, vertices, reach), far)


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
    positions, normals = taxels.positions[taxels.neighbours], taxels.normals[taxels.neighbours]
    half = 0.5 * np.arccos(np.clip(normals.prod(axis=1).sum(axis=1), -1.0, 1.0))
    return np.linalg.norm(positions[:, 0] - positions[:, 1], axis=1) / np.sinc(half / np.pi)


def _some(count: int, wanted: int, generator: np.random.Generator) -> IntArray:
    """All, or ``wanted`` of them, in order."""
    if wanted >= count:
        return np.arange(count)
    return np.sort(generator.choice(count, wanted, replace=False))


def _rows(rows: list[FloatArray], count: int) -> FloatArray:
    return np.stack(rows) if rows else np.zeros((0, count))
