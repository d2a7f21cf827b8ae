"""Taxels placed evenly on a surface, each with its cell: the area that it reads (``cells``).

Farthest-point sampling (Gonzalez 1985) spaces the taxels evenly; a few rounds of Lloyd relaxation, which move each
taxel to the middle of its cell, make the cells equal. Cells are geodesic Voronoi cells, grown along the graph of
adjacent faces, so that they do not cross a gap or a thin wall. Their borders are then cut exactly.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import SkinError, counted
from tactile_maps.geometry.geodesics import edge_graph, nearest_sources
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, edge_lengths
from tactile_maps.geometry.surface.points import sums_by_label
from tactile_maps.skin.model.skin import Taxels
from tactile_maps.skin.taxel_placement.cells import cut_cells

LLOYD_ROUNDS = 8
_STRAIGHTENING_ROUNDS = 4


def place_evenly(
    surface: Mesh, count: int, *, seed: int = 0, density: FloatArray | None = None, allowed: BoolArray | None = None
) -> Taxels:
    """Place ``count`` taxels evenly on a connected surface.

    The areas of the taxels sum to that of the allowed faces, up to rounding.

    Args:
        surface: Connected surface with ten faces or more per taxel.
        count: Number of taxels, at least 1 and at most the number of allowed faces.
        seed: Seed for the choice of the first taxel.
        density: (m,) relative number of taxels per area on each face, above zero.
        allowed: (m,) faces that may have taxels and belong to cells; None for all.

    Raises:
        SkinError: There are more taxels than faces.

    Cost: 0.4 s for 1000 taxels on 16,000 faces, mostly for the cells.
    """
    room = len(surface.faces) if allowed is None else int(allowed.sum())
    if not 1 <= count <= room:
        raise SkinError(
            "the surface is too coarse for so many taxels",
            value=f"{counted(count, 'taxel')} on {counted(room, 'face')}",
            remedy="Place fewer taxels or use a finer surface",
        )
    first = int(np.random.default_rng(seed).integers(room))
    start = np.array([first if allowed is None else np.flatnonzero(allowed)[first]])
    seeds = farthest_point_sampling(surface, count, start, density=density, allowed=allowed)
    return lloyd_relaxation(surface, seeds, density=density, allowed=allowed)


def share_by_area(areas: FloatArray, taxels: int) -> IntArray:
    """Return (parts,) numbers of taxels in proportion to ``areas``, by largest remainders, so that all are placed."""
    shares = taxels * areas / areas.sum()
    counts = np.floor(shares).astype(np.int64)
    counts[np.argsort(counts - shares, kind="stable")[: taxels - counts.sum()]] += 1
    return counts


def farthest_point_sampling(
    surface: Mesh, count: int, start: IntArray, *, density: FloatArray | None = None, allowed: BoolArray | None = None
) -> IntArray:
    """Return (count,) faces: ``start`` (s,), then repeatedly the face farthest from all before (Gonzalez 1985)."""
    return farthest_points(surface.face_centres, count, start, weight=density, allowed=allowed)


def farthest_points(
    points: FloatArray,
    count: int,
    start: IntArray,
    *,
    weight: FloatArray | None = None,
    allowed: BoolArray | None = None,
) -> IntArray:
    """Return (count,) indices of points: ``start``, then repeatedly the point farthest from all before.

    Args:
        points: (n, d) points.
        count: Number of points to choose.
        start: (s,) indices of the first ones, at least one.
        weight: (n,) factors of the squared distances.
        allowed: (n,) points that may be chosen.
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
    """Return taxels that start on the faces ``seeds`` (n,), moved ``rounds`` times to the middles of their cells.

    With a density, lengths are scaled by its square root: taxels that are even in this metric have the requested
    density. Cells grow across faces that are not allowed, but do not include them.
    """
    centres = surface.face_centres
    count = len(seeds)
    graph = face_graph(surface)
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
    candidates = np.flatnonzero(open_)
    faces, weights, _ = ClosestPoint(Mesh(surface.vertices, surface.faces[candidates])).query(middles)
    owner = straighten_cells(surface, middles, owner, seeds)
    return taxels_at_barycentric(surface, candidates[faces], weights, owner)


