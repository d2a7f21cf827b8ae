"""Refinement of a mesh without a change of its shape.

``subdivide`` divides long edges into equal parts, and the faces between them. Each face is filled in rows from the
corner between its two longer sides to its shortest side. A needle becomes a ladder with two faces a rung, whereas
halving its edges repeatedly would make it as fine across as along.

``insert_vertices`` adds vertices at given points by splitting faces into three.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.point_location import owner_and_rank

MAX_FACES = 2_000_000


@dataclass(frozen=True, eq=False)
class SubdividedMesh(ArrayFields):
    """A finer mesh with the same shape.

    Attributes:
        mesh: Its first vertices are those of the coarse mesh, in their order.
        parent: (m,) face of the coarse mesh that contains each face, rising.
    """

    mesh: Mesh
    parent: IntArray


def subdivide(mesh: Mesh, *, longest: float) -> SubdividedMesh:
    """Divide edges into parts of at most ``longest`` [m]; neighbours share the new vertices, so no crack opens.

    New edges inside a face may be up to twice as long.

    Args:
        mesh: Any; edges with any number of faces. Returned unchanged when fine enough.
        longest: Above zero [m].

    Raises:
        MeshError: The result would have more than two million faces.

    Cost: about 0.5 µs per new face.
    """
    table = mesh.connectivity
    parts = _parts(mesh, longest)
    sides = np.sort(parts[table.edge_of], axis=1)
    if (2 * sides[:, 0] * sides[:, 2]).sum() > 2 * MAX_FACES:
        raise MeshError(
            "the mesh would have more than two million faces",
            value=f"edges of {longest:.3g} m on {mesh.area:.3g} m²",
            remedy="Ask for fewer taxels or a larger pitch",
        )
    if (parts == 1).all():
        return SubdividedMesh(mesh, np.arange(len(mesh.faces)))
    return _RowSubdivision(mesh, table, parts.astype(np.int64)).filled()


def subdivided_count(mesh: Mesh, *, longest: float) -> float:
    """Estimate the number of faces of ``subdivide``; exact if one edge of each face is not divided.

    Cost: 50 ns for each face of ``mesh``.
    """
    sides = np.sort(_parts(mesh, longest)[mesh.connectivity.edge_of], axis=1)
    return float((sides[:, 0] * (sides[:, 1] + sides[:, 2] - sides[:, 0])).sum())


def _parts(mesh: Mesh, longest: float) -> FloatArray:
    """Return the number of parts (e,) of each edge."""
    return np.maximum(np.ceil(mesh.edge_lengths / longest - 1e-9), 1.0)


class _RowSubdivision:
    """Rows of vertices across every face (a, b, c): row 0 is corner c, the last is side a-b with the fewest parts.

    Row j of n runs from side c-a to side c-b in ceil(j / n of the parts of a-b) steps, so each row has as many steps as
    the row above or one more.
    """

    def __init__(self, mesh: Mesh, table: Connectivity, parts: IntArray) -> None:
        self._mesh = mesh
        self._table = table
        self._parts = parts
        turn = (parts[table.edge_of].argmin(axis=1)[:, None] + np.arange(3)) % 3
        a, _, c = np.take_along_axis(mesh.faces, turn, axis=1).T
        ab, bc, ca = np.take_along_axis(table.edge_of, turn, axis=1).T
        self._first = len(mesh.vertices) + np.cumsum(parts - 1) - (parts - 1)  # number of each edge's first new vertex
        rows = np.maximum(parts[bc], parts[ca])
        self._face, row = owner_and_rank(rows + 1)
        count = rows[self._face]
        self._last = row == count
        self._steps = -(-row * parts[ab][self._face] // count)
        self._left = self._on_edge(ca[self._face], c[self._face], _rounded_quotient(row * parts[ca][self._face], count))
        self._right = self._on_edge(
            bc[self._face], c[self._face], _rounded_quotient(row * parts[bc][self._face], count)
        )
        self._base = ab[self._face]
        self._start = a[self._face]
        inner = np.where(self._last, 0, np.maximum(self._steps - 1, 0))
        self._inner = len(mesh.vertices) + int((parts - 1).sum()) + np.cumsum(inner) - inner
        self._inner_counts = inner

    def filled(self) -> SubdividedMesh:
        top = np.flatnonzero(~self._last)
        strip, k = owner_and_rank(self._steps[top + 1])
        upper = top[strip]
        lower_faces = np.stack([self._at(upper + 1, k), self._at(upper + 1, k + 1), self._at(upper, k)], axis=1)
        parent = self._face[upper]
        strip, k = owner_and_rank(self._steps[top])
        upper = top[strip]
        upper_faces = np.stack([self._at(upper, k + 1), self._at(upper, k), self._at(upper + 1, k + 1)], axis=1)
        faces = np.concatenate([lower_faces, upper_faces])
        parent = np.concatenate([parent, self._face[upper]])
        # Two rows may end in the same vertex of a side with fewer parts than rows.
        whole = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        order = np.flatnonzero(whole)[np.argsort(parent[whole], kind="stable")]
        return SubdividedMesh(Mesh(self._vertices(), faces[order]), parent[order])

    def _vertices(self) -> FloatArray:
        vertices = self._mesh.vertices
        edge = np.repeat(np.arange(len(self._parts)), self._parts - 1)
        share = (owner_and_rank(self._parts - 1)[1] + 1) / self._parts[edge]
        on_edges = _interpolated(vertices[self._table.edges[edge, 0]], vertices[self._table.edges[edge, 1]], share)
        vertices = np.concatenate([vertices, on_edges])
        row, k = owner_and_rank(self._inner_counts)
        inside = _interpolated(vertices[self._left[row]], vertices[self._right[row]], (k + 1) / self._steps[row])
        return np.concatenate([vertices, inside])

    def _at(self, row: IntArray, k: IntArray) -> IntArray:
        """Return vertex ``k`` of each ``row``."""
        inner = np.where(self._last[row], self._on_edge(self._base[row], self._start[row], k), self._inner[row] + k - 1)
        return np.where(k == 0, self._left[row], np.where(k == self._steps[row], self._right[row], inner))

    def _on_edge(self, edge: IntArray, start: IntArray, k: IntArray) -> IntArray:
        """Return vertex ``k`` of ``edge``, counted from its end ``start``."""
        low, high = self._table.edges[edge].T
        parts = self._parts[edge]
        along = np.where(start == low, k, parts - k)  # counted from the edge's smaller vertex
        inner = self._first[edge] + along - 1
        return np.where(along == 0, low, np.where(along == parts, high, inner))


def _rounded_quotient(numerator: IntArray, denominator: IntArray) -> IntArray:
    """Return the fractions rounded to integers."""
    return (2 * numerator + denominator) // (2 * denominator)


def _interpolated(start: FloatArray, end: FloatArray, share: FloatArray) -> FloatArray:
    return start + share[:, None] * (end - start)


CORNER_SNAP = 2e-3
"""Distance from a corner, as a share of the face, below which a point is moved to that corner."""
SIDE_INSET = 1e-3
"""Share of the face by which a point on a side is moved inwards, so that it does not cut off a face without area."""


def insert_vertices(surface: Mesh, faces: IntArray, weights: FloatArray) -> tuple[Mesh, IntArray]:
    """Insert a vertex at each of ``faces`` (k,), ``weights`` (k, 3). Return the mesh and the vertices (k,).

    Each round splits every face that still contains a point into three at one of its points; its other points are then
    in one of the three. Points at the same position share a vertex. A point moves at most ``CORNER_SNAP`` of its face.

    Args:
        surface: Its vertices keep their numbers; new ones follow.
        faces: Triangle of each point.
        weights: Barycentric, not negative.

    Cost: one round per point of the fullest face; 2 ms for 1000 points on 10,000 faces.
    """
    vertices = [surface.vertices]
    triangles = surface.faces.copy()
    face = faces.copy()
    weight = weights.copy()
    vertex_of = np.full(len(faces), -1, dtype=np.int64)
    count = len(surface.vertices)
    while True:
        open_ = vertex_of < 0
        at_corner = open_ & (weight.max(axis=1) >= 1 - CORNER_SNAP)
        vertex_of[at_corner] = triangles[face[at_corner], weight[at_corner].argmax(axis=1)]
        waiting = np.flatnonzero(open_ & ~at_corner)
        if not len(waiting):
            return Mesh(np.concatenate(vertices), triangles), vertex_of
        split, first = np.unique(face[waiting], return_index=True)
        chosen = waiting[first]
        middle = np.maximum(weight[chosen], SIDE_INSET)
        middle /= middle.sum(axis=1, keepdims=True)
        corners = triangles[split]
        vertices.append(np.einsum("kc,kcd->kd", middle, np.concatenate(vertices)[corners]))
        new = count + np.arange(len(chosen))
        count = count + len(chosen)
        vertex_of[chosen] = new
        children = _child_numbers(split, len(triangles))
        triangles = _split_faces(triangles, split, new)
        others = np.setdiff1d(waiting, chosen)
        number = np.searchsorted(split, face[others])
        side, weight[others] = _child_weights(weight[others], middle[number])
        face[others] = children[number, side]


def _child_numbers(split: IntArray, count: int) -> IntArray:
    """Return the numbers (s, 3) of the faces opposite corner 0, 1 and 2; the last keeps the old number."""
    after = count + np.arange(2 * len(split))
    return np.stack([after[: len(split)], after[len(split) :], split], axis=1)


def _split_faces(triangles: IntArray, split: IntArray, new: IntArray) -> IntArray:
    a, b, c = triangles[split].T
    triangles = triangles.copy()
    triangles[split] = np.stack([a, b, new], axis=1)
    return np.concatenate([triangles, np.stack([b, c, new], axis=1), np.stack([c, a, new], axis=1)])


def _child_weights(weights: FloatArray, middle: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the child (k,) and the weights in it of points with ``weights`` (k, 3) in faces split at ``middle``."""
    ratio = weights / middle
    side = ratio.argmin(axis=1)
    row = np.arange(len(side))
    share = ratio[row, side]
    rest = weights - share[:, None] * middle
    return side, np.stack([rest[row, (side + 1) % 3], rest[row, (side + 2) % 3], share], axis=1)
