"""A surface through taxels that come without one: first their normals, then triangles that neighbourhoods agree on.

Normals. Each taxel's normal is that of the plane through its neighbours (Hoppe, DeRose, Duchamp, McDonald and Stuetzle
1992, "Surface reconstruction from unorganized points"); neighbours are brought to agree about the outside along a tree
of those whose planes differ least. Which side is outside, the file's own normals vote, as far as they lie along ours;
many files hold dummies, or normals of another frame, and those have no vote.

Triangles. Each taxel looks at its neighbours in its own tangent plane and names the triangles that it would have in a
Delaunay triangulation there. Triangles that at least two of their corners name are laid down, the surest first, where
they fit: no edge gets a third face, no vertex a second fan, and neighbours are oriented alike. No side is longer than
the taxels around it allow, so that gaps between patches stay gaps. (After Gopi, Krishnan and Silva 2000, "Surface
reconstruction based on lower dimensional localized Delaunay triangulation".) Nothing here calls native geometry code.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.surface.connectivity import Connectivity, split_nonmanifold
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import nearest_others

PLANE_NEIGHBOURS = 10
"""Taxels that the plane is laid through, the taxel itself not counted."""
_LINE_RATIO = 1e-4
"""Neighbours that spread less than this share of their length (squared) to the side lie on a line."""
_MIN_MEDIAN_AGREEMENT = 0.7
"""Stated normals count if half of them lie within 45 degrees of ours; by chance, half lie within 60."""
_MIN_DUMMY_AGREEMENT = 0.94
"""One normal for all is a dummy where a tenth of the planes is turned by more than 20 degrees against it."""
_MIN_OUTWARD_SHARE = 0.05
"""A surface whose taxels look this share of their distance away from its middle is closed or domed."""


@dataclass(frozen=True, eq=False)
class EstimatedNormals:
    """Outward directions of taxels.

    Attributes:
        normals: (n, 3) unit, in the frame of the positions; neighbours agree about the outside.
        straight: (n,) where the neighbours lie on a line (or there are none), so that the normal is partly a guess.
        findings: What was wrong with the stated normals, and which sides were guessed.
    """

    normals: FloatArray
    straight: BoolArray
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "normals")
        freeze_arrays(self, "straight", dtype=bool)


def estimate_normals(
    positions: FloatArray, *, stated: FloatArray | None = None, where: str = "taxels"
) -> EstimatedNormals:
    """Normals of a surface that is known by its taxels only.

    Args:
        positions: (n, 3) [m], distinct; at least one.
        stated: (n, 3) what a file says, unit or zero; only asked for the outside, and along a straight row of taxels.
        where: The set's name, for findings.

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
    """(n, 3, 3) axes of each neighbourhood as columns, normal first and longest last; (n,) whether it is a line.

    A lone taxel has no longest axis: zero.
    """
    local = positions[np.column_stack([np.arange(len(near)), near])]
    local = local - local.mean(axis=1, keepdims=True)
    spread, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    axes[:, :, 2] *= spread[:, 2, None] > 0
    return axes, spread[:, 1] <= _LINE_RATIO * spread[:, 2]


def _usable_stated_normals(
    stated: FloatArray | None, planes: FloatArray, straight: BoolArray, where: str, notes: list[Finding]
) -> FloatArray | None:
    """The stated normals, or None and a finding where they cannot be those of this surface."""
    if stated is None:
        return None
    given = np.linalg.norm(stated, axis=1) > 0.5
    along = np.abs((stated * planes).sum(axis=1))[given & ~straight]
    problem = None
    if not given.any():
        problem = "dummy-normals", "not used: all zero"
    elif len(along) and bool((stated == stated[0]).all()) and np.quantile(along, 0.1) < _MIN_DUMMY_AGREEMENT:
        problem = "dummy-normals", "not used: one for all, though the taxels lie on a bent surface"
    elif len(along) and np.median(along) < _MIN_MEDIAN_AGREEMENT:
        turned = np.degrees(np.arccos(np.minimum(np.median(along), 1.0)))
        problem = "foreign-normals", f"not used: turned against the taxels' surface by {turned:.0f} degrees (median)"
    if problem is None:
        return stated
    notes.append(Finding(problem[0], where, problem[1], len(stated)))
    return None


