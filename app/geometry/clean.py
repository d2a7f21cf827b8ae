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
    size = mesh.size
    faces, findings = mesh.faces, []
    vertices = mesh.vertices
    if len(faces) and size > 0:
        # Rounding to a grid after centring welds what a file wrote twice; a far offset must not eat the digits.
        cells = np.round((vertices - vertices.mean(axis=0)) / (RELATIVE_WELD * size))
        first, inverse = _distinct_rows(cells)
        if len(first) < len(vertices):
            findings.append(Finding("duplicate-vertex", where, "welded", len(vertices) - len(first)))
        vertices, faces = vertices[first], inverse[faces]
        area = Mesh(vertices, faces).face_areas
        flat = area <= (RELATIVE_WELD * size) ** 2
        if flat.any():
            findings.append(Finding("zero-area-face", where, "dropped", int(flat.sum())))
        faces = faces[~flat]
        kept, _ = _distinct_rows(np.sort(faces, axis=1))
        if len(kept) < len(faces):
            findings.append(Finding("duplicate-face", where, "dropped", len(faces) - len(kept)))
        faces = faces[np.sort(kept)]
    if not len(faces) or size == 0:
        raise MeshError("the mesh has no face with an area", file=where, value=f"{len(mesh.faces)} faces",
                        remedy="Export it again with triangles")
    faces, used = compact(faces)
    return Mesh(vertices[used], faces), tuple(findings)


def _distinct_rows(rows: FloatArray | IntArray) -> tuple[IntArray, IntArray]:
    """The first row of each kind, and the kind of each row; kinds in sorted order."""
    order = np.lexsort(rows.T[::-1])
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[order[1:]] != rows[order[:-1]]).any(axis=1)
    kind = np.empty(len(rows), dtype=np.int64)
    kind[order] = np.cumsum(new) - 1
    return order[new], kind
