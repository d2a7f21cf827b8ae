"""Simplification of a mesh for drawing: fewer triangles over the same vertices, with a measured error.

Vertices are collapsed into the neighbour with the smallest distance from the planes that meet in both (Garland and
Heckbert 1997; planes are weighted by the angle at the vertex, so that many slivers count as the one face they form).
Each round collapses all vertices of which no two are neighbours. This maps vertices onto vertices: a closed surface
stays closed, and each remaining vertex keeps its position. No triangle may turn over. Parts thinner than the tolerance
may become flat: two triangles over the same corners, one for each side.

Own implementation because links must stay closed (back faces are not drawn): the decimations of VTK and libigl open
them, leave 15 of iCub's 39 links unchanged, or deviate by 2 to 8 mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.closest_point import ClosestPoint, closest_point
from tactile_maps.geometry.surface.connectivity import Connectivity, remove_unreferenced, side_ends
from tactile_maps.geometry.surface.mesh import Mesh

_LEAST_TURN = 0.3
"""Cosine between a triangle's normals before and after a collapse below which it counts as turned over."""
_ROUNDS = 60
_IDLE = 0.004
"""Share of faces; a level ends when a round removes less, or after ``_ROUNDS`` rounds."""
_CHEAP = 1e-4
"""Costs below this share of the largest allowed count as equal, so that more vertices are cheapest among neighbours."""
_SHORT = 1e-3
"""Share of the squared edge length in the cost: on flat parts short edges are preferred, which leaves no slivers."""
_ROW, _COLUMN = np.triu_indices(4)
_TWICE = np.where(_ROW == _COLUMN, 1.0, 2.0)


@dataclass(frozen=True, eq=False)
class CoarseSurface(ArrayFields, faces=3):
    """Fewer triangles of a mesh's own vertices.

    Attributes:
        faces: (m, 3) indices into the mesh's vertices.
        error: Largest distance [m] between the surfaces, measured at the corners, edge midpoints and centroids of both.
    """

    faces: IntArray
    error: float


def simplify(mesh: Mesh, tolerances: Sequence[float]) -> tuple[CoarseSurface, ...]:
    """Return a coarser surface for each tolerance [m], rising. The measured error may exceed the tolerance.

    A closed mesh stays closed. The last surfaces are missing if nothing of a small mesh would be left.

    Cost: about 80 µs a face for four tolerances, two thirds of it for the measurement.
    """
    vertices = mesh.vertices - mesh.vertices.mean(axis=0)
    faces = mesh.faces
    quadrics = _quadrics(vertices, mesh)
    found = list[CoarseSurface]()
    for tolerance in tolerances:
        faces = _collapse(vertices, faces, quadrics, tolerance)
        if not len(faces):
            break
        found.append(CoarseSurface(faces, _distance(mesh, faces)))
    return tuple(found)


def coarse_mesh(mesh: Mesh, faces: IntArray) -> tuple[Mesh, IntArray]:
    """Return triangles (m, 3) over a mesh's vertices as a separate mesh, and the vertices (k,) they use."""
    local, used = remove_unreferenced(faces)
    return Mesh(mesh.vertices[used], local), used


def _planes(normals: FloatArray, points: FloatArray) -> FloatArray:
    """Return squared distances from planes through points (m, 3): the upper half (m, 10) of forms on (x, y, z, 1)."""
    plane = np.column_stack([normals, -np.einsum("ij,ij->i", normals, points)])
    return plane[:, _ROW] * plane[:, _COLUMN]


def _quadrics(vertices: FloatArray, mesh: Mesh) -> FloatArray:
    """Return the summed squared distance (n, 10) from the planes that meet in each vertex."""
    faces = mesh.faces
    normals = Mesh(vertices, faces).face_normals
    total = np.zeros((len(vertices), 10))
    own = _planes(normals, vertices[faces[:, 0]])
    for k in range(3):
        along, across = (vertices[faces[:, (k + j) % 3]] - vertices[faces[:, k]] for j in (1, 2))
        angle = np.arctan2(np.linalg.norm(np.cross(along, across), axis=1), np.einsum("ij,ij->i", along, across))
        np.add.at(total, faces[:, k], own * (2 / np.pi * angle)[:, None])
    # At borders and folded thin edges the planes alone would let the surface shrink; a perpendicular plane prevents it.
    twins = mesh.connectivity.twins
    folded = np.einsum("ij,ij->i", normals[twins[:, 0] // 3], normals[twins[:, 1] // 3]) < 0
    sides = np.concatenate([mesh.connectivity.boundary_sides, twins[folded].ravel()])
    start = faces.ravel()[sides]
    end = faces.ravel()[side_ends(sides)]
    aside = np.cross(vertices[end] - vertices[start], normals[sides // 3])
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    upright = _planes(aside, vertices[start])
    np.add.at(total, start, upright)
    np.add.at(total, end, upright)
    return total


def _collapse(vertices: FloatArray, faces: IntArray, quadrics: FloatArray, tolerance: float) -> IntArray:
    """Return the remaining faces; ``quadrics`` of collapsed vertices are added to those of their targets."""
    count = len(vertices)
    refused = np.zeros(0, np.int64)
    mixed = 0.5 + (np.arange(count) * 2654435761 % 2**32) / 2**32  # the order of the vertices must not break ties
    for number in range(_ROUNDS):
        edges = Connectivity(faces).edges
        pairs = np.sort(np.concatenate([edges @ [count, 1], edges @ [1, count]]))
        into, cost = _cheapest(vertices, quadrics, pairs[~np.isin(pairs, refused)], tolerance, count)
        cost = np.maximum(cost, _CHEAP * tolerance**2) * mixed
        around = np.full(count, np.inf)
        np.minimum.at(around, pairs // count, cost[pairs % count])
        into = np.where(cost < around, into, np.arange(count))
        wrong = _turned_over(vertices, faces, into)
        refused = np.union1d(refused, wrong * count + into[wrong])
        into[wrong] = wrong
        gone = np.flatnonzero(into != np.arange(count))
        np.add.at(quadrics, into[gone], quadrics[gone])
        moved = into[faces]
        changed = np.zeros(count, bool)
        changed[faces[(moved != faces).any(axis=1)]] = True
        refused = refused[~changed[refused // count]]  # may be allowed now that neighbouring faces changed
        a, b, c = moved.T
        faces = moved[(a != b) & (b != c) & (c != a)]
        if not len(gone) + len(wrong) or (number > 8 and len(gone) < _IDLE * len(faces)):
            break
    return faces


def _cheapest(
    vertices: FloatArray, quadrics: FloatArray, pairs: IntArray, tolerance: float, count: int
) -> tuple[IntArray, FloatArray]:
    """Return the cheapest target (n,) of each vertex and its cost (n,), infinite above the tolerance.

    ``pairs`` are ``count`` times the collapsed vertex plus its neighbour.
    """
    start, end = np.divmod(pairs, count)
    place = np.column_stack([vertices[end], np.ones(len(end))])
    squared = np.maximum(np.einsum("ij,ij->i", quadrics[start] * _TWICE, place[:, _ROW] * place[:, _COLUMN]), 0.0)
    allowed = squared <= tolerance**2
    start = start[allowed]
    end = end[allowed]
    away = vertices[end] - vertices[start]
    squared = squared[allowed] + _SHORT * np.einsum("ij,ij->i", away, away)
    order = np.lexsort((squared, start))
    start = start[order]
    end = end[order]
    squared = squared[order]
    first = np.flatnonzero(np.diff(start, prepend=-1))
    into = np.arange(count)
    cost = np.full(count, np.inf)
    into[start[first]] = end[first]
    cost[start[first]] = squared[first]
    return into, cost


def _turned_over(vertices: FloatArray, faces: IntArray, into: IntArray) -> IntArray:
    """Return the vertices, rising, whose collapse would turn over a triangle around them."""
    moved = into[faces]
    touched = np.flatnonzero((moved != faces).any(axis=1))
    old = faces[touched]
    new = moved[touched]
    a, b, c = new.T
    before = Mesh(vertices, old).face_normals
    after = Mesh(vertices, new).face_normals
    turned = (np.einsum("ij,ij->i", before, after) < _LEAST_TURN) & before.any(axis=1)
    turned &= (a != b) & (b != c) & (c != a)
    owner = old[np.arange(len(old)), (new != old).argmax(axis=1)]
    return np.unique(owner[turned])


def _distance(mesh: Mesh, faces: IntArray) -> float:
    """Return the largest distance [m] between a mesh and triangles (m, 3) over its vertices, in both directions."""
    coarse, used = coarse_mesh(mesh, faces)
    base = len(mesh.vertices)
    theirs, ours = ((np.sort(part, axis=1) @ [base * base, base, 1]) for part in (mesh.faces, faces))
    gone = ~np.isin(theirs, ours)
    lost = np.ones(base, bool)
    lost[used] = False
    away = ClosestPoint(coarse).query(np.concatenate([mesh.vertices[lost], _samples(mesh, gone)]))[2]
    back = closest_point(mesh).query(_samples(coarse, ~np.isin(ours, theirs)))[2]
    return float(max(away.max(initial=0.0), back.max(initial=0.0)))


def _samples(mesh: Mesh, which: BoolArray) -> FloatArray:
    """Return the centroids and edge midpoints (k, 3) of the faces ``which``."""
    corners = mesh.vertices[mesh.faces[which]]
    edges = mesh.vertices[mesh.edges[np.unique(mesh.connectivity.edge_of[which])]]
    return np.concatenate([corners.mean(axis=1), edges.mean(axis=1)])
