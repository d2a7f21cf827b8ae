"""Taxels placed evenly on a surface, each with the area it answers for.

Farthest-point sampling gives even spacing at once; a few Lloyd rounds (each taxel moves to the middle of its cell) make
the cells equal. Cells are geodesic: grown over the surface, so they never jump across a gap or through a thin wall.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from app.arrays import FloatArray, IntArray
from app.errors import SkinError
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.topology import face_pairs
from app.skin.taxels import Quadrature, Taxels

_LLOYD_ROUNDS = 8
_STRAIGHTENING_ROUNDS = 4


def place_taxels(surface: Mesh, count: int, *, seed: int = 0) -> Taxels:
    """Place ``count`` taxels evenly on a connected surface.

    The faces' centres are the quadrature points, so the taxels' areas sum to the surface's to rounding.

    Args:
        surface: Connected; many more faces than taxels (ten each or more).
        count: At least 1, at most the number of faces.
        seed: Chooses the first taxel.

    Raises:
        SkinError: More taxels than faces.

    Cost: 1000 taxels on 16,000 faces take about 0.4 s, most of it for the cells.
    """
    if not 1 <= count <= len(surface.faces):
        raise SkinError(
            "the surface is too coarse for so many taxels",
            value=f"{count} taxels on {len(surface.faces)} faces",
            remedy="Ask for fewer taxels or a finer surface",
        )
    centres = surface.vertices[surface.faces].mean(axis=1)
    graph = surface_graph(surface, centres)
    seeds = _farthest_points(centres, count, int(np.random.default_rng(seed).integers(len(centres))))
    for _ in range(_LLOYD_ROUNDS):
        seeds = _cell_centres(centres, surface.face_areas, cells(graph, seeds), count)
    middles = _means(centres, surface.face_areas, cells(graph, seeds), count)
    return taxels_at(surface, middles, straight_cells(surface, middles, cells(graph, seeds), seeds))


def taxels_at(surface: Mesh, points: FloatArray, owner: IntArray) -> Taxels:
    """Taxels at the surface points closest to ``points`` (n, 3), with the faces' owners given as their cells.

    Args:
        surface: The patch's surface.
        points: (n, 3) [m].
        owner: (m,) taxel of each face, or -1 for a face that no taxel feels.
    """
    faces, weights, _ = ClosestPoint(surface).query(points)
    felt = owner >= 0
    centres = surface.vertices[surface.faces].mean(axis=1)
    quadrature = Quadrature(centres[felt], surface.face_normals[felt], surface.face_areas[felt], owner[felt])
    normals = np.einsum("kc,kcd->kd", weights, surface.vertex_normals[surface.faces[faces]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    pairs = owner[face_pairs(surface.faces)]
    pairs = pairs[(pairs >= 0).all(axis=1) & (pairs[:, 0] != pairs[:, 1])]
    return Taxels(
        positions=surface.points(faces, weights),
        normals=normals,
        faces=faces,
        weights=weights,
        areas=np.bincount(owner[felt], surface.face_areas[felt], len(points)).astype(np.float64),
        neighbours=np.unique(np.sort(pairs, axis=1), axis=0).reshape(-1, 2),
        quadrature=quadrature,
    )


def surface_graph(surface: Mesh, centres: FloatArray) -> csr_matrix:
    """Sparse (m, m) distances between the centres of faces that share an edge [m]."""
    pairs = face_pairs(surface.faces)
    lengths = np.linalg.norm(centres[pairs[:, 0]] - centres[pairs[:, 1]], axis=1)
    return coo_matrix((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(centres), len(centres))).tocsr()


def cells(graph: csr_matrix, seeds: IntArray, *, reach: float = np.inf) -> IntArray:
    """(m,) which of the seed faces is nearest over the surface; -1 where none is within ``reach`` [m]."""
    _, _, source = dijkstra(graph, directed=False, indices=seeds, min_only=True, return_predecessors=True, limit=reach)
    owner = np.full(graph.shape[0], -1, dtype=np.int64)
    owner[seeds] = np.arange(len(seeds))
    return np.where(source >= 0, owner[np.maximum(source, 0)], -1)


def straight_cells(surface: Mesh, points: FloatArray, owner: IntArray, seeds: IntArray) -> IntArray:
    """(m,) the same cells with straight borders: faces beside a border go to the nearer taxel of the two.

    Paths along a mesh favour its directions, and leave cells with teeth; across one border, a straight line is the
    truer distance, and since only neighbours are compared nothing jumps.

    Args:
        surface: The patch's surface.
        points: (n, 3) the taxels [m].
        owner: (m,) from ``cells``.
        seeds: (n,) one face of each taxel that stays its own.
    """
    centres = surface.vertices[surface.faces].mean(axis=1)
    pairs = face_pairs(surface.faces)
    face, beside = np.concatenate([pairs, pairs[:, ::-1]]).T
    owner = owner.copy()
    fixed = np.zeros(len(owner), dtype=bool)
    fixed[seeds] = True
    for _ in range(_STRAIGHTENING_ROUNDS):
        border = (owner[face] != owner[beside]) & (owner[face] >= 0) & (owner[beside] >= 0) & ~fixed[face]
        here, other = face[border], owner[beside[border]]
        away = np.linalg.norm(centres[here] - points[other], axis=1)
        nearer = away < np.linalg.norm(centres[here] - points[owner[here]], axis=1)
        # Farthest first, so that of two neighbours that both are nearer the nearest has the last word.
        order = np.lexsort((other[nearer], -away[nearer]))
        owner[here[nearer][order]] = other[nearer][order]
    return owner


def _farthest_points(points: FloatArray, count: int, first: int) -> IntArray:
    """(count,) each next point is the one farthest from all before (Gonzalez 1985)."""
    chosen = np.empty(count, dtype=np.int64)
    chosen[0] = first
    squared = ((points - points[first]) ** 2).sum(axis=1)
    for k in range(1, count):
        chosen[k] = squared.argmax()
        np.minimum(squared, ((points - points[chosen[k]]) ** 2).sum(axis=1), out=squared)
    return chosen


def _means(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """(count, 3) area-weighted mean of each cell's points."""
    total = np.stack([np.bincount(owner, weights=areas * points[:, k], minlength=count) for k in range(3)], axis=1)
    return total / np.bincount(owner, weights=areas, minlength=count)[:, None]


def _cell_centres(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> IntArray:
    """(count,) for each cell the point of its own closest to its mean."""
    away = np.linalg.norm(points - _means(points, areas, owner, count)[owner], axis=1)
    order = np.lexsort((away, owner))
    return order[np.searchsorted(owner[order], np.arange(count))]
