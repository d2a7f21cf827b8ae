"""Skin from taxels alone, without a robot or a mesh, from positions in the frame of a link.

The surface through the taxels is triangulated (``triangulation``), or taken from the file if it is valid; each
connected component is a patch. The surface is extended beyond its boundary by half a spacing, which completes the area
of the outermost taxels, and is the whole area of a single taxel, a pair or a row. Barycentric subdivision divides each
triangle by its medians into six, two for each corner, so that a taxel has a dozen quadrature points or more; the border
between two taxels is then cut where both are equally far.

The extension follows the boundary at half a spacing, in the tangent planes of the taxels, with round corners. A row of
taxels is a boundary without an interior, followed in both directions; a single taxel is a boundary of one corner. The
same code makes a strip around a row and a disk around a single taxel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError, add_finding
from tactile_maps.geometry.surface.connectivity import connected_labels
from tactile_maps.geometry.surface.mesh import Mesh, edge_lengths
from tactile_maps.geometry.surface.points import nearest_others
from tactile_maps.skin.model.skin import Patch, Quadrature, Skin, Taxels, number_ranges, patch_name
from tactile_maps.skin.model.taxel_axes import tangents_on
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
"""Distance [m] below which taxels are the same one: files state tenths of a millimetre."""
LONE_TAXEL_RADIUS = 0.003
"""Radius of a taxel without any others [m]."""
_OPPOSITE = 0.7
_MIN_RELATIVE_AREA = 1e-6
"""Area of a stated face over its longest side squared, below which it is a line."""
_MAX_PAIRS = 5_000_000
MAX_PIECES = 2_000
"""Largest number of pieces; each costs about a millisecond, and more faces for its boundary than for its interior."""


@dataclass(frozen=True, eq=False)
class ReconstructedSkin(ArrayFields):
    """A skin, and the numbers in it of the taxels of a set.

    Attributes:
        skin: Skin of one link; its patches are the connected pieces, the one with the most taxels first.
        taxel_of: (n,) number in the skin of each taxel of the set; taxels at one position have the same number.
    """

    skin: Skin
    taxel_of: IntArray


def skin_from_taxels(taxels: TaxelSet) -> Skin:
    """Return the skin of ``reconstruct_skin``."""
    return reconstruct_skin(taxels).skin


def reconstruct_skin(taxels: TaxelSet) -> ReconstructedSkin:
    """Return the skin of ``taxels`` without a robot.

    Taxels at one position become one. Taxels without a surface (too few, or in a row) get a strip or a small disk, with
    a finding: every taxel is on the skin.

    Cost: 0.2 s for 1000 taxels.
    """
    first, kind = _merge_coincident(taxels.positions)
    notes = [*taxels.findings]
    merged = np.setdiff1d(np.arange(len(kind)), first)
    action = "merged with another at the same position"
    if taxels.ids is not None:
        action += f", which also receives the readings of ids {number_ranges(taxels.ids[merged])}"
    add_finding(notes, "duplicate-taxel", taxels.name, action, len(merged))
    joined = _surface(taxels, first, kind, notes)
    coarse, owner = _with_extended_boundary(joined, taxels.name, notes)
    surface, feels = _barycentric_subdivision(coarse, owner)
    identity = taxels.identity.merged(first, kind)
    link = taxels.link or "skin"
    pieces = _components(surface, feels)
    axes = None if taxels.axes is None else taxels.axes[first]
    tangents = None if taxels.tangents is None else taxels.tangents[first]
    patches = list[Patch]()
    for (own, _), (mesh, plain) in zip(pieces, _split(surface, feels, pieces), strict=True):
        stated = replace(
            plain,
            identity=identity.select(own),
            axes=None if axes is None else axes[own],
            tangents=None if tangents is None else tangents_on(tangents[own], plain.normals),
        )
        patches.append(Patch(patch_name(taxels.name, len(patches)), link, mesh, stated))
    place = np.empty(len(first), dtype=np.int64)
    place[np.concatenate([own for own, _ in pieces])] = np.arange(len(first))
    return ReconstructedSkin(Skin(tuple(patches), tuple(notes)), place[kind])


def _merge_coincident(positions: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the first taxel at each position, in their order, and (n,) the position of each taxel."""
    group = connected_labels(_near_pairs(positions, COINCIDENT_DISTANCE), len(positions))
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
        value = f"{count} pairs within {1e3 * distance:.3g} mm"
        remedy = f"The maximum is {_MAX_PAIRS} pairs: check the unit of the positions, or leave repeated taxels out"
        raise SkinError("too many taxels are at nearly the same place", value=value, remedy=remedy)
    return np.asarray(tree.query_pairs(distance, output_type="ndarray"), dtype=np.int64)


