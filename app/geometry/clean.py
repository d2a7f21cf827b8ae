"""What a mesh from a file needs before native code may see it: no empty, no zero-area, no duplicate faces."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.errors import Finding, MeshError
from app.geometry.mesh import Mesh
from app.geometry.topology import compact

RELATIVE_WELD = 1e-7
"""Vertices closer than this share of the mesh's size are one; float32 files round at about this level."""


def clean(mesh: Mesh, *, where: str = "mesh") -> tuple[Mesh, tuple[Finding, ...]]:
    """Weld equal vertices, drop faces that enclose no area or stand twice, drop unused vertices.

    Args:
        mesh: Any finite mesh.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left.
    """
    vertices, faces, notes = mesh.vertices, mesh.faces, []
    if len(faces) and mesh.size > 0:
        vertices, inverse = _welded(mesh)
        flat = Mesh(vertices, inverse[faces]).face_areas <= (RELATIVE_WELD * mesh.size) ** 2
        distinct = inverse[faces][~flat]
        kept, _ = _distinct_rows(np.sort(distinct, axis=1))
        notes = [
            Finding("duplicate-vertex", where, "welded", len(mesh.vertices) - len(vertices)),
            Finding("zero-area-face", where, "dropped", int(flat.sum())),
            Finding("duplicate-face", where, "dropped", len(distinct) - len(kept)),
        ]
        faces = distinct[np.sort(kept)]
    if not len(faces) or mesh.size == 0:
        value, remedy = f"{len(mesh.faces)} faces", "Export it again with triangles"
        raise MeshError("the mesh has no face with an area", file=where, value=value, remedy=remedy)
    faces, used = compact(faces)
    return Mesh(vertices[used], faces), tuple(note for note in notes if note.count)


def _welded(mesh: Mesh) -> tuple[FloatArray, IntArray]:
    """The distinct vertices, and which of them each vertex is."""
    # Rounding to a grid after centring welds what a file wrote twice; a far offset must not eat the digits.
    cells = np.round((mesh.vertices - mesh.vertices.mean(axis=0)) / (RELATIVE_WELD * mesh.size))
    first, inverse = _distinct_rows(cells)
    return mesh.vertices[first], inverse


def _distinct_rows(rows: FloatArray | IntArray) -> tuple[IntArray, IntArray]:
    """The first row of each kind, and the kind of each row; kinds in sorted order."""
    order = np.lexsort(rows.T[::-1])
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind
