"""A skin from taxels alone: no robot, no mesh, only places in a link's frame.

A surface is laid through the taxels, or the file's own is taken if it is sound; each connected piece is a patch. A rim
of half a spacing around it gives the outermost taxels their share of area, as one taxel, a pair or a row get all of
theirs. Each triangle is cut by its medians into six, two for each corner: so a taxel answers for the sixth parts that
touch it, a third of every triangle, and feels with about a dozen points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops, bow_tie_vertices, edge_table, face_components
from app.skin.exchange.taxel_set import TaxelSet
from app.skin.normals import estimate_normals
from app.skin.pieces import piece_name
from app.skin.place import taxels_in
from app.skin.rim import grow_rim
from app.skin.skin import Patch, Skin
from app.skin.taxels import Taxels
from app.skin.triangulate import LONGEST, Triangulated, spacings, triangulate

SAME_PLACE = 1e-5
"""Taxels closer than this [m] are one: files state tenths of a millimetre."""
LONE_RADIUS = 0.003
"""A taxel with no other to measure by feels this far around itself [m]."""
_OPPOSITE = 0.7
_THINNEST = 1e-6
"""A stated face with less area than this share of its longest side squared is a line."""


@dataclass(frozen=True, eq=False)
class SkinOfTaxels:
    """A skin, and which of its taxels stands for which of the set's.

    Attributes:
        skin: One link; its patches are the connected pieces, that with the most taxels first.
        taxel_of: (n,) number in the skin of each taxel of the set; taxels at one place have one number.
    """

    skin: Skin
    taxel_of: IntArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "taxel_of", readonly(self.taxel_of, np.int64))


def skin_from_taxels(taxels: TaxelSet) -> Skin:
    """The skin of ``build_skin``, for those who need not know which taxel is which."""
    return build_skin(taxels).skin


def build_skin(taxels: TaxelSet) -> SkinOfTaxels:
    """Make the skin that ``taxels`` alone describe.

    Taxels at one place become one. Those that no surface reaches (too few, or in a row) get a strip or a small disk of
    their own, and a finding says so: every taxel is on the skin.

    Cost: 0.2 s for 1000 taxels.
    """
    first, kind = _places(taxels.positions)
    notes = [*taxels.findings]
    _note(notes, "duplicate-taxel", taxels.name, "merged with another at the same place", len(kind) - len(first))
    joined = _surface(taxels, first, kind, notes)
    coarse, owner = _widened(joined, taxels.name, notes)
    surface, feels = _cut_by_medians(coarse, owner)
    link, pieces = taxels.link or "skin", _pieces(surface, feels)
    patches = [
        Patch(piece_name(taxels.name, number), link, *_patch(surface, feels, own, faces))
        for number, (own, faces) in enumerate(pieces)
    ]
    place = np.empty(len(first), dtype=np.int64)
    place[np.concatenate([own for own, _ in pieces])] = np.arange(len(first))
    return SkinOfTaxels(Skin(tuple(patches), tuple(notes)), place[kind])


def _note(notes: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    if count:
        notes.append(Finding(kind, where, action, count))


def _places(positions: FloatArray) -> tuple[IntArray, IntArray]:
    """The first taxel at each place, in their order, and (n,) the place of each taxel."""
    pairs = cKDTree(positions).query_pairs(SAME_PLACE, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(positions),) * 2)
    group = connected_components(graph, directed=False)[1]
    first = np.unique(group, return_index=True)[1]
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.sort(first), rank[group]


def _surface(taxels: TaxelSet, first: IntArray, kind: IntArray, notes: list[Finding]) -> Triangulated:
    """The set's own faces if they make a sound surface, else new ones."""
    positions, where = taxels.positions[first], taxels.name
    normals = None if taxels.normals is None else taxels.normals[first]
    if taxels.faces is not None and len(taxels.faces):
        stated = Mesh(positions, kind[taxels.faces])
        problem = _unsound(stated)
        if problem is None:
            return _stated_surface(stated, normals, where, notes)
        _note(notes, "unsound-faces", where, f"the stated faces are not used: {problem}", len(taxels.faces))
    joined = triangulate(positions, normals=normals, where=where)
    notes.extend(joined.findings)
    return joined


def _stated_surface(stated: Mesh, normals: FloatArray | None, where: str, notes: list[Finding]) -> Triangulated:
    """The file's own surface, turned if nearly all of its normals, where there are any, look to its other side."""
    if normals is not None and (stated.vertex_normals * normals).sum() < -_OPPOSITE * len(normals):
        _note(notes, "turned-face", where, "turned to look where the normals look", len(stated.faces))
        stated = Mesh(stated.vertices, stated.faces[:, ::-1])
    own = stated.vertex_normals
    used = own.any(axis=1, keepdims=True)
    beside = own if used.all() else np.where(used, own, estimate_normals(stated.vertices, stated=own).normals)
    return Triangulated(stated, beside, spacings(stated.vertices), ())


def _unsound(mesh: Mesh) -> str | None:
    """Why faces over taxels make no surface, or None."""
    sides = mesh.vertices[mesh.faces] - mesh.vertices[np.roll(mesh.faces, -1, axis=1)]
    if (mesh.face_areas <= _THINNEST * (sides**2).sum(axis=2).max(axis=1)).any():
        return "some have no area"
    if edge_table(mesh.faces).face_count.max() > 2:
        return "more than two meet in an edge"
    directed = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if len(np.unique(directed, axis=0)) < len(directed):
        return "neighbours look to different sides"
    if len(bow_tie_vertices(mesh.faces)):
        return "several fans meet in a taxel"
    return None


def _widened(joined: Triangulated, where: str, notes: list[Finding]) -> tuple[Mesh, IntArray]:
    """The surface with its rims, and (vertices,) the taxel that each vertex belongs to."""
    positions, faces = joined.mesh.vertices, [joined.mesh.faces]
    lone = np.setdiff1d(np.arange(len(positions)), joined.mesh.faces)
    rows = _rows(positions, lone)
    single = sum(len(row) == 1 for row in rows)
    _note(notes, "lone-taxel", where, "no surface reaches it: given a small disk of its own", single)
    _note(notes, "taxel-row", where, "in a straight row: given a strip of its own", len(rows) - single)
    walks = boundary_loops(joined.mesh.faces) if len(joined.mesh.faces) else []
    walks += [np.concatenate([row, row[-2:0:-1]]) for row in rows]
    vertices, owner, width = [positions], [np.arange(len(positions))], _widths(positions)
    for walk in walks:
        rim = grow_rim(positions, joined.normals, width, walk, first=sum(map(len, vertices)))
        vertices.append(rim.vertices)
        owner.append(rim.taxel)
        faces.append(rim.faces)
    return Mesh(np.concatenate(vertices), np.concatenate(faces)), np.concatenate(owner)


def _widths(positions: FloatArray) -> FloatArray:
    """(n,) how far each taxel feels beyond the border [m]: half the way to the taxels beside it."""
    k = min(2, len(positions) - 1)
    if k == 0:
        return np.full(1, LONE_RADIUS)
    near = cKDTree(positions).query(positions, k=k + 1)[0][:, 1:]
    return np.minimum(near.mean(axis=1), np.median(near[:, 0])) / 2


def _rows(positions: FloatArray, lone: IntArray) -> list[IntArray]:
    """The ``lone`` taxels as straight rows, each in order; one that is in none is a row of its own."""
    if not len(lone):
        return []
    points, rows = positions[lone], []
    near = cKDTree(points).query(points, k=2)[0][:, 1] if len(points) > 1 else np.zeros(1)
    pairs = cKDTree(points).query_pairs(LONGEST * near.max(), output_type="ndarray")
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = pairs[apart <= LONGEST * near[pairs].min(axis=1)]
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    group = connected_components(graph, directed=False)[1]
    for label in range(group.max() + 1):
        own = np.flatnonzero(group == label)
        offset = points[own] - points[own].mean(axis=0)
        _, size, axes = np.linalg.svd(offset, full_matrices=False)
        straight = len(own) == 2 or (len(own) > 2 and size[1] <= 1e-2 * size[0])
        order = own[np.argsort(offset @ axes[0], kind="stable")]
        rows += [lone[order]] if straight else [lone[[one]] for one in own]
    return rows


def _cut_by_medians(coarse: Mesh, owner: IntArray) -> tuple[Mesh, IntArray]:
    """Each face in six by its medians, and the taxel that each of them belongs to: that of its coarse corner."""
    faces, table = coarse.faces, edge_table(coarse.faces)
    corners = coarse.vertices[faces]
    middle = len(coarse.vertices) + table.edge_of
    centre = len(coarse.vertices) + len(table.edges) + np.arange(len(faces))
    vertices = [coarse.vertices, coarse.vertices[table.edges].mean(axis=1), corners.mean(axis=1)]
    centre = np.repeat(centre, 3)
    ahead = np.stack([faces.ravel(), middle.ravel(), centre], axis=1)
    behind = np.stack([faces.ravel(), centre, np.roll(middle, 1, axis=1).ravel()], axis=1)
    fine = np.stack([ahead, behind], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate(vertices), fine), np.repeat(owner[faces.ravel()], 2)


def _pieces(surface: Mesh, feels: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Of each connected piece, that with the most taxels first: its taxels, rising, and its faces."""
    label = face_components(surface.faces)
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(label))[:-1])
    pieces = [(np.unique(feels[faces]), faces) for faces in groups]
    return sorted(pieces, key=lambda piece: (-len(piece[0]), int(piece[0][0])))


def _patch(surface: Mesh, feels: IntArray, own: IntArray, faces: IntArray) -> tuple[Mesh, Taxels]:
    """The surface and the taxels of one piece."""
    used, numbered = np.unique(surface.faces[faces], return_inverse=True)
    piece = Mesh(surface.vertices[used], numbered.reshape(-1, 3))
    seat = np.full(used[-1] + 1, -1)
    # The first corner of a sixth is the coarse vertex that owns it; that one of them is the taxel itself.
    at_taxel = surface.faces[faces, 0] == feels[faces]
    seat[feels[faces[at_taxel]][::-1]] = np.flatnonzero(at_taxel)[::-1]
    weights = np.tile([1.0, 0.0, 0.0], (len(own), 1))
    return piece, taxels_in(piece, seat[own], weights, np.searchsorted(own, feels[faces]))