def _surface(taxels: TaxelSet, first: IntArray, kind: IntArray, notes: list[Finding]) -> TriangulatedTaxels:
    """Return the surface of the stated faces if they are valid, or of new ones."""
    positions = taxels.positions[first]
    where = taxels.name
    normals = None if taxels.normals is None else taxels.normals[first]
    if taxels.faces is not None and len(taxels.faces):
        stated = Mesh(positions, kind[taxels.faces])
        problem = _defect_of_faces(stated)
        if problem is None:
            return _stated_surface(stated, normals, where, notes)
        add_finding(notes, "unsound-faces", where, f"the stated faces are not used: {problem}", len(taxels.faces))
    joined = triangulate(positions, normals=normals, where=where)
    notes.extend(joined.findings)
    return joined


def _stated_surface(stated: Mesh, normals: FloatArray | None, where: str, notes: list[Finding]) -> TriangulatedTaxels:
    """Return the stated surface, reversed if nearly all stated normals point to its other side."""
    if normals is not None and (stated.vertex_normals * normals).sum() < -_OPPOSITE * len(normals):
        add_finding(notes, "turned-face", where, "reoriented to match the normals", len(stated.faces))
        stated = Mesh(stated.vertices, stated.faces[:, ::-1])
    outward = stated.vertex_normals
    used = outward.any(axis=1, keepdims=True)
    if not used.all():
        outward = np.where(used, outward, estimate_normals(stated.vertices, stated=outward).normals)
    return TriangulatedTaxels(stated, outward, local_spacing(stated.vertices), ())


def _defect_of_faces(mesh: Mesh) -> str | None:
    """Return the reason why faces over taxels are not a valid surface, or None."""
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
    """Return the surface with its extensions, and (vertices,) the taxel of each vertex."""
    positions = joined.mesh.vertices
    faces = [joined.mesh.faces]
    lone = np.setdiff1d(np.arange(len(positions)), joined.mesh.faces)
    rows = _straight_rows(positions, lone)
    pieces = int(joined.mesh.connectivity.components.max(initial=-1)) + 1 + len(rows)
    if pieces > MAX_PIECES:
        remedy = (
            f"The maximum is {MAX_PIECES}: check the positions and their unit, state faces, or write one file per link"
        )
        raise SkinError("the taxels are in too many separate pieces", value=pieces, remedy=remedy)
    single = sum(len(row) == 1 for row in rows)
    add_finding(notes, "lone-taxel", where, "isolated taxel: given a small disk", single)
    add_finding(notes, "taxel-row", where, "collinear taxels: given a strip", len(rows) - single)
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
    """Return (n,) width of the extension at each taxel [m]: half of the distance to its two nearest taxels."""
    near = nearest_others(positions, 2)[0]
    if not near.size:
        return np.full(len(positions), LONE_TAXEL_RADIUS)
    return np.minimum(near.mean(axis=1), np.median(near[:, 0])) / 2


def _straight_rows(positions: FloatArray, lone: IntArray) -> list[IntArray]:
    """Return the ``lone`` taxels as straight rows, each in order; a taxel without a row is a row of one."""
    if len(lone) < 2:
        return [lone] if len(lone) else []
    points = positions[lone]
    rows = []
    near = nearest_others(points, 1)[0][:, 0]
    pairs = _near_pairs(points, MAX_EDGE_SPACINGS * near.max())
    pairs = pairs[edge_lengths(points, pairs) <= MAX_EDGE_SPACINGS * near[pairs].min(axis=1)]
    group = connected_labels(pairs, len(points))
    for label in range(group.max() + 1):
        own = np.flatnonzero(group == label)
        offset = points[own] - points[own].mean(axis=0)
        _, size, axes = np.linalg.svd(offset, full_matrices=False)
        straight = len(own) == 2 or (len(own) > 2 and size[1] <= 1e-2 * size[0])
        order = own[np.argsort(offset @ axes[0], kind="stable")]
        rows += [lone[order]] if straight else [lone[[one]] for one in own]
    return rows


def _barycentric_subdivision(coarse: Mesh, owner: IntArray) -> tuple[Mesh, IntArray]:
    """Return each face divided into six by its medians, and the taxel of each part: that of its coarse corner."""
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
    """Return the taxels, in ascending order, and the faces of each connected piece, the one with most taxels first."""
    label = surface.connectivity.components
    order = np.argsort(label, kind="stable")
    groups = np.split(order, np.cumsum(np.bincount(label))[:-1])
    pieces = [(np.flatnonzero(np.bincount(feels[faces])), faces) for faces in groups]
    return sorted(pieces, key=lambda piece: (-len(piece[0]), int(piece[0][0])))


