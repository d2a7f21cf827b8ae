"""A skin from taxels alone: no robot, no mesh, only places in a link's frame.

A surface is laid through the taxels (``triangulation``), or the file's own is taken if it is sound; each connected
component is a patch. The surface is extended beyond its boundary by half a spacing, to give the outermost taxels their
share of area, as one taxel, a pair or a row get all of theirs. Barycentric subdivision cuts each triangle by its
medians into six, two for each corner, so that a taxel feels with a dozen points or more; the border between two taxels
is then cut where both are equally far.

The extension follows the boundary at half a spacing's distance, in the taxels' tangent planes, with round corners. A
row of taxels is a boundary without an inside, walked there and back; a single taxel is a boundary of one corner. So the
same few lines make a strip around a row, and a disk around a lone taxel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, TaxelIdentity, Taxels, number_ranges, patch_name
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.triangulation import (
    MAX_EDGE_SPACINGS,
    TriangulatedTaxels,
    estimate_normals,
    local_spacing,
    triangulate,
)
from tactile_maps.skin.taxel_placement.sampling import taxels_at_barycentric

COINCIDENT_DISTANCE = 1e-5
"""Taxels closer than this [m] are one: files state tenths of a millimetre."""
LONE_TAXEL_RADIUS = 0.003
"""A taxel with no other to measure by feels this far around itself [m]."""
_OPPOSITE = 0.7
_MIN_RELATIVE_AREA = 1e-6
"""A stated face with less area than this share of its longest side squared is a line."""
_MAX_PAIRS = 5_000_000
MAX_PIECES = 2_000
"""Each piece costs about a millisecond and, for its boundary, more faces than its inside."""


@dataclass(frozen=True, eq=False)
class ReconstructedSkin:
    """A skin, and which of its taxels stands for which of the set's.

    Attributes:
        skin: One link; its patches are the connected pieces, that with the most taxels first.
        taxel_of: (n,) number in the skin of each taxel of the set; taxels at one place have one number.
    """

    skin: Skin
    taxel_of: IntArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "taxel_of", dtype=np.int64)


def skin_from_taxels(taxels: TaxelSet) -> Skin:
    """The skin of ``reconstruct_skin``, for those who need not know which taxel is which."""
    return reconstruct_skin(taxels).skin


def reconstruct_skin(taxels: TaxelSet) -> ReconstructedSkin:
    """Make the skin that ``taxels`` alone describe.

    Taxels at one place become one. Those that no surface reaches (too few, or in a row) get a strip or a small disk of
    their own, and a finding says so: every taxel is on the skin.

    Cost: 0.2 s for 1000 taxels.
    """
    first, kind = _merge_coincident(taxels.positions)
    notes = [*taxels.findings]
    merged = np.setdiff1d(np.arange(len(kind)), first)
    action = "merged with another at the same place"
    if taxels.ids is not None:
        action += f"; without a taxel of its own: id {number_ranges(taxels.ids[merged])}"
    _note(notes, "duplicate-taxel", taxels.name, action, len(merged))
    joined = _surface(taxels, first, kind, notes)
    coarse, owner = _with_extended_boundary(joined, taxels.name, notes)
    surface, feels = _barycentric_subdivision(coarse, owner)
    identity = taxels.identity.select(first)
    link = taxels.link or "skin"
    pieces = _components(surface, feels)
    parts = _split(surface, feels, pieces, identity)
    patches = [Patch(patch_name(taxels.name, number), link, *part) for number, part in enumerate(parts)]
    place = np.empty(len(first), dtype=np.int64)
    place[np.concatenate([own for own, _ in pieces])] = np.arange(len(first))
    return ReconstructedSkin(Skin(tuple(patches), tuple(notes)), place[kind])


def _note(notes: list[Finding], kind: str, where: str, action: str, count: int) -> None:
    if count:
        notes.append(Finding(kind, where, action, count))


def _merge_coincident(positions: FloatArray) -> tuple[IntArray, IntArray]:
    """The first taxel at each place, in their order, and (n,) the place of each taxel."""
    pairs = _near_pairs(positions, COINCIDENT_DISTANCE)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(positions),) * 2)
    group = connected_components(graph, directed=False)[1]
    first = np.unique(group, return_index=True)[1]
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.sort(first), rank[group]


def _near_pairs(points: FloatArray, distance: float) -> IntArray:
    """Return (p, 2) the pairs of points within a distance [m].

    Raises:
        SkinError: There are more than ``_MAX_PAIRS``: their number grows with the square of the points at one place.
    """
    tree = cKDTree(points)
    count = (int(tree.count_neighbors(tree, distance)) - len(points)) // 2
    if count > _MAX_PAIRS:
        raise SkinError(
            "too many taxels are at nearly the same place", value=f"{count} pairs within {1e3 * distance:.3g} mm",
            remedy=f"The most is {_MAX_PAIRS} pairs: check the unit of the positions, or leave repeated taxels out",
        )  # fmt: skip
    return np.asarray(tree.query_pairs(distance, output_type="ndarray"), dtype=np.int64)


def _surface(taxels: TaxelSet, first: IntArray, kind: IntArray, notes: list[Finding]) -> TriangulatedTaxels:
    """The set's own faces if they make a sound surface, else new ones."""
    positions = taxels.positions[first]
    where = taxels.name
    normals = None if taxels.normals is None else taxels.normals[first]
    if taxels.faces is not None and len(taxels.faces):
        stated = Mesh(positions, kind[taxels.faces])
        problem = _defect_of_faces(stated)
        if problem is None:
            return _stated_surface(stated, normals, where, notes)
        _note(notes, "unsound-faces", where, f"the stated faces are not used: {problem}", len(taxels.faces))
    joined = triangulate(positions, normals=normals, where=where)
    notes.extend(joined.findings)
    return joined


def _stated_surface(stated: Mesh, normals: FloatArray | None, where: str, notes: list[Finding]) -> TriangulatedTaxels:
    """The file's own surface, turned if nearly all of its normals, where there are any, look to its other side."""
    if normals is not None and (stated.vertex_normals * normals).sum() < -_OPPOSITE * len(normals):
        _note(notes, "turned-face", where, "reoriented to match the normals", len(stated.faces))
        stated = Mesh(stated.vertices, stated.faces[:, ::-1])
    own = stated.vertex_normals
    used = own.any(axis=1, keepdims=True)
    beside = own if used.all() else np.where(used, own, estimate_normals(stated.vertices, stated=own).normals)
    return TriangulatedTaxels(stated, beside, local_spacing(stated.vertices), ())


def _defect_of_faces(mesh: Mesh) -> str | None:
    """Why faces over taxels make no surface, or None."""
    sides = mesh.corners - mesh.vertices[np.roll(mesh.faces, -1, axis=1)]
    if (mesh.face_areas <= _MIN_RELATIVE_AREA * (sides**2).sum(axis=2).max(axis=1)).any():
        return "some have no area"
    if mesh.connectivity.face_count.max() > 2:
        return "more than two meet in an edge"
    directed = mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if len(np.unique(directed, axis=0)) < len(directed):
        return "neighbouring faces are oriented inconsistently"
    if len(mesh.connectivity.bow_tie_vertices):
        return "several fans meet in a taxel"
    return None


def _with_extended_boundary(joined: TriangulatedTaxels, where: str, notes: list[Finding]) -> tuple[Mesh, IntArray]:
    """The surface with its rims, and (vertices,) the taxel that each vertex belongs to."""
    positions = joined.mesh.vertices
    faces = [joined.mesh.faces]
    lone = np.setdiff1d(np.arange(len(positions)), joined.mesh.faces)
    rows = _straight_rows(positions, lone)
    pieces = int(joined.mesh.connectivity.components.max(initial=-1)) + 1 + len(rows)
    if pieces > MAX_PIECES:
        remedy = (
            f"The most is {MAX_PIECES}: check the positions and their unit, state faces, or write a file for each link"
        )
        raise SkinError("the taxels are in too many separate pieces", value=pieces, remedy=remedy)
    single = sum(len(row) == 1 for row in rows)
    _note(notes, "lone-taxel", where, "isolated taxel: given a small disk", single)
    _note(notes, "taxel-row", where, "collinear taxels: given a strip", len(rows) - single)
    walks = [*joined.mesh.connectivity.boundary_loops]
    walks += [np.concatenate([row, row[-2:0:-1]]) for row in rows]
    vertices = [positions]
    owner = [np.arange(len(positions))]
    width = _extension_widths(positions)
    count = len(positions)
    for walk in walks:
        rim = extend_boundary(positions, joined.normals, width, walk, first=count)
        count += len(rim.vertices)
        vertices.append(rim.vertices)
        owner.append(rim.taxel)
        faces.append(rim.faces)
    return Mesh(np.concatenate(vertices), np.concatenate(faces)), np.concatenate(owner)


def _extension_widths(positions: FloatArray) -> FloatArray:
    """(n,) how far each taxel feels beyond the border [m]: half the way to the taxels beside it."""
    k = min(2, len(positions) - 1)
    if k == 0:
        return np.full(1, LONE_TAXEL_RADIUS)
    near = cKDTree(positions).query(positions, k=k + 1)[0][:, 1:]
    return np.minimum(near.mean(axis=1), np.median(near[:, 0])) / 2


def _straight_rows(positions: FloatArray, lone: IntArray) -> list[IntArray]:
    """The ``lone`` taxels as straight rows, each in order; one that is in none is a row of its own."""
    if not len(lone):
        return []
    points = positions[lone]
    rows = []
    near = cKDTree(points).query(points, k=2)[0][:, 1] if len(points) > 1 else np.zeros(1)
    pairs = _near_pairs(points, MAX_EDGE_SPACINGS * near.max())
    apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    pairs = pairs[apart <= MAX_EDGE_SPACINGS * near[pairs].min(axis=1)]
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


def _barycentric_subdivision(coarse: Mesh, owner: IntArray) -> tuple[Mesh, IntArray]:
    """Each face in six by its medians, and the taxel that each of them belongs to: that of its coarse corner."""
    faces = coarse.faces
    table = coarse.connectivity
    corners = coarse.vertices[faces]
    middle = len(coarse.vertices) + table.edge_of
    centre = len(coarse.vertices) + len(table.edges) + np.arange(len(faces))
    vertices = [coarse.vertices, coarse.vertices[table.edges].mean(axis=1), corners.mean(axis=1)]
    centre = np.repeat(centre, 3)
    ahead = np.stack([faces.ravel(), middle.ravel(), centre], axis=1)
    behind = np.stack([faces.ravel(), centre, np.roll(middle, 1, axis=1).ravel()], axis=1)
    fine = np.stack([ahead, behind], axis=1).reshape(-1, 3)
    return Mesh(np.concatenate(vertices), fine), np.repeat(owner[faces.ravel()], 2)


def _components(surface: Mesh, feels: IntArray) -> list[tuple[IntArray, IntArray]]:
    """Of each connected piece, that with the most taxels first: its taxels, rising, and its faces."""
    label = surface.connectivity.components
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(label))[:-1])
    pieces = [(np.unique(feels[faces]), faces) for faces in groups]
    return sorted(pieces, key=lambda piece: (-len(piece[0]), int(piece[0][0])))


def _split(
    surface: Mesh, feels: IntArray, pieces: list[tuple[IntArray, IntArray]], identity: TaxelIdentity
) -> Iterator[tuple[Mesh, Taxels]]:
    """Yield the surface and the taxels of each piece. What is expensive is computed once for all pieces."""
    # The first corner of a sixth is the coarse vertex that owns it; that one of them is the taxel itself.
    at_taxel = np.flatnonzero(surface.faces[:, 0] == feels)[::-1]
    seat = np.empty(int(feels.max()) + 1, dtype=np.int64)
    seat[feels[at_taxel]] = at_taxel
    whole = taxels_at_barycentric(surface, seat, np.tile([1.0, 0.0, 0.0], (len(seat), 1)), feels)
    points = whole.quadrature
    piece_of = np.empty_like(seat)
    place = np.empty_like(seat)
    for number, (own, _) in enumerate(pieces):
        piece_of[own] = number
        place[own] = np.arange(len(own))
    piece_of_pair = piece_of[whole.neighbours[:, 0]]
    pairs = place[whole.neighbours[np.argsort(piece_of_pair, kind="stable")]]
    ends = np.cumsum(np.bincount(piece_of_pair, minlength=len(pieces)))
    piece_of_point = piece_of[points.taxel]
    by_piece = np.argsort(piece_of_point, kind="stable")
    last = np.cumsum(np.bincount(piece_of_point, minlength=len(pieces)))
    felt = np.split(by_piece, last[:-1])
    for (own, faces), here, neighbours in zip(pieces, felt, np.split(pairs, ends[:-1]), strict=True):
        used, numbered = np.unique(surface.faces[faces], return_inverse=True)
        yield (
            Mesh(surface.vertices[used], numbered.reshape(-1, 3)),
            Taxels(
                positions=whole.positions[own],
                normals=whole.normals[own],
                faces=np.searchsorted(faces, whole.faces[own]),
                weights=whole.weights[own],
                areas=whole.areas[own],
                neighbours=neighbours,
                quadrature=Quadrature(
                    points.positions[here], points.normals[here], points.areas[here], place[points.taxel[here]]
                ),
                identity=identity.select(own),
            ),
        )


MAX_CORNER_ANGLE = np.pi / 3
"""A corner that turns by more than this [rad] is rounded with more vertices, at most this far apart."""
_TRIES = 8


