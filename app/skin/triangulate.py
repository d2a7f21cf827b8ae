"""A surface through taxels that come without one: triangles that their neighbourhoods agree on.

Each taxel looks at its neighbours in its own tangent plane and names the triangles that it would have in a Delaunay
triangulation there. Triangles that at least two of their corners name are laid down, the surest first, where they fit:
no edge gets a third face, no vertex a second fan, no two neighbours look to different sides. No side is longer than the
taxels around it allow, so that gaps between patches stay gaps. (After Gopi, Krishnan and Silva 2000, "Surface
reconstruction based on lower dimensional localized Delaunay triangulation".) Nothing here calls native geometry code.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray, readonly
from app.errors import Finding, SkinError
from app.geometry.mesh import Mesh
from app.geometry.orient import paired_sides
from app.geometry.split import split
from app.geometry.topology import boundary_loops, edge_table
from app.skin.normals import estimate_normals

NEIGHBOURS = 20
"""Taxels that a star is chosen from."""
LONGEST = 2.2
"""No side is longer than this many spacings; a side across two rows of a hexagonal grid has 1.73, a true gap more."""
_AROUND = 4
"""A taxel's spacing is its mean distance to this many others."""
_SECOND = 1.75  # at the tip of a triangular module of ten, the third and fourth are this far away, in spacings
_FLATTEST = 0.1
"""Triangles lower than this share of their longest side lie along a straight border, and add nothing to the surface."""
_FACING = 0.2
"""Neighbours whose normals differ by more than about 80 degrees lie round an edge, or on the other side."""
LARGEST_HOLE = 6
"""A hole with no more sides is where one taxel is missing, or where neighbourhoods disagree; it is filled."""
_LEVEL = 0.5
"""What fills a hole lies within 60 degrees of its corners' tangent planes, so that no thin tube gets a lid."""
_UPRIGHT = 0.01  # in spacings: a neighbour this close in the tangent plane lies above the taxel, not beside it
_TIE = 1e-9
_BLOCK = 512  # taxels at a time, so that memory stays below 100 MB


@dataclass(frozen=True, eq=False)
class Triangulated:
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
        object.__setattr__(self, "normals", readonly(self.normals))
        object.__setattr__(self, "spacing", readonly(self.spacing))


def triangulate(positions: FloatArray, *, normals: FloatArray | None = None, where: str = "taxels") -> Triangulated:
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
    _refuse_unfit(positions, where)
    found = estimate_normals(positions, stated=normals, where=where)
    spacing = spacings(positions)
    none = np.zeros((0, 3), dtype=np.int64)
    faces = none if found.straight.all() else _joined(positions, found.normals, spacing)
    return Triangulated(Mesh(positions, faces), found.normals, spacing, found.findings)


def spacings(positions: FloatArray) -> FloatArray:
    """(n,) mean distance of each taxel to the few nearest [m]; zero for a lone one.

    Never much more than the distance to the second: in a pair or a triplet the third and fourth are those of others.
    """
    k = min(_AROUND, len(positions) - 1)
    if k == 0:
        return np.zeros(len(positions))
    away = cKDTree(positions).query(positions, k=k + 1)[0][:, 1:]
    return np.minimum(away.mean(axis=1), _SECOND * away[:, min(k, 2) - 1])


def _refuse_unfit(positions: FloatArray, where: str) -> None:
    if not len(positions):
        raise SkinError("there are no taxels", file=where)
    if not np.isfinite(positions).all():
        raise SkinError("a position is not a finite number", file=where)
    if len(np.unique(positions, axis=0)) < len(positions):
        raise SkinError("two taxels are at one place", file=where, remedy="Leave one of them out")


