"""Any mesh made fit to be laid flat, with every change told and traceable to the file's own vertices and faces.

The user's triangles stay where they are; only their numbering changes. In order: vertices at one place become one;
faces that are a line, a point or a copy go; neighbours turn to agree about the outside; what meets in more than a
surface is taken apart; whole pieces turn outward; faces without area are flipped away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding, MeshError
from app.geometry.clean import distinct_faces, no_area, weld_tolerance, welded
from app.geometry.flat_faces import flip_flat_faces
from app.geometry.mesh import Mesh
from app.geometry.orient import inside_out, orient, turn
from app.geometry.split import glued_sides, pieces_of, split
from app.geometry.topology import edge_table

SMALLEST, LARGEST = 1e-12, 1e12
"""Sizes and coordinates [m] beyond which products of lengths would leave the range of numbers."""
_REMEDY = "Export it again in metres"


@dataclass(frozen=True, eq=False)
class Repaired:
    """A mesh fit to be laid flat, and the way back.

    Attributes:
        mesh: Every edge has one or two faces that agree about the outside, every vertex one fan, every face area; in
            the coordinates and the order of the file.
        vertex_of: (k,) the file's vertex behind each vertex.
        face_of: (m,) the file's face in whose plane each face lies.
        piece: (m,) the connected piece of each face, numbered from zero.
        welded: (w, 2) vertices of the file, and those at the same place that stand for them now.
        dropped: Faces of the file, rising, that are there no more: lines, points and copies.
        turned: Faces of the file, rising, whose corners run the other way now.
        findings: Each kind of repair, with its count.
    """

    mesh: Mesh
    vertex_of: IntArray
    face_of: IntArray
    piece: IntArray
    welded: IntArray
    dropped: IntArray
    turned: IntArray
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        for name in ("vertex_of", "face_of", "piece", "welded", "dropped", "turned"):
            object.__setattr__(self, name, readonly(getattr(self, name), np.int64))


def repair(mesh: Mesh, *, where: str = "mesh") -> Repaired:
    """Make ``mesh`` manifold, oriented and free of faces without area.

    Args:
        mesh: Any finite mesh, in any unit and at any offset.
        where: Its name, for findings and errors.

    Raises:
        MeshError: Nothing with area is left, or it is too large or too small for its areas to be numbers.

    Cost: about 5 µs a face, in however many pieces.
    """
    if not len(mesh.faces):
        raise no_area(mesh, where)
    work = _Repair(mesh, where)
    work.weld()
    work.drop_copies()
    work.orient()
    work.take_apart()
    work.turn_outward()
    work.flip_flat_faces()
    return work.result()


class _Repair:
    """A repair under way: ``faces`` (m, 3) into unit-sized ``vertices``, which stand for the file's ``vertex_of``.

    ``face_of``, ``piece`` and ``turned`` go with the faces: their numbers in the file, labels of connected pieces, and
    whether their corners run the other way now. ``closed`` (pieces,) says which have no border.
    """

    def __init__(self, mesh: Mesh, where: str) -> None:
        self._file, self._where, self._notes = mesh, where, list[Finding]()
        self.vertex_of, local = np.unique(mesh.faces, return_inverse=True)
        self.vertices, self.tolerance = _unit_sized(mesh, self.vertex_of, where)
        self.faces, self.face_of = local.reshape(-1, 3), np.arange(len(mesh.faces))
        self.piece = np.zeros(len(mesh.faces), dtype=np.int64)
        self.turned = np.zeros(len(mesh.faces), dtype=bool)
        self.closed = np.zeros(1, dtype=bool)
        self.welded = np.zeros((0, 2), dtype=np.int64)

    def weld(self) -> None:
        same = welded(self.vertices, self.tolerance)
        away = np.flatnonzero(same != np.arange(len(same)))
        self.welded, self.faces = self.vertex_of[np.stack([away, same[away]], axis=1)], same[self.faces]
        self._tell("duplicate-vertex", "welded", len(away))

    def drop_copies(self) -> None:
        a, b, c = self.faces.T
        whole = np.flatnonzero((a != b) & (b != c) & (c != a))
        first = whole[distinct_faces(self.faces[whole])]
        self._tell("zero-area-face", "dropped: corners at one place", len(self.faces) - len(whole))
        self._tell("duplicate-face", "dropped", len(whole) - len(first))
        self._keep(first)

    def orient(self) -> None:
        oriented = orient(self.faces, self._mesh().face_areas)
        self.faces, self.piece, self.turned = turn(self.faces, oriented.turned), oriented.piece, oriented.turned
        self._tell("one-sided", "cut where its two sides meet (edges)", oriented.clashes)

    def take_apart(self) -> None:
        table, glued = edge_table(self.faces), glued_sides(self.faces, self.piece)
        apart = (table.face_count > 1)[table.edge_of.ravel()]
        apart[glued.ravel()] = False
        ends = np.unique(table.edges[table.edge_of.ravel()[apart]])
        fans = np.bincount(self._split(glued), minlength=len(self.vertices))
        fans[ends] = 1  # those came apart with their edge
        held = np.bincount(self.piece[glued[:, 0] // 3], minlength=int(self.piece.max()) + 1)
        self.closed = 2 * held == 3 * np.bincount(self.piece)
        crowded = int((table.face_count > 2).sum())
        self._tell("non-manifold-edge", "taken apart: more than two faces met in it", crowded)
        self._tell("non-manifold-vertex", "taken apart: several fans of faces met in it", int((fans > 1).sum()))

    def turn_outward(self) -> None:
        mesh = self._mesh()
        area = np.bincount(self.piece, mesh.face_areas)
        kept = np.bincount(self.piece, np.where(self.turned, 0.0, mesh.face_areas)) / np.where(area > 0, area, 1.0)
        inverted = inside_out(mesh, self.piece, self.closed, kept)[self.piece]
        self.faces, self.turned = turn(self.faces, inverted), self.turned ^ inverted
        self._tell("turned-face", "turned to agree about the outside", int(self.turned.sum()))

    def flip_flat_faces(self) -> None:
        self.faces, owner, flat = flip_flat_faces(self.vertices, self.faces, self.tolerance)
        self._tell(
            "flat-face", "flipped away: the face behind it was split", int((owner != np.arange(len(owner))).sum())
        )
        self._tell("flat-face", "dropped", int(flat.sum()))
        self.face_of, self.turned = self.face_of[owner], self.turned[owner]
        if flat.any():
            self._keep(np.flatnonzero(~flat))
            glued = glued_sides(self.faces, self.piece)
            self._split(glued)
            self.piece = pieces_of(glued, len(self.faces))

    def result(self) -> Repaired:
        return Repaired(
            mesh=Mesh(self._file.vertices[self.vertex_of], self.faces),
            vertex_of=self.vertex_of,
            face_of=self.face_of,
            piece=self.piece,
            welded=self.welded,
            dropped=np.setdiff1d(np.arange(len(self._file.faces)), self.face_of),
            turned=np.unique(self.face_of[self.turned]),
            findings=tuple(self._notes),
        )

    def _mesh(self) -> Mesh:
        return Mesh(self.vertices, self.faces)

    def _keep(self, numbers: IntArray) -> None:
        """Keep the faces with these numbers only."""
        if not len(numbers):
            raise no_area(self._file, self._where)
        self.faces, self.face_of = self.faces[numbers], self.face_of[numbers]
        self.piece, self.turned = self.piece[numbers], self.turned[numbers]

    def _split(self, glued: IntArray) -> IntArray:
        """Give each fan its own vertices; returns which of the vertices before each is a copy of."""
        self.faces, copy_of = split(self.faces, glued)
        self.vertices, self.vertex_of = self.vertices[copy_of], self.vertex_of[copy_of]
        return copy_of

    def _tell(self, kind: str, action: str, count: int) -> None:
        if count:
            self._notes.append(Finding(kind, self._where, action, count))


def _unit_sized(mesh: Mesh, used: IntArray, where: str) -> tuple[FloatArray, float]:
    """The ``used`` vertices centred and divided by their extent, and the distance at which two of them are one."""
    vertices = mesh.vertices[used]
    largest = float(np.abs(vertices).max())
    if largest > LARGEST:
        raise MeshError("the mesh is absurdly large", file=where, value=f"{largest:.3g} m", remedy=_REMEDY)
    extent = float(np.linalg.norm(np.ptp(vertices, axis=0)))
    if extent == 0:
        raise no_area(mesh, where)
    if extent < SMALLEST:
        raise MeshError("the mesh is absurdly small", file=where, value=f"{extent:.3g} m", remedy=_REMEDY)
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    return (vertices - middle) / extent, weld_tolerance(vertices) / extent