@dataclass(frozen=True, eq=False)
class BoundaryExtension:
    """What a border grows.

    Attributes:
        vertices: (r, 3) [m], in order around.
        taxel: (r,) the taxel that each of them belongs to.
        faces: (f, 3) into the taxels, and from the number given as ``first`` on into the vertices above.
    """

    vertices: FloatArray
    taxel: IntArray
    faces: IntArray


def extend_boundary(
    positions: FloatArray, normals: FloatArray, width: FloatArray, walk: IntArray, *, first: int
) -> BoundaryExtension:
    """The rim along one closed walk.

    Args:
        positions: (n, 3) the taxels [m].
        normals: (n, 3) unit.
        width: (n,) of the rim at each taxel [m], above zero.
        walk: (w,) taxels along the border, the surface on the left; a lone taxel is a walk of one.
        first: Number of the rim's first vertex.
    """
    corner, direction, reach = _offset_directions(positions, normals, walk)
    taxel = walk[corner]
    spokes = direction * (reach * width[taxel])[:, None]
    count = len(taxel)
    inner = np.arange(len(taxel))
    after = np.roll(inner, -1)
    outer = count + inner
    beyond = np.stack([after, outer, np.roll(outer, -1)], axis=1)
    between = np.stack([after, inner, outer], axis=1)[taxel != taxel[after]]
    faces = np.concatenate([beyond, between])  # into the taxels of the walk, then the rim
    up = normals[taxel[faces[:, 0]]]
    for _ in range(_TRIES):
        vertices = np.concatenate([positions[taxel], positions[taxel] + spokes])
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        folded = (np.cross(b - a, c - a) * up).sum(axis=1) <= 0
        if not folded.any():
            break
        # In a narrow notch spokes of neighbours cross; shorter ones do not.
        crossing = np.unique(faces[folded])
        spokes[crossing[crossing >= count] - count] /= 2
    numbers = np.concatenate([taxel, first + inner])
    return BoundaryExtension(positions[taxel] + spokes, taxel, numbers[faces])


def _offset_directions(
    positions: FloatArray, normals: FloatArray, walk: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Of each rim vertex: (r,) its place in the walk, (r, 3) unit direction there, (r,) distance in rim widths."""
    up = normals[walk]
    if len(walk) == 1:
        ahead = _tangent_directions(np.eye(3)[np.abs(up).argmin(axis=1)], up)
        turn = np.full(1, 2 * np.pi)
    else:
        step = positions[np.roll(walk, -1)] - positions[walk]
        behind = _tangent_directions(np.roll(step, 1, axis=0), up)
        onward = _tangent_directions(step, up)
        turn = np.arctan2((np.cross(behind, onward) * up).sum(axis=1), (behind * onward).sum(axis=1))
        back = np.roll(walk, 1) == np.roll(walk, -1)  # the end of a row: all the way round, not half a turn inward
        ahead = behind
        turn = np.where(back, np.pi, turn)
    count = np.where(turn > MAX_CORNER_ANGLE, 1 + np.ceil(turn / MAX_CORNER_ANGLE - 1e-9), 1).astype(np.int64)
    count -= turn > 1.5 * np.pi  # the last spoke of a full turn is the first again
    corner = np.repeat(np.arange(len(walk)), count)
    place = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    share = np.where(count[corner] == 1, 0.5, place / np.maximum(np.ceil(turn / MAX_CORNER_ANGLE - 1e-9), 1)[corner])
    angle = share * turn[corner] - np.pi / 2  # from straight ahead to the right-hand side, then along with the turn
    side = np.cross(up, ahead)
    direction = np.cos(angle)[:, None] * ahead[corner] + np.sin(angle)[:, None] * side[corner]
    half = np.cos(np.clip(turn, -np.pi, MAX_CORNER_ANGLE) / 2)
    return corner, direction, np.where(turn > MAX_CORNER_ANGLE, 1.0, np.where(turn > 0, 1 / half, half))[corner]


def _tangent_directions(vectors: FloatArray, up: FloatArray) -> FloatArray:
    """(w, 3) unit directions of ``vectors`` in the planes square to ``up``; any where a vector stands upright."""
    level = vectors - (vectors * up).sum(axis=1, keepdims=True) * up
    upright = np.linalg.norm(level, axis=1) <= 1e-6 * np.linalg.norm(vectors, axis=1)
    if upright.any():
        level[upright] = np.cross(up[upright], np.eye(3)[np.abs(up[upright]).argmin(axis=1)])
    return level / np.linalg.norm(level, axis=1, keepdims=True)
