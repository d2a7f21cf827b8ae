"""Coarser surfaces of a mesh for drawing: fewer triangles of the same vertices, each with how far it is from the mesh.

Vertices are collapsed into a neighbour, the one nearest to the planes that meet in both (Garland and Heckbert 1997,
with planes weighted by the angle at the vertex, so that many slivers count as the one face that they make). In a round
all those collapse at once of which no two are neighbours. That is a map of vertices onto vertices: a closed surface
stays closed, and each vertex left keeps its place. No triangle may turn over. What is thinner than the tolerance may
become flat: two triangles of the same corners, each seen from its own side.

Our own, since links must stay closed (their backs are not drawn): VTK's decimations and libigl's open them, leave 15 of
iCub's 39 links as they are, or go 2 to 8 mm off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.geometry.surface.closest_point import ClosestPoint, closest_point
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh

_LEAST_TURN = 0.3
"""Cosine between a triangle's normals before and after a collapse: below it has turned over."""
_ROUNDS = 60
_IDLE = 0.004
"""At most so many rounds a level; fewer once a round takes less than this share of the faces."""
_CHEAP = 1e-4
"""Costs below this share of the largest allowed are alike: else few vertices would be the cheapest of their kind."""
_SHORT = 1e-3
"""So much of the squared way counts too: on what is flat all ways cost nothing, and short ones leave no slivers."""
_ROW, _COLUMN = np.triu_indices(4)
_TWICE = np.where(_ROW == _COLUMN, 1.0, 2.0)


@dataclass(frozen=True, eq=False)
class CoarseSurface:
    """Fewer triangles of a mesh's own vertices.

    Attributes:
        faces: (m, 3) indices into the mesh's vertices.
        error: The largest distance between both surfaces, of the corners, middles of edges and centroids of either
            from the other [m].
    """

    faces: IntArray
    error: float

    def __post_init__(self) -> None:
        freeze_arrays(self, "faces", dtype=np.int64, columns=3)


def simplify(mesh: Mesh, tolerances: Sequence[float]) -> tuple[CoarseSurface, ...]:
    """A coarser surface for each tolerance [m], rising; its error is about that, and may be more: it is measured.

    A closed mesh stays closed. Coarser ones than the last may be missing: nothing of a small mesh would be left.

    Cost: about 80 µs a face for four tolerances, two thirds of it to measure them.
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
    """Some triangles (m, 3) of a mesh's vertices as a mesh of its own, and (k,) the vertices that it uses."""
    used, local = np.unique(faces, return_inverse=True)
    return Mesh(mesh.vertices[used], local.reshape(-1, 3)), used


def _normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """(m, 3) unit, or 0 for a face without area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 0)


def _planes(normals: FloatArray, points: FloatArray) -> FloatArray:
    """(m, 10) squared distance from planes through points (m, 3), as the upper half of a form on (x, y, z, 1)."""
    plane = np.column_stack([normals, -np.einsum("ij,ij->i", normals, points)])
    return plane[:, _ROW] * plane[:, _COLUMN]


def _quadrics(vertices: FloatArray, mesh: Mesh) -> FloatArray:
    """(n, 10) summed squared distance from the planes that meet in each vertex."""
    faces = mesh.faces
    normals = _normals(vertices, mesh.faces)
    total = np.zeros((len(vertices), 10))
    own = _planes(normals, vertices[faces[:, 0]])
    for k in range(3):
        along, across = (vertices[faces[:, (k + j) % 3]] - vertices[faces[:, k]] for j in (1, 2))
        angle = np.arctan2(np.linalg.norm(np.cross(along, across), axis=1), np.einsum("ij,ij->i", along, across))
        np.add.at(total, faces[:, k], own * (2 / np.pi * angle)[:, None])
    # At a border, and where a thin edge folds back, the planes alone would let the surface shrink: one stands there.
    twins = mesh.connectivity.twins
    folded = np.einsum("ij,ij->i", normals[twins[:, 0] // 3], normals[twins[:, 1] // 3]) < 0
    sides = np.concatenate([mesh.connectivity.boundary_sides, twins[folded].ravel()])
    start = faces.ravel()[sides]
    end = faces.ravel()[sides - sides % 3 + (sides + 1) % 3]
    aside = np.cross(vertices[end] - vertices[start], normals[sides // 3])
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    upright = _planes(aside, vertices[start])
    np.add.at(total, start, upright)
    np.add.at(total, end, upright)
    return total


def _collapse(vertices: FloatArray, faces: IntArray, quadrics: FloatArray, tolerance: float) -> IntArray:
    """The faces that remain; ``quadrics`` take those of the vertices that went into theirs."""
    count = len(vertices)
    refused = np.zeros(0, np.int64)
    mixed = 0.5 + (np.arange(count) * 2654435761 % 2**32) / 2**32  # no order of the vertices decides who is cheapest
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
        refused = refused[~changed[refused // count]]  # around those it may be otherwise now
        a, b, c = moved.T
        faces = moved[(a != b) & (b != c) & (c != a)]
        if not len(gone) + len(wrong) or (number > 8 and len(gone) < _IDLE * len(faces)):
            break
    return faces


def _cheapest(
    vertices: FloatArray, quadrics: FloatArray, pairs: IntArray, tolerance: float, count: int
) -> tuple[IntArray, FloatArray]:
    """(n,) into which neighbour each vertex goes at the least cost, and (n,) that; infinite above the tolerance.

    ``pairs`` are ``count`` times the vertex that goes, and its neighbour.
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
    """Vertices that must stay, since a triangle around them would turn over; rising."""
    moved = into[faces]
    touched = np.flatnonzero((moved != faces).any(axis=1))
    old = faces[touched]
    new = moved[touched]
    a, b, c = new.T
    before = _normals(vertices, old)
    after = _normals(vertices, new)
    turned = (np.einsum("ij,ij->i", before, after) < _LEAST_TURN) & before.any(axis=1)
    turned &= (a != b) & (b != c) & (c != a)
    owner = old[np.arange(len(old)), (new != old).argmax(axis=1)]
    return np.unique(owner[turned])


def _distance(mesh: Mesh, faces: IntArray) -> float:
    """The largest distance between a mesh and triangles (m, 3) of its vertices, both ways [m]."""
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
    """(k, 3) centroids and middles of the edges of some faces."""
    corners = mesh.vertices[mesh.faces[which]]
    edges = mesh.vertices[mesh.edges[np.unique(mesh.connectivity.edge_of[which])]]
    return np.concatenate([corners.mean(axis=1), edges.mean(axis=1)])