def _split(surface: Mesh, feels: IntArray, pieces: list[tuple[IntArray, IntArray]]) -> Iterator[tuple[Mesh, Taxels]]:
    """Yield the surface and the taxels of each piece. Expensive parts are computed once for all pieces."""
    # The first corner of a part is its coarse vertex, which is the taxel itself for one of the parts.
    at_taxel = np.flatnonzero(surface.faces[:, 0] == feels)[::-1]
    seat = np.empty(int(feels.max()) + 1, dtype=np.int64)
    seat[feels[at_taxel]] = at_taxel
    whole = taxels_at_barycentric(surface, seat, np.tile([1.0, 0.0, 0.0], (len(seat), 1)), feels)
    if len(pieces) == 1:
        yield surface, whole
        return
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
            ),
        )


MAX_CORNER_ANGLE = np.pi / 3
"""Largest angle between adjacent vertices of a round corner [rad]; corners with a larger turn are rounded."""
_TRIES = 8


@dataclass(frozen=True, eq=False)
class BoundaryExtension:
    """Extension of a surface along its boundary.

    Attributes:
        vertices: (r, 3) new vertices [m], in order along the boundary.
        taxel: (r,) taxel of each new vertex.
        faces: (f, 3) indices of taxels, and from ``first`` on of the new vertices.
    """

    vertices: FloatArray
    taxel: IntArray
    faces: IntArray


def extend_boundary(
    positions: FloatArray, normals: FloatArray, width: FloatArray, walk: IntArray, *, first: int
) -> BoundaryExtension:
    """Return the extension along one closed boundary.

    Args:
        positions: (n, 3) taxels [m].
        normals: (n, 3) unit normals.
        width: (n,) width of the extension at each taxel [m], above zero.
        walk: (w,) taxels along the boundary, with the surface on the left; one for a single taxel.
        first: Number of the first new vertex.
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
    faces = np.concatenate([beyond, between])  # indices of the taxels of the walk, then of the new vertices
    up = normals[taxel[faces[:, 0]]]
    for _ in range(_TRIES):
        vertices = np.concatenate([positions[taxel], positions[taxel] + spokes])
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        folded = (np.cross(b - a, c - a) * up).sum(axis=1) <= 0
        if not folded.any():
            break
        # In a narrow notch adjacent spokes cross; shorter ones do not.
        crossing = np.unique(faces[folded])
        spokes[crossing[crossing >= count] - count] /= 2
    numbers = np.concatenate([taxel, first + inner])
    return BoundaryExtension(positions[taxel] + spokes, taxel, numbers[faces])


def _offset_directions(
    positions: FloatArray, normals: FloatArray, walk: IntArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return for each new vertex its index (r,) in the walk, its unit direction (r, 3), and its distance in widths."""
    up = normals[walk]
    if len(walk) == 1:
        ahead = _tangent_directions(np.eye(3)[np.abs(up).argmin(axis=1)], up)
        turn = np.full(1, 2 * np.pi)
    else:
        step = positions[np.roll(walk, -1)] - positions[walk]
        behind = _tangent_directions(np.roll(step, 1, axis=0), up)
        onward = _tangent_directions(step, up)
        turn = np.arctan2((np.cross(behind, onward) * up).sum(axis=1), (behind * onward).sum(axis=1))
        back = np.roll(walk, 1) == np.roll(walk, -1)  # the end of a row: half a turn outward, never inward
        ahead = behind
        turn = np.where(back, np.pi, turn)
    count = np.where(turn > MAX_CORNER_ANGLE, 1 + np.ceil(turn / MAX_CORNER_ANGLE - 1e-9), 1).astype(np.int64)
    count -= turn > 1.5 * np.pi  # the last spoke of a full turn is the first again
    corner = np.repeat(np.arange(len(walk)), count)
    place = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    share = np.where(count[corner] == 1, 0.5, place / np.maximum(np.ceil(turn / MAX_CORNER_ANGLE - 1e-9), 1)[corner])
    angle = share * turn[corner] - np.pi / 2  # starts on the right-hand side, and follows the turn
    side = np.cross(up, ahead)
    direction = np.cos(angle)[:, None] * ahead[corner] + np.sin(angle)[:, None] * side[corner]
    half = np.cos(np.clip(turn, -np.pi, MAX_CORNER_ANGLE) / 2)
    return corner, direction, np.where(turn > MAX_CORNER_ANGLE, 1.0, np.where(turn > 0, 1 / half, half))[corner]


def _tangent_directions(vectors: FloatArray, up: FloatArray) -> FloatArray:
    """Return unit directions (w, 3) of ``vectors`` in the planes perpendicular to ``up``; any for parallel vectors."""
    level = vectors - (vectors * up).sum(axis=1, keepdims=True) * up
    upright = np.linalg.norm(level, axis=1) <= 1e-6 * np.linalg.norm(vectors, axis=1)
    if upright.any():
        level[upright] = np.cross(up[upright], np.eye(3)[np.abs(up[upright]).argmin(axis=1)])
    return level / np.linalg.norm(level, axis=1, keepdims=True)