def _normals_on_lines(
    positions: FloatArray, axes: FloatArray, straight: BoolArray, stated: FloatArray | None
) -> FloatArray:
    """(n, 3) the planes' normals; on a line, square to it and as near as possible to a hint of the outside."""
    normals = axes[:, :, 0].copy()
    if straight.any():
        line = axes[straight, :, 2]
        hints = [positions[straight], axes[straight, :, 0]]  # a link's frame lies inside the link
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
    """Normals turned so that neighbours agree, and (n,) the connected sheet of each taxel."""
    count = len(near)
    rows = np.repeat(np.arange(len(near)), near.shape[1])
    columns = near.ravel()
    turn = 1.0 - np.abs((normals[rows] * normals[columns]).sum(axis=1))
    away = np.linalg.norm(positions[rows] - positions[columns], axis=1)
    # Distance decides among planes that agree equally well; and a cost of zero would be no connection at all.
    cost = turn + 0.1 * away / max(float(away.max(initial=0.0)), 1e-300) + 1e-9
    graph = coo_matrix((cost, (rows, columns)), shape=(count, count)).tocsr()
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    sheet = connected_components(tree, directed=False)[1].astype(np.int64)
    sign = np.ones(count)
    for first in np.unique(sheet, return_index=True)[1].tolist():
        order, parent = breadth_first_order(tree, first, directed=False)
        for child in order[1:].tolist():
            above = int(parent[child])
            sign[child] = sign[above] * (1.0 if normals[child] @ normals[above] >= 0 else -1.0)
    return normals * sign[:, None], sheet


def _outward_signs(
    positions: FloatArray, normals: FloatArray, sheet: IntArray, stated: FloatArray | None
) -> tuple[FloatArray, BoolArray]:
    """(sheets,) 1 or -1 by which each is turned to look outward, and whether that is more than a guess."""
    offset = positions - positions.mean(axis=0)
    votes = np.bincount(sheet, (normals * offset).sum(axis=1))
    clear = np.abs(votes) > _MIN_OUTWARD_SHARE * np.bincount(sheet, np.linalg.norm(offset, axis=1))
    # A flat sheet has no inside; a link's frame mostly lies behind its skin.
    votes = np.where(clear, votes, np.bincount(sheet, (normals * positions).sum(axis=1)))
    if stated is not None:
        agreement = np.bincount(sheet, (normals * stated).sum(axis=1))
        decided = np.abs(agreement) > 0.2 * np.bincount(sheet)
        votes = np.where(decided, agreement, votes)
        clear = clear | decided
    return np.where(votes < 0, -1.0, 1.0), clear


STAR_NEIGHBOURS = 20
"""Taxels that a star is chosen from."""
MAX_EDGE_SPACINGS = 2.2
"""No side is longer than this many spacings; a side across two rows of a hexagonal grid has 1.73, a true gap more."""
_SPACING_NEIGHBOURS = 4
"""A taxel's spacing is its mean distance to this many others."""
_MAX_SECOND_RATIO = (
    1.75  # at the tip of a triangular module of ten, the third and fourth are this far away, in spacings
)
_MIN_HEIGHT_RATIO = 0.1
"""Triangles lower than this share of their longest side lie along a straight border, and add nothing to the surface."""
_MIN_NORMAL_AGREEMENT = 0.2
"""Neighbours whose normals differ by more than about 80 degrees lie round an edge, or on the other side."""
MAX_HOLE_SIDES = 6
"""A hole with no more sides is where one taxel is missing, or where neighbourhoods disagree; it is filled."""
_MIN_FILL_AGREEMENT = 0.5
"""Least cosine between a triangle that fills a hole and the normals of its corners, so that thin tubes stay open."""
_MIN_TANGENT_DISTANCE = (
    0.01  # in spacings: a neighbour this close in the tangent plane lies above the taxel, not beside it
)
_TIE = 1e-9
_BLOCK = 512  # taxels at a time, so that memory stays below 100 MB


@dataclass(frozen=True, eq=False)
class TriangulatedTaxels:
    """Taxels joined to a surface.

    Attributes:
        mesh: Its vertices are the taxels, in order; every edge has one or two faces, every vertex one fan, or none.
        normals: (n, 3) outward unit normals of the taxels.
        spacing: (n,) distance to the taxels around each [m].
        findings: What was noticed.
    """

    mesh: Mesh
    normals: FloatArray
    spacing: FloatArray
    findings: tuple[Finding, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "normals", "spacing")


def triangulate(
    positions: FloatArray, *, normals: FloatArray | None = None, where: str = "taxels"
) -> TriangulatedTaxels:
    """Join taxels to a manifold, oriented surface that bridges no gaps.

    Where taxels are too few for a surface, or lie on a line, they stay without faces.

    Args:
        positions: (n, 3) [m], distinct.
        normals: (n, 3) that a file states; only the side they look to is used, and only where they mean something.
        where: The set's name, for findings.

    Raises:
        SkinError: There is no taxel, or two are at one place.

    Cost: 0.1 s for 1000 taxels.
    """
    _check_positions(positions, where)
    found = estimate_normals(positions, stated=normals, where=where)
    spacing = local_spacing(positions)
    none = np.zeros((0, 3), dtype=np.int64)
    faces = none if found.straight.all() else _manifold_faces(positions, found.normals, spacing)
    return TriangulatedTaxels(Mesh(positions, faces), found.normals, spacing, found.findings)


def local_spacing(positions: FloatArray) -> FloatArray:
    """(n,) mean distance of each taxel to the few nearest [m]; zero for a lone one.

    Never much more than the distance to the second: in a pair or a triplet the third and fourth are those of others.
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
    """(m, 3) faces of the surface, counter-clockwise from outside."""
    near = nearest_others(positions, STAR_NEIGHBOURS)[1]
    blocks = np.array_split(np.arange(len(positions)), -(-len(positions) // _BLOCK))
    named = np.concatenate([_local_delaunay_triangles(positions, normals, spacing, near, block) for block in blocks])
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
    positions: FloatArray, normals: FloatArray, spacing: FloatArray, near: IntArray, centres: IntArray
) -> IntArray:
    """(t, 3) the Delaunay triangles around each of ``centres``, that one first, counter-clockwise from outside.

    Turned inside out (x / |x|²), circles through the centre become lines: the triangles are the sides of the hull.
    """
    around = near[centres]
    spread = spacing[centres, None, None]
    flat = (
        np.einsum("nkd,nda->nka", positions[around] - positions[centres, None], _tangent_frames(normals[centres]))
        / spread
    )
    squared = (flat**2).sum(axis=2)
    seen = np.einsum("nkd,nd->nk", normals[around], normals[centres]) > _MIN_NORMAL_AGREEMENT
    seen &= squared > _MIN_TANGENT_DISTANCE**2
    out = np.where(seen[:, :, None], flat / np.where(seen, squared, 1.0)[:, :, None], 0.0)
    x = out[:, :, 0]
    y = out[:, :, 1]
    inside = x[:, :, None] * y[:, None] - y[:, :, None] * x[:, None]  # on which side of the line from i to j it is
    n, i, j = np.nonzero((inside > _TIE) & seen[:, :, None] & seen[:, None])
    width = x[n, j] - x[n, i]
    height = y[n, j] - y[n, i]
    level = inside[n, i, j]
    for k in range(near.shape[1]):  # the nearest neighbours reject most lines
        hull = width * y[n, k] - height * x[n, k] + level >= -_TIE
        n, i, j, width, height, level = (part[hull] for part in (n, i, j, width, height, level))
    return np.stack([centres[n], around[n, i], around[n, j]], axis=1)


def _tangent_frames(normals: FloatArray) -> FloatArray:
    """(n, 3, 2) two unit directions as columns that make a right-handed frame with each normal."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=2)


def _count_votes(named: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Each triangle once, turned as most of its corners see it, and how many of them named it."""
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
    taken: set[tuple[int, int]] = set()
    laid = []
    for number, (a, b, c) in zip(order.tolist(), faces[order].tolist(), strict=True):
        sides = {(a, b), (b, c), (c, a)}
        if taken.isdisjoint(sides):
            taken |= sides
            laid.append(number)
    return np.array(laid, dtype=np.int64)


def _keep_largest_fans(faces: IntArray) -> IntArray:
    """The faces less those of all but the largest fan at each vertex."""
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
    """Faces (f, 3) for each hole with few sides, where they look outward and no side is too long."""
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
    """(k - 2, 3) triangles of a polygon (k,), each time the one with the shortest third side; None where one is bad."""
    corners = loop.tolist()
    ears = []
    while len(corners) >= 3:
        ring = np.array(corners)
        ear = np.stack([np.roll(ring, 1), ring, np.roll(ring, -1)], axis=1)
        normal = np.cross(positions[ear[:, 1]] - positions[ear[:, 0]], positions[ear[:, 2]] - positions[ear[:, 0]])
        length = np.linalg.norm(positions[ear[:, 2]] - positions[ear[:, 0]], axis=1)
        facing = np.einsum("kcd,kd->kc", normals[ear], normal).min(axis=1)
        good = facing > _MIN_FILL_AGREEMENT * np.linalg.norm(normal, axis=1)
        good &= length <= MAX_EDGE_SPACINGS * np.minimum(spacing[ear[:, 0]], spacing[ear[:, 2]])
        if not good.any():
            return None
        best = int(np.where(good, length, np.inf).argmin())
        ears.append(ear[best])
        del corners[best]
    return np.array(ears)