def _joined(positions: FloatArray, normals: FloatArray, spacing: FloatArray) -> IntArray:
    """(m, 3) faces of the surface, counter-clockwise from outside."""
    near = _near(positions)
    blocks = np.array_split(np.arange(len(positions)), -(-len(positions) // _BLOCK))
    named = np.concatenate([_stars(positions, normals, spacing, near, block) for block in blocks])
    faces, votes = _counted(named, len(positions))
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2)
    sides = np.diff(positions[ends], axis=2)[:, :, 0]
    lengths = np.linalg.norm(sides, axis=2)
    height = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / lengths.max(axis=1)
    fit = (lengths <= LONGEST * spacing[ends].min(axis=2)).all(axis=1) & (height > _FLATTEST * lengths.max(axis=1))
    faces, votes = faces[fit], votes[fit]
    order = np.lexsort((lengths[fit].max(axis=1), -votes))
    sure = order[votes[order] >= 2]
    laid = _single_fans(faces[_fitting(faces, sure)])
    return np.concatenate([laid, *_small_holes_filled(laid, positions, normals, spacing)])


def _near(positions: FloatArray) -> IntArray:
    """(n, k) the nearest other taxels, which the stars are made of."""
    k = min(NEIGHBOURS, len(positions) - 1)
    return np.asarray(cKDTree(positions).query(positions, k=k + 1)[1][:, 1:], dtype=np.int64)


def _stars(
    positions: FloatArray, normals: FloatArray, spacing: FloatArray, near: IntArray, centres: IntArray
) -> IntArray:
    """(t, 3) the Delaunay triangles around each of ``centres``, that one first, counter-clockwise from outside.

    Turned inside out (x / |x|²), circles through the centre become lines: the triangles are the sides of the hull.
    """
    around, spread = near[centres], spacing[centres, None, None]
    flat = np.einsum("nkd,nda->nka", positions[around] - positions[centres, None], _tangents(normals[centres])) / spread
    squared = (flat**2).sum(axis=2)
    seen = np.einsum("nkd,nd->nk", normals[around], normals[centres]) > _FACING
    seen &= squared > _UPRIGHT**2
    out = np.where(seen[:, :, None], flat / np.where(seen, squared, 1.0)[:, :, None], 0.0)
    x, y = out[:, :, 0], out[:, :, 1]
    width, height = x[:, None] - x[:, :, None], y[:, None] - y[:, :, None]  # of the line from i to j
    inside = x[:, :, None] * y[:, None] - y[:, :, None] * x[:, None]  # on which side of it the centre lies
    beyond = width[..., None] * y[:, None, None] - height[..., None] * x[:, None, None]
    hull = (beyond + inside[..., None] >= -_TIE).all(axis=3) & (inside > _TIE)
    hull &= seen[:, :, None] & seen[:, None]
    n, i, j = np.nonzero(hull)
    return np.stack([centres[n], around[n, i], around[n, j]], axis=1)


def _tangents(normals: FloatArray) -> FloatArray:
    """(n, 3, 2) two unit directions as columns that make a right-handed frame with each normal."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = np.cross(normals, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normals, first)], axis=2)


def _counted(named: IntArray, count: int) -> tuple[IntArray, IntArray]:
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


def _fitting(faces: IntArray, order: IntArray) -> IntArray:
    """Those of ``order`` that can be laid one after the other, each directed side at most once."""
    taken: set[tuple[int, int]] = set()
    laid = []
    for number, (a, b, c) in zip(order.tolist(), faces[order].tolist(), strict=True):
        sides = {(a, b), (b, c), (c, a)}
        if taken.isdisjoint(sides):
            taken |= sides
            laid.append(number)
    return np.array(laid, dtype=np.int64)


def _single_fans(faces: IntArray) -> IntArray:
    """The faces less those of all but the largest fan at each vertex."""
    while len(faces):
        copies, vertex_of = split(faces, paired_sides(faces))
        size = np.bincount(copies.ravel(), minlength=len(vertex_of))
        order = np.lexsort((np.arange(len(size)), -size, vertex_of))
        largest = np.zeros(len(size), dtype=bool)
        largest[order[np.unique(vertex_of[order], return_index=True)[1]]] = True
        keep = largest[copies].all(axis=1)
        if keep.all():
            break
        faces = faces[keep]
    return faces


def _small_holes_filled(
    faces: IntArray, positions: FloatArray, normals: FloatArray, spacing: FloatArray
) -> list[IntArray]:
    """Faces (f, 3) for each hole with few sides, where they look outward and no side is too long."""
    edges = {tuple(edge) for edge in edge_table(faces).edges.tolist()}
    filled = []
    for loop in boundary_loops(faces):
        ears = _ears(loop[::-1], positions, normals, spacing) if len(loop) <= LARGEST_HOLE else None
        if ears is not None and edges.isdisjoint(new := {tuple(sorted(ear[[0, 2]].tolist())) for ear in ears[:-1]}):
            edges |= new
            filled.append(ears)
    return filled


def _ears(loop: IntArray, positions: FloatArray, normals: FloatArray, spacing: FloatArray) -> IntArray | None:
    """(k - 2, 3) triangles of a polygon (k,), each time the one with the shortest third side; None where one is bad."""
    corners, ears = loop.tolist(), []
    while len(corners) >= 3:
        ring = np.array(corners)
        ear = np.stack([np.roll(ring, 1), ring, np.roll(ring, -1)], axis=1)
        normal = np.cross(positions[ear[:, 1]] - positions[ear[:, 0]], positions[ear[:, 2]] - positions[ear[:, 0]])
        length = np.linalg.norm(positions[ear[:, 2]] - positions[ear[:, 0]], axis=1)
        facing = np.einsum("kcd,kd->kc", normals[ear], normal).min(axis=1)
        good = facing > _LEVEL * np.linalg.norm(normal, axis=1)
        good &= length <= LONGEST * np.minimum(spacing[ear[:, 0]], spacing[ear[:, 2]])
        if not good.any():
            return None
        best = int(np.where(good, length, np.inf).argmin())
        ears.append(ear[best])
        del corners[best]
    return np.array(ears)
