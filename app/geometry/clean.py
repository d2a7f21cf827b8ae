"""What a mesh from a file needs before native code may see it: no empty, no zero-area, no duplicate faces."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray
from app.errors import Finding, MeshError
from app.geometry.mesh import Mesh
from app.geometry.topology import compact

RELATIVE_WELD = 1e-7
"""Vertices closer than this share of the mesh's size are one; float32 files round at about this level."""
_ROUNDING = 4 * np.finfo(np.float64).eps


def clean(mesh: Mesh, *, where: str = "mesh") -> tuple[Mesh, tuple[Finding, ...]]:
    """Weld equal vertices, drop faces that enclose no area or stand twice, drop unused vertices.

    Enough for what only looks at a surface (a wrap, rays, closest points); what is laid flat needs ``repair``.

    Args:
        mesh: Any finite mesh.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left.
    """
    vertices, faces, notes = mesh.vertices, mesh.faces, []
    if len(faces) and mesh.size > 0:
        tolerance = weld_tolerance(mesh.vertices)
        same = welded(mesh.vertices, tolerance)
        flat = Mesh(vertices, same[faces]).face_areas <= tolerance**2
        whole = same[faces][~flat]
        kept = distinct_faces(whole)
        notes = [
            Finding("duplicate-vertex", where, "welded", int((same != np.arange(len(same))).sum())),
            Finding("zero-area-face", where, "dropped", int(flat.sum())),
            Finding("duplicate-face", where, "dropped", len(whole) - len(kept)),
        ]
        faces = whole[kept]
    if not len(faces) or mesh.size == 0:
        raise no_area(mesh, where)
    faces, used = compact(faces)
    return Mesh(vertices[used], faces), tuple(note for note in notes if note.count)


def no_area(mesh: Mesh, where: str) -> MeshError:
    """The error for a mesh of which nothing can be used."""
    value, remedy = f"{len(mesh.faces)} faces", "Export it again with triangles"
    return MeshError("the mesh has no face with an area", file=where, value=value, remedy=remedy)


def weld_tolerance(vertices: FloatArray) -> float:
    """Distance [m] below which two of ``vertices`` (n, 3) are one: a share of their extent, or rounding far away."""
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    return max(RELATIVE_WELD * extent, _ROUNDING * float(np.abs(vertices).max()))


def welded(vertices: FloatArray, tolerance: float) -> IntArray:
    """(n,) the first of all vertices that are one with each, for vertices (n, 3) and ``tolerance`` > 0.

    All within the tolerance are one, chains of them too; some up to twice as far apart may be.
    """
    # A fine grid first, so that the search tree has few points even where a file repeats each of them many times.
    # Centred, so that a far offset does not eat the digits.
    cell = tolerance / 4
    first, kind = _distinct_rows(np.rint((vertices - vertices.mean(axis=0)) / cell))
    reach = tolerance + 2 * np.sqrt(3) * cell  # each vertex is up to a cell's diagonal from its cell's first
    pairs = cKDTree(vertices[first]).query_pairs(reach, output_type="ndarray")
    if len(pairs):
        graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(first),) * 2)
        count, group = connected_components(graph, directed=False)
        lowest = np.full(count, len(vertices))
        np.minimum.at(lowest, group, first)
        first = lowest[group]
    return np.asarray(first[kind], dtype=np.int64)


def distinct_faces(faces: IntArray) -> IntArray:
    """Numbers, rising, of the first face on each set of three corners, whichever way it turns."""
    return np.sort(_distinct_rows(np.sort(faces, axis=1))[0])


def _distinct_rows(rows: FloatArray | IntArray) -> tuple[IntArray, IntArray]:
    """The first row of each kind, and the kind of each row; kinds in sorted order."""
    order = np.lexsort(rows.T[::-1])
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind
