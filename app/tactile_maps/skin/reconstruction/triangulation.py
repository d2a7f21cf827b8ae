"""Surface through taxels: estimated normals, then triangles on which neighbourhoods agree.

Normals. The normal of a taxel is that of the plane through its neighbours (Hoppe, DeRose, Duchamp, McDonald and
Stuetzle 1992, "Surface reconstruction from unorganized points"). Their signs are made consistent along a minimum
spanning tree of the differences of planes. The outward side follows from the stated normals if these are plausible;
many files contain dummies, or normals in another frame, which are ignored.

Triangles. Each taxel projects its neighbours onto its tangent plane and votes for the triangles around it in a Delaunay
triangulation there. Triangles with at least two votes are added in descending order of votes where they fit: no edge
gets a third face, no vertex a second fan, and adjacent faces have the same orientation. The length of sides is bounded
by the local spacing, so that gaps between patches stay open. (After Gopi, Krishnan and Silva 2000, "Surface
reconstruction based on lower dimensional localized Delaunay triangulation".)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.connectivity import Connectivity, split_nonmanifold
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import nearest_others

PLANE_NEIGHBOURS = 10
"""Number of neighbours for the plane of a taxel, besides the taxel itself."""
_LINE_RATIO = 1e-4
"""Ratio of the second to the largest variance of neighbours, below which they are on a line."""
_MIN_MEDIAN_AGREEMENT = 0.7
"""Least median cosine between stated and estimated normals, 45 degrees; random ones have 60."""
_MIN_DUMMY_AGREEMENT = 0.94
"""Cosine that a tenth of the planes falls below, 20 degrees, if one normal for all taxels is a dummy."""
_MIN_OUTWARD_SHARE = 0.05
"""Mean offset from the middle along the normals, over the mean distance, above which a surface is closed or domed."""


@dataclass(frozen=True, eq=False)
class EstimatedNormals(ArrayFields):
    """Outward directions of taxels.

    Attributes:
        normals: (n, 3) unit normals in the frame of the positions, with consistent signs.
        straight: (n,) whether the neighbours are on a line or missing, so that the normal is partly a guess.
        findings: Defects of the stated normals, and guessed sides.
    """

    normals: FloatArray
    straight: BoolArray
    findings: tuple[Finding, ...]


def estimate_normals(
    positions: FloatArray, *, stated: FloatArray | None = None, where: str = "taxels"
) -> EstimatedNormals:
    """Estimate the normals of a surface from its taxels.

    Args:
        positions: (n, 3) [m], distinct; at least one.
        stated: (n, 3) normals stated in a file, unit or zero; used for the outward side, and along straight rows.
        where: Name of the set, for findings.

    Cost: 8 ms for 1000 taxels.
    """
    near = nearest_others(positions, PLANE_NEIGHBOURS)[1]
    axes, straight = _principal_axes(positions, near)
    notes: list[Finding] = []
    stated = _usable_stated_normals(stated, axes[:, :, 0], straight, where, notes)
    normals = _normals_on_lines(positions, axes, straight, stated)
    normals, sheet = _orient_consistently(normals, near, positions)
    outside, clear = _outward_signs(positions, normals, sheet, stated)
    if not clear.all():
        action = "the outward side is uncertain: the taxels do not determine it (sheets of taxels)"
        notes.append(Finding("guessed-outside", where, action, int((~clear).sum())))
    return EstimatedNormals(normals * outside[sheet, None], straight, tuple(notes))


def _principal_axes(positions: FloatArray, near: IntArray) -> tuple[FloatArray, BoolArray]:
    """Return (n, 3, 3) axes of each neighbourhood as columns, normal first and longest last, and (n,) if it is a line.

    The longest axis of a single taxel is zero.
    """
    local = positions[np.column_stack([np.arange(len(near)), near])]
    local = local - local.mean(axis=1, keepdims=True)
    spread, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    axes[:, :, 2] *= spread[:, 2, None] > 0
    return axes, spread[:, 1] <= _LINE_RATIO * spread[:, 2]


def _usable_stated_normals(
    stated: FloatArray | None, planes: FloatArray, straight: BoolArray, where: str, notes: list[Finding]
) -> FloatArray | None:
    """Return the stated normals; None, and a finding, if they do not fit this surface."""
    if stated is None:
        return None
    given = np.linalg.norm(stated, axis=1) > 0.5
    along = np.abs((stated * planes).sum(axis=1))[given & ~straight]
    problem = None
    if not given.any():
        problem = "dummy-normals", "not used: all zero"
    elif len(along) and bool((stated == stated[0]).all()) and np.quantile(along, 0.1) < _MIN_DUMMY_AGREEMENT:
        problem = "dummy-normals", "not used: one for all, although the taxels are on a curved surface"
    elif len(along) and np.median(along) < _MIN_MEDIAN_AGREEMENT:
        turned = np.degrees(np.arccos(np.minimum(np.median(along), 1.0)))
        problem = "foreign-normals", f"not used: {turned:.0f} degrees (median) off the surface of the taxels"
    if problem is None:
        return stated
    notes.append(Finding(problem[0], where, problem[1], len(stated)))
    return None


def _normals_on_lines(
    positions: FloatArray, axes: FloatArray, straight: BoolArray, stated: FloatArray | None
) -> FloatArray:
    """Return (n, 3) normals of the planes; on a line, perpendicular to it and closest to a hint of the outward side."""
    normals = axes[:, :, 0].copy()
    if straight.any():
        line = axes[straight, :, 2]
        hints = [positions[straight], axes[straight, :, 0]]  # the origin of a link's frame is inside the link
        hints = hints if stated is None else [stated[straight], *hints]
        best = np.zeros_like(line)
        for hint in hints:
            square = hint - (hint * line).sum(axis=1, keepdims=True) * line
            length = np.linalg.norm(square, axis=1)
            size = np.linalg.norm(hint, axis=1)
            free = ~best.any(axis=1) & (length > 0.1 * size) & (size > 0)
            best[free] = square[free] / length[free, None]
        normals[straight] = best
    return normals


def _orient_consistently(normals: FloatArray, near: IntArray, positions: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return normals with consistent signs, and (n,) the connected sheet of each taxel."""
    count = len(near)
    rows = np.repeat(np.arange(len(near)), near.shape[1])
    columns = near.ravel()
    turn = 1.0 - np.abs((normals[rows] * normals[columns]).sum(axis=1))
    away = np.linalg.norm(positions[rows] - positions[columns], axis=1)
    # Distance decides among equal planes; a cost of zero would mean no connection.
    cost = turn + 0.1 * away / max(float(away.max(initial=0.0)), 1e-300) + 1e-9
    graph = coo_matrix((cost, (rows, columns)), shape=(count, count)).tocsr()
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    sheet = connected_components(tree, directed=False)[1].astype(np.int64)
    sign = [1.0] * count
    for first in np.unique(sheet, return_index=True)[1].tolist():
        order, parent = breadth_first_order(tree, first, directed=False)
        above = parent[order[1:]]
        agree = np.vecdot(normals[order[1:]], normals[above]) >= 0
        for child, parent_of_child, same in zip(order[1:].tolist(), above.tolist(), agree.tolist(), strict=True):
            sign[child] = sign[parent_of_child] if same else -sign[parent_of_child]
    return normals * np.array(sign)[:, None], sheet


def _outward_signs(
    positions: FloatArray, normals: FloatArray, sheet: IntArray, stated: FloatArray | None
) -> tuple[FloatArray, BoolArray]:
    """Return (sheets,) the sign, 1 or -1, that turns each sheet outward, and whether it is more than a guess."""
    offset = positions - positions.mean(axis=0)
    votes = np.bincount(sheet, (normals * offset).sum(axis=1))
    clear = np.abs(votes) > _MIN_OUTWARD_SHARE * np.bincount(sheet, np.linalg.norm(offset, axis=1))
    # A flat sheet has no inside; the origin of a link's frame is mostly behind its skin.
    votes = np.where(clear, votes, np.bincount(sheet, (normals * positions).sum(axis=1)))
    if stated is not None:
        agreement = np.bincount(sheet, (normals * stated).sum(axis=1))
        decided = np.abs(agreement) > 0.2 * np.bincount(sheet)
        votes = np.where(decided, agreement, votes)
        clear = clear | decided
    return np.where(votes < 0, -1.0, 1.0), clear


STAR_NEIGHBOURS = 20
"""Number of neighbours from which the triangles of a taxel are chosen."""
MAX_EDGE_SPACINGS = 2.2
"""Largest length of a side in spacings; across two rows of a hexagonal grid it is 1.73, across a gap more."""
_SPACING_NEIGHBOURS = 4
"""Number of others whose mean distance is the spacing of a taxel."""
_MAX_SECOND_RATIO = (
    1.75  # at the tip of a triangular module of ten, the third and fourth are this far away, in spacings
)
_MIN_HEIGHT_RATIO = 0.1
"""Least height of a triangle over its longest side; flatter ones are along straight borders and are not needed."""
_MIN_NORMAL_AGREEMENT = 0.2
"""Least cosine between the normals of neighbours, 80 degrees; others are around an edge or on the other side."""
MAX_HOLE_SIDES = 6
"""Largest number of sides of a hole that is filled: one taxel is missing, or neighbourhoods disagree."""
_MIN_FILL_AGREEMENT = 0.5
"""Least cosine between a triangle that fills a hole and the normals of its corners, so that thin tubes stay open."""
_MIN_TANGENT_DISTANCE = (
    0.01  # in spacings: a neighbour this close in the tangent plane is above the taxel, not next to it
)
_TIE = 1e-9
_BLOCK = 128  # taxels at a time, so that their lines stay in the cache
_REJECTING = 3  # nearest neighbours that reject most lines, tried for all of them


@dataclass(frozen=True, eq=False)
class TriangulatedTaxels(ArrayFields):
    """Surface with taxels as vertices.

    Attributes:
        mesh: Mesh with the taxels, in order, as vertices; edges have one or two faces, vertices one fan or none.
        normals: (n, 3) outward unit normals of the taxels.
        spacing: (n,) distance of each taxel to its neighbours [m].
        findings: Defects that were found.
    """

    mesh: Mesh
    normals: FloatArray
    spacing: FloatArray
    findings: tuple[Finding, ...]


def triangulate(
    positions: FloatArray, *, normals: FloatArray | None = None, where: str = "taxels"
) -> TriangulatedTaxels:
    """Return a manifold, oriented surface through taxels that does not bridge gaps.

    Taxels that are too few for a surface, or on a line, have no faces.

    Args:
        positions: (n, 3) [m], distinct.
        normals: (n, 3) stated normals; only their side is used, and only if they are plausible.
        where: Name of the set, for findings.

    Raises:
        SkinError: There is no taxel, or two are at the same position.

    Cost: 0.1 s for 1000 taxels.
    """
    _check_positions(positions, where)
    found = estimate_normals(positions, stated=normals, where=where)
    spacing = local_spacing(positions)
    none = np.zeros((0, 3), dtype=np.int64)
    faces = none if found.straight.all() else _manifold_faces(positions, found.normals, spacing)
    return TriangulatedTaxels(Mesh(positions, faces), found.normals, spacing, found.findings)


def local_spacing(positions: FloatArray) -> FloatArray:
    """Return (n,) mean distance of each taxel to its four nearest [m]; zero for a single taxel.

    It is bounded by the distance to the second one: the others of a pair or a triplet are in other groups.
    """
    distances = nearest_others(positions, _SPACING_NEIGHBOURS)[0]
    if not distances.size:
        return np.zeros(len(positions))
    return np.minimum(distances.mean(axis=1), _MAX_SECOND_RATIO * distances[:, :2][:, -1])


def _check_positions(positions: FloatArray, where: str) -> None:
    if not len(positions):
        raise SkinError("there are no taxels", file=where)
    if not np.isfinite(positions).all():
        raise SkinError("a position is not a finite number", file=where)
    if len(np.unique(positions, axis=0)) < len(positions):
        raise SkinError("two taxels are at one place", file=where, remedy="Leave one of them out")


def _manifold_faces(positions: FloatArray, normals: FloatArray, spacing: FloatArray) -> IntArray:
    """Return the faces (m, 3) of the surface, counter-clockwise from outside."""
    near = nearest_others(positions, STAR_NEIGHBOURS)[1]
    blocks = np.array_split(np.arange(len(positions)), -(-len(positions) // _BLOCK))
    frames = _tangent_frames(normals)
    named = np.concatenate(
        [_local_delaunay_triangles(positions, normals, frames, spacing, near, block) for block in blocks]
    )
    faces, votes = _count_votes(named, len(positions))
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    sides = np.diff(positions[ends], axis=2)[:, :, 0]
    lengths = np.linalg.norm(sides, axis=2)
    height = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / lengths.max(axis=1)
    fit = (lengths <= MAX_EDGE_SPACINGS * spacing[ends].min(axis=2)).all(axis=1) & (
        height > _MIN_HEIGHT_RATIO * lengths.max(axis=1)
    )
    faces = faces[fit]
    votes = votes[fit]
    order = np.lexsort((lengths[fit].max(axis=1), -votes))
    sure = order[votes[order] >= 2]
    laid = _keep_largest_fans(faces[_select_compatible(faces, sure)])
    return np.concatenate([laid, *_fill_small_holes(laid, positions, normals, spacing)])


def _local_delaunay_triangles(
    positions: FloatArray,
    normals: FloatArray,
    frames: FloatArray,
    spacing: FloatArray,
    near: IntArray,
    centres: IntArray,
) -> IntArray:
    """Return the Delaunay triangles (t, 3) around each of ``centres``, that one first, counter-clockwise from outside.

    Inversion (x / |x|²) maps circles through the centre to lines: the triangles are the sides of the convex hull.
    """
    around = near[centres]
    spread = spacing[centres, None, None]
    flat = np.einsum("nkd,nda->nka", positions[around] - positions[centres, None], frames[centres]) / spread
    squared = (flat**2).sum(axis=2)
    seen = np.einsum("nkd,nd->nk", normals[around], normals[centres]) > _MIN_NORMAL_AGREEMENT
    seen &= squared > _MIN_TANGENT_DISTANCE**2
    out = np.where(seen[:, :, None], flat / np.where(seen, squared, 1.0)[:, :, None], 0.0)
    x: FloatArray = out[:, :, 0]
    y: FloatArray = out[:, :, 1]
    inside = x[:, :, None] * y[:, None] - y[:, :, None] * x[:, None]  # on which side of the line from i to j it is
    width = x[:, None] - x[:, :, None]
    height = y[:, None] - y[:, :, None]
    hull = (inside > _TIE) & seen[:, :, None] & seen[:, None]
    first = min(_REJECTING, near.shape[1])
    for k in range(first):
        hull &= width * y[:, k, None, None] - height * x[:, k, None, None] + inside >= -_TIE
    n, i, j = np.nonzero(hull)
    width, height, level = (part[hull] for part in (width, height, inside))
    for k in range(first, near.shape[1]):
        hull = width * y[n, k] - height * x[n, k] + level >= -_TIE
        n, i, j, width, height, level = (part[hull] for part in (n, i, j, width, height, level))
    return np.stack([centres[n], around[n, i], around[n, j]], axis=1)


def _tangent_frames(normals: FloatArray) -> FloatArray:
    """Return (n, 3, 2) two unit directions as columns that form a right-handed frame with each normal."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=2)


def _count_votes(named: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Return the distinct triangles, with the orientation of most of their votes, and the number of these votes."""
    first = named.argmin(axis=1)
    named = np.take_along_axis(named, (first[:, None] + np.arange(3)) % 3, axis=1)
    even = named[:, 1] < named[:, 2]
    rows = np.where(even[:, None], named, named[:, [0, 2, 1]])
    keys, kind = np.unique((rows[:, 0] * count + rows[:, 1]) * count + rows[:, 2], return_inverse=True)
    ahead = np.bincount(kind, np.where(even, 1, -1), len(keys)) >= 0
    votes = np.bincount(kind, even == ahead[kind], len(keys)).astype(np.int64)
    pair, last = np.divmod(keys, count)
    faces = np.stack([*np.divmod(pair, count), last], axis=1)
    return np.where(ahead[:, None], faces, faces[:, [0, 2, 1]]), votes


def _select_compatible(faces: IntArray, order: IntArray) -> IntArray:
    """Return the faces of ``order`` that are compatible with those kept before: no directed side is used twice."""
    taken: set[int] = set()
    laid = []
    directed = faces[order] * (int(faces.max(initial=0)) + 1) + np.roll(faces[order], -1, axis=1)
    for number, sides in zip(order.tolist(), directed.tolist(), strict=True):
        if taken.isdisjoint(sides):
            taken.update(sides)
            laid.append(number)
    return np.array(laid, dtype=np.int64)


def _keep_largest_fans(faces: IntArray) -> IntArray:
    """Return the faces without those of smaller fans at vertices with several fans."""
    while len(faces):
        copies, vertex_of = split_nonmanifold(faces, Connectivity(faces).twins)
        size = np.bincount(copies.ravel(), minlength=len(vertex_of))
        order = np.lexsort((np.arange(len(size)), -size, vertex_of))
        largest = np.zeros(len(size), dtype=bool)
        largest[order[np.unique(vertex_of[order], return_index=True)[1]]] = True
        keep = largest[copies].all(axis=1)
        if keep.all():
            break
        faces = faces[keep]
    return faces


def _fill_small_holes(
    faces: IntArray, positions: FloatArray, normals: FloatArray, spacing: FloatArray
) -> list[IntArray]:
    """Return faces (f, 3) for each hole with few sides, if they face outward and their sides are short enough."""
    connectivity = Connectivity(faces)
    edges = {tuple(edge) for edge in connectivity.edges.tolist()}
    filled = []
    for loop in connectivity.boundary_loops:
        ears = _clip_ears(loop[::-1], positions, normals, spacing) if len(loop) <= MAX_HOLE_SIDES else None
        if ears is not None and edges.isdisjoint(new := {tuple(sorted(ear[[0, 2]].tolist())) for ear in ears[:-1]}):
            edges |= new
            filled.append(ears)
    return filled


def _clip_ears(loop: IntArray, positions: FloatArray, normals: FloatArray, spacing: FloatArray) -> IntArray | None:
    """Return the triangles (k - 2, 3) of a polygon (k,), by shortest third side; None if one of them is invalid."""
    corners = loop.tolist()
    ears = []
    while len(corners) >= 3:
        ring = np.array(corners)
        ear = np.stack([np.roll(ring, 1), ring, np.roll(ring, -1)], axis=1)
        second: FloatArray = positions[ear[:, 1]] - positions[ear[:, 0]]
        third: FloatArray = positions[ear[:, 2]] - positions[ear[:, 0]]
        normal = np.cross(second, third)
        length: FloatArray = np.linalg.norm(third, axis=1)
        facing = np.einsum("kcd,kd->kc", normals[ear], normal).min(axis=1)
        good: BoolArray = facing > _MIN_FILL_AGREEMENT * np.linalg.norm(normal, axis=1)
        good &= length <= MAX_EDGE_SPACINGS * np.minimum(spacing[ear[:, 0]], spacing[ear[:, 2]])
        if not good.any():
            return None
        best = int(np.where(good, length, np.inf).argmin())
        ears.append(ear[best])
        del corners[best]
    return np.array(ears)