def taxels_at_points(surface: Mesh, points: FloatArray, owner: IntArray) -> Taxels:
    """Return taxels at the surface points closest to ``points``, with cells cut from the faces that they own.

    Args:
        surface: Surface of the patch.
        points: (n, 3) [m].
        owner: (m,) taxel of each face, or -1 for a face outside all cells.
    """
    faces, weights, _ = ClosestPoint(surface).query(points)
    return taxels_at_barycentric(surface, faces, weights, owner)


def taxels_at_barycentric(surface: Mesh, faces: IntArray, weights: FloatArray, owner: IntArray) -> Taxels:
    """Return taxels at the points with barycentric ``weights`` (n, 3) in ``faces`` (n,); see ``taxels_at_points``."""
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


def face_graph(surface: Mesh) -> csr_matrix:
    """Return sparse (m, m) distances between the centres of faces that share an edge [m]."""
    pairs = surface.connectivity.face_pairs
    return edge_graph(pairs, edge_lengths(surface.face_centres, pairs), len(surface.faces))


def geodesic_voronoi(graph: csr_matrix, seeds: IntArray, *, reach: float = np.inf) -> IntArray:
    """Return (m,) the index of the seed face nearest to each face along the surface, -1 beyond ``reach`` [m]."""
    source = nearest_sources(graph, seeds, limit=reach)[1]
    owner = np.full(graph.shape[0], -1, dtype=np.int64)
    owner[seeds] = np.arange(len(seeds))
    return np.where(source >= 0, owner[np.maximum(source, 0)], -1)


def distinct_faces(centres: FloatArray, points: FloatArray) -> IntArray:
    """Return (n,) for each point the nearest face that no earlier point has, so that no taxel is without a cell."""
    order = cKDTree(centres).query(points, k=min(64, len(centres)))[1].reshape(len(points), -1)
    taken: set[int] = set()
    seeds = []
    for faces in order.tolist():
        free = next((face for face in faces if face not in taken), None)
        if free is None:
            raise SkinError("the taxels are too close together for the cover", value=f"{len(points)} taxels")
        taken.add(free)
        seeds.append(free)
    return np.array(seeds, dtype=np.int64)


def straighten_cells(surface: Mesh, points: FloatArray, owner: IntArray, seeds: IntArray) -> IntArray:
    """Return (m,) owners of the faces of the same cells with straight borders.

    Faces next to a border go to the nearer of the two taxels. Path lengths along mesh edges depend on their directions,
    which makes borders jagged; across a single border the straight distance is more accurate. Only adjacent cells are
    compared, so that cells stay connected.

    Args:
        surface: Surface of the patch.
        points: (n, 3) taxels [m].
        owner: (m,) from ``geodesic_voronoi``.
        seeds: (n,) a face of each taxel that does not change its owner.
    """
    centres = surface.face_centres
    pairs = surface.connectivity.face_pairs
    face, adjacent = np.concatenate([pairs, pairs[:, ::-1]]).T
    owner = owner.copy()
    fixed = np.zeros(len(owner), dtype=bool)
    fixed[seeds] = True
    for _ in range(_STRAIGHTENING_ROUNDS):
        border = (owner[face] != owner[adjacent]) & (owner[face] >= 0) & (owner[adjacent] >= 0) & ~fixed[face]
        here = face[border]
        other = owner[adjacent[border]]
        away = np.linalg.norm(centres[here] - points[other], axis=1)
        nearer = away < np.linalg.norm(centres[here] - points[owner[here]], axis=1)
        # Farthest first: of two taxels that are both nearer, the nearest is assigned last.
        order = np.lexsort((other[nearer], -away[nearer]))
        owner[here[nearer][order]] = other[nearer][order]
    return owner


def _centroids(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> FloatArray:
    """Return (count, 3) area-weighted mean of the points of each cell."""
    return sums_by_label(owner, areas[:, None] * points, count) / np.bincount(owner, areas, count)[:, None]


def _central_faces(points: FloatArray, areas: FloatArray, owner: IntArray, count: int) -> IntArray:
    """Return (count,) for each cell the index of its point closest to its mean; points outside cells have owner -1."""
    own = np.flatnonzero(owner >= 0)
    points = points[own]
    areas = areas[own]
    owner = owner[own]
    away = np.linalg.norm(points - _centroids(points, areas, owner, count)[owner], axis=1)
    order = np.lexsort((away, owner))
    return own[order[np.searchsorted(owner[order], np.arange(count))]]
