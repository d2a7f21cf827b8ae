"""Taxels placed evenly on a surface, each with the area it answers for: its cell (``cells``).

Farthest-point sampling (Gonzalez 1985) gives even spacing at once; a few rounds of Lloyd relaxation (each taxel moves
to the middle of its cell) make the cells equal. The cells are geodesic Voronoi cells: grown over the surface, along the
graph of neighbouring faces, so they never jump across a gap or through a thin wall. Their borders are then cut exactly.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.geodesics import edge_graph, nearest_sources
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, edge_lengths
from tactile_maps.skin.model.skin import Taxels
from tactile_maps.skin.taxel_placement.cells import cut_cells

LLOYD_ROUNDS = 8
_STRAIGHTENING_ROUNDS = 4


def place_evenly(
    surface: Mesh, count: int, *, seed: int = 0, density: FloatArray | None = None, allowed: BoolArray | None = None
) -> Taxels:
    """Place ``count`` taxels evenly on a connected surface.

    The taxels' areas sum to that of the allowed faces to rounding.

    Args:
        surface: Connected; many more faces than taxels (ten each or more).
        count: At least 1, at most the number of allowed faces.
        seed: Chooses the first taxel.
        density: (m,) taxels per area on each face, above zero, relative to the others.
        allowed: (m,) faces that taxels may lie on and feel with; all if None.

    Raises:
        SkinError: More taxels than faces.

    Cost: 1000 taxels on 16,000 faces take about 0.4 s, most of it for the cells.
    """
    room = len(surface.faces) if allowed is None else int(allowed.sum())
    if not 1 <= count <= room:
        raise SkinError(
            "the surface is too coarse for so many taxels",
            value=f"{count} taxels on {room} faces",
            remedy="Ask for fewer taxels or a finer surface",
        )
    first = int(np.random.default_rng(seed).integers(room))
    start = np.array([first if allowed is None else np.flatnonzero(allowed)[first]])
    seeds = farthest_point_sampling(surface, count, start, density=density, allowed=allowed)
    return lloyd_relaxation(surface, seeds, density=density, allowed=allowed)


def farthest_point_sampling(
    surface: Mesh, count: int, start: IntArray, *, density: FloatArray | None = None, allowed: BoolArray | None = None
) -> IntArray:
    """(count,) faces: ``start`` (s,), then each next the one farthest from all before (Gonzalez 1985)."""
    return farthest_points(surface.vertices[surface.faces].mean(axis=1), count, start, weight=density, allowed=allowed)


def farthest_points(
    points: FloatArray,
    count: int,
    start: IntArray,
    *,
    weight: FloatArray | None = None,
    allowed: BoolArray | None = None,
) -> IntArray:
    """(count,) numbers of ``points`` (n, d): ``start`` (s,), then each next the one farthest from all before.

    Args:
        points: Any.
        count: At least one.
        start: At least one.
        weight: (n,) by which squared distances count.
        allowed: (n,) which may be chosen.
    """
    chosen = np.empty(count, dtype=np.int64)
    chosen[: len(start)] = start
    columns = np.ascontiguousarray(points.T)  # to sum over rows of three takes four times as long
    squared = np.full(len(points), np.inf)
    if allowed is not None:
        squared[~allowed] = -1.0
    for k in range(count):
        if k >= len(start):
            chosen[k] = (squared if weight is None else squared * weight).argmax()
        np.minimum(squared, sum((column - column[chosen[k]]) ** 2 for column in columns), out=squared)
    return chosen


def lloyd_relaxation(
    surface: Mesh,
    seeds: IntArray,
    *,
    density: FloatArray | None = None,
    allowed: BoolArray | None = None,
    rounds: int = LLOYD_ROUNDS,
) -> Taxels:
    """Taxels that start on the faces ``seeds`` (n,), each moved ``rounds`` times to the middle of its cell.

    Where a density is given, lengths are measured times its root: places that are even by that measure are as dense as
    wanted. Cells grow across faces that are not allowed, but feel nothing there.
    """
    centres = surface.vertices[surface.faces].mean(axis=1)
    count = len(seeds)
    graph = face_graph(surface, centres)
    mass = surface.face_areas
    if density is not None:
        root = diags(np.sqrt(density / density.mean()))
        graph = (root @ graph + graph @ root) / 2
        mass = mass * density
    open_ = np.ones(len(mass), dtype=bool) if allowed is None else allowed
    for _ in range(rounds):
        seeds = _central_faces(centres, mass, np.where(open_, geodesic_voronoi(graph, seeds), -1), count)
    owner = np.where(open_, geodesic_voronoi(graph, seeds), -1)
    middles = _centroids(centres[open_], mass[open_], owner[open_], count)
    ground = np.flatnonzero(open_)
    faces, weights, _ = ClosestPoint(Mesh(surface.vertices, surface.faces[ground])).query(middles)
    owner = straighten_cells(surface, middles, owner, seeds)
    return taxels_at_barycentric(surface, ground[faces], weights, owner)


def taxels_at_points(surface: Mesh, points: FloatArray, owner: IntArray) -> Taxels:
    """Taxels at the surface points closest to ``points`` (n, 3), whose cells are cut from the faces that they own.

    Args:
        surface: The patch's surface.
        points: (n, 3) [m].
        owner: (m,) taxel of each face, or -1 for a face that no taxel feels.
    """
    faces, weights, _ = ClosestPoint(surface).query(points)
    return taxels_at_barycentric(surface, faces, weights, owner)


def taxels_at_barycentric(surface: Mesh, faces: IntArray, weights: FloatArray, owner: IntArray) -> Taxels:
    """Taxels at the points with barycentric ``weights`` (n, 3) in ``faces`` (n,); owners as ``taxels_at_points``."""
    positions = surface.points(faces, weights)
    cells = cut_cells(surface, positions, owner)
    normals = np.einsum("kc,kcd->kd", weights, surface.vertex_normals[surface.faces[faces]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Taxels(
        positions=positions,
        normals=normals,
        faces=faces,
        weights=weights,
        areas=np.bincount(cells.quadrature.taxel, cells.quadrature.areas, len(faces)).astype(np.float64),
        neighbours=cells.neighbours,
        quadrature=cells.quadrature,
    )


def face_graph(surface: Mesh, centres: FloatArray) -> csr_matrix:
    """Sparse (m, m) distances between the centres of faces that share an edge [m]."""
    pairs = surface.connectivity.face_pairs
    return edge_graph(pairs, edge_lengths(centres, pairs), len(centres))


def geodesic_voronoi(graph: csr_matrix, seeds: IntArray, *, reach: float = np.inf) -> IntArray:
    """(m,) which of the seed faces is nearest over the surface; -1 where none is within ``reach`` [m]."""
    source = nearest_sources(graph, seeds, limit=reach)[1]
    owner = np.full(graph.shape[0], -1, dtype=np.int64)
    owner[seeds] = np.arange(len(seeds))
    return np.where(source >= 0, owner[np.maximum(source, 0)], -1)


def distinct_faces(centres: FloatArray, points: FloatArray) -> IntArray:
    """(n,) for each point the nearest face that no point before has taken, so that every taxel feels something."""
    order = cKDTree(centres).query(points, k=min(64, len(centres)))[1].reshape(len(points), -1)
    taken: set[int] = set()
    seeds = []
    for faces in order.tolist():
        free = next((face for face in faces if face not in taken), None)
        if free is None:
            raise SkinError("the taxels lie too close together for the cover", value=f"{len(points)} taxels")
        taken.add(free)
        seeds.append(free)
    return np.array(seeds, dtype=np.int64)


def straighten_cells(surface: Mesh, points: FloatArray, owner: IntArray, seeds: IntArray) -> IntArray:
    """(m,) the same cells with straight borders: faces beside a border go to the nearer taxel of the two.

    Paths along a mesh favour its directions, and leave cells with teeth; across one border, a straight line is the
    truer distance, and since only neighbours are compared nothing jumps.

    Args:
        surface: The patch's surface.
        points: (n, 3) the taxels [m].
        owner: (m,) from ``geodesic_voronoi``.
        seeds: (n,) one face of each taxel that stays its own.
    """
    centres = surface.vertices[surface.faces].mean(axis=1)
    pairs = surface.connectivity.face_pairs
    face, beside = np.concatenate([pairs, pairs[:, ::-1]]).T
    owner = owner.copy()
    fixed = np.zeros(len(owner), dtype=bool)
    fixed[seeds] = True
    for _ in range(_STRAIGHTENING_ROUNDS):
        border = (owner[face] != owner[beside]) & (owner[face] >= 0) & (owner[beside] >= 0) & ~fixed[face]
        here = face[border]
        other = owner[beside[border]]
        away = np.linalg.norm(centres[here] - points[other], axis=1)
        nearer = away < np.linalg.norm(centres[here] - points[owner[here]], axis=1)
        # Farthest first, so that of two neighbours that both are nearer the nearest has the last word.
        order = np.lexsort((other[nearer], -away[nearer]))
        owner[here[nearer][order]] = other[nearer][order]
    return owner


def _centroids(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """(count, 3) area-weighted mean of each cell's points."""
    total = np.stack([np.bincount(owner, weights=areas * points[:, k], minlength=count) for k in range(3)], axis=1)
    return total / np.bincount(owner, weights=areas, minlength=count)[:, None]


def _central_faces(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> IntArray:
    """(count,) for each cell the point of its own closest to its mean; points of no cell (-1) do not count."""
    own = np.flatnonzero(owner >= 0)
    points = points[own]
    areas = areas[own]
    owner = owner[own]
    away = np.linalg.norm(points - _centroids(points, areas, owner, count)[owner], axis=1)
    order = np.lexsort((away, owner))
    return own[order[np.searchsorted(owner[order], np.arange(count))]]
