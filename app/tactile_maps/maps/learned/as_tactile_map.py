"""Conversion of a learned map to a tactile map, for images, contact regions and control.

A learned map has no surface: its taxels have positions on the body and in the plane, with nothing between them. So the
taxels are triangulated in the plane, and the same triangles between the taxels' positions on the body are the surface
of the map. It is coarse (one corner per taxel), and where learning failed it is crumpled or turned inside out, as it
should be: a point of the map is back-projected to where the learned map places it.

Decisions:

- One chart per patch, as on every map, though learning does not know patches. A point on the body belongs to one link
  and moves with it, so a triangle between taxels of two links has no position. Such triangles are not created; a
  finding counts those that the learned plane would have had, which is what it learned of the robot touching itself.
  Charts are packed side by side like any others, so nothing overlaps even if learning placed two patches at one
  position.
- The border is the characteristic shape of the patch's taxels (``characteristic_shape``: their triangulation without
  sides that are too long, removed from outside): one component, no holes, every taxel a corner, nothing flipped. Gaps
  open to the outside are not bridged. Gaps inside must be, and a finding counts them.
- The scale makes the median side of a triangle as long as on the body. The area of a patch is meaningful only if the
  map is correct, and a few wild triangles would change it, but not the median.
- Touch does not distinguish a map from its mirror image: the one with more area facing outward on the body is used.
- Taxels learned at exactly the same position are separated by a thousandth of their spacing; a finding counts them.
- A taxel that was never touched is not a corner. In case it responds later, it is placed on the closest triangle on the
  body, and a finding names it.
- Areas, normals, neighbours and quadrature of the taxels are those of the skin. The skin of the map can be pressed like
  the original and has the same readings, bit for bit; its surface points differ, because its triangles do.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, MapError
from tactile_maps.flattening.bijectivity import signed_areas
from tactile_maps.flattening.chart import Chart, canonical_pose
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.learned.learned_map import LearnedMap
from tactile_maps.maps.model.interpolation import LONGEST_SIDE
from tactile_maps.maps.model.layout import pack_charts
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin, Taxels

_THINNEST = 1e-9
"""Area over squared longest side below which a triangle is a line by rounding."""


@dataclass(frozen=True, eq=False)
class CharacteristicShape:
    """Triangulation of points.

    Attributes:
        faces: (m, 3) counter-clockwise; a disk with one simple border.
        bridging: Number of triangles with a side that is too long but needed for connection or for a hole inside.
    """

    faces: IntArray
    bridging: int


def characteristic_shape(points: FloatArray) -> CharacteristicShape:
    """Compute the characteristic shape of ``points`` (n, 2): Duckham, Kulik, Worboys and Galton 2008.

    Starting from the Delaunay triangulation, triangles at the border whose outer side is longer than ``LONGEST_SIDE``
    spacings are removed, longest first, as long as the rest is one component with a simple border through all of its
    corners. So every point remains a corner, nothing is folded, and gaps open to the outside are not bridged. Gaps
    inside and connections between two distant groups are.

    Args:
        points: (n, 2), all different.

    Raises:
        MapError: Fewer than three points, or all collinear.

    Cost: 15 ms for 1000 points.
    """
    try:
        faces = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    except (QhullError, ValueError) as error:
        raise MapError(
            "taxels in one line span no map", value=f"{len(points)} points", remedy="Record touches all over the skin"
        ) from error
    faces = np.where((signed_areas(points, faces) < 0)[:, None], faces[:, ::-1], faces)
    sides = np.linalg.norm(points[faces] - np.roll(points[faces], -1, axis=1), axis=2)
    longest = sides.max(axis=1)
    limit = longest_side(points)
    thin = signed_areas(points, faces) <= _THINNEST * longest**2
    kept = _peeled(faces, np.where(thin[:, None], np.inf, sides), limit)
    if thin[kept].any():
        raise MapError("taxels are in one line on the learned map", value=f"{int(thin[kept].sum())} triangles")
    return CharacteristicShape(faces[kept], int((longest[kept] > limit).sum()))


def longest_side(points: FloatArray) -> float:
    """Return the length above which sides of triangles over ``points`` (n, 2) bridge a gap."""
    return LONGEST_SIDE * float(np.median(cKDTree(points).query(points, 2)[0][:, 1]))


def _peeled(faces: IntArray, sides: FloatArray, limit: float) -> IntArray:
    """Return the indices of the faces that remain.

    Args:
        faces: (m, 3).
        sides: (m, 3) length from corner k to corner k + 1.
        limit: Length above which border sides are removed.
    """
    halfedges = {(int(face[k]), int(face[(k + 1) % 3])): (n, k) for n, face in enumerate(faces) for k in range(3)}
    border = {start for start, end in halfedges if (end, start) not in halfedges}
    border |= {end for start, end in halfedges if (end, start) not in halfedges}
    queue = [(-sides[n, k], n, k) for (start, end), (n, k) in halfedges.items() if (end, start) not in halfedges]
    queue = [item for item in queue if -item[0] > limit]
    heapq.heapify(queue)
    gone: set[int] = set()
    while queue and len(gone) < len(faces) - 1:
        _, number, k = heapq.heappop(queue)
        corner = int(faces[number, (k + 2) % 3])
        if corner in border:
            continue  # its removal would split the shape, or leave a corner without a face
        gone.add(number)
        border.add(corner)
        for turn in (1, 2):
            start = int(faces[number, (k + turn) % 3])
            end = int(faces[number, (k + turn + 1) % 3])
            other, side = halfedges[end, start]
            if sides[other, side] > limit:
                heapq.heappush(queue, (-sides[other, side], other, side))
    return np.setdiff1d(np.arange(len(faces)), np.array(sorted(gone), dtype=np.int64))


_APART = 1e-3
_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def learned_tactile_map(skin: Skin, learned: LearnedMap) -> TactileMap:
    """Return a tactile map with the taxels at their ``learned`` positions; see the module's decisions.

    Args:
        skin: Skin of the taxels; their numbers are kept.
        learned: A position for each taxel.

    Raises:
        MapError: The numbers of positions and taxels differ, or a patch has fewer than three placed taxels, or
            collinear ones.

    Cost: 70 ms for 1000 taxels.
    """
    if len(learned.points) != len(skin):
        raise MapError(
            "the learned map belongs to another skin",
            value=f"{len(learned.points)} positions for {len(skin)} taxels",
            remedy="Learn from readings of this skin",
        )
    between = _between_patches(skin, learned)
    patches = []
    charts = []
    for patch, first, last in zip(skin.patches, skin.first[:-1], skin.first[1:], strict=True):
        crumpled, chart = _mapped(patch, learned.points[first:last], learned.placed[first:last])
        patches.append(crumpled)
        charts.append(replace(chart, method=learned.method, seconds=(learned.seconds,)))
    if charts:
        charts[0] = replace(charts[0], findings=(*learned.findings, *between, *charts[0].findings))
    return TactileMap(replace(skin, patches=tuple(patches)), tuple(charts), pack_charts(charts))


def _mapped(patch: Patch, points: FloatArray, placed: BoolArray) -> tuple[Patch, Chart]:
    """Return the patch over the learned triangles, and its chart."""
    corners = np.flatnonzero(placed)
    if len(corners) < 3:
        raise MapError(
            "fewer than three taxels of a patch were touched",
            place=f"patch {patch.name}",
            value=len(corners),
            remedy="Record touches on it too, or leave it out of the skin",
        )
    plane, moved = _distinct(points[corners])
    shape = characteristic_shape(plane)
    positions = patch.taxels.positions[corners]
    plane, faces = _facing_outwards(plane, shape.faces, positions, patch.taxels.normals[corners])
    plane = canonical_pose(plane * _scale(plane, faces, positions), positions)
    surface = Mesh(positions, faces)
    notes = [
        ("taxels-on-one-place", "moved apart by a thousandth of their spacing", moved),
        ("gaps-bridged", "long triangles kept inside the map or to connect it", shape.bridging),
        ("taxels-without-place", "placed on the nearest triangle on the body", int((~placed).sum())),
    ]
    findings = tuple(Finding(kind, patch.name, action, count) for kind, action, count in notes if count)
    none = np.zeros((0, 2), dtype=np.int64)
    chart = Chart(faces, plane, np.arange(len(corners)), none, "", findings=findings)
    return replace(patch, surface=surface, taxels=_on(surface, patch.taxels, corners)), chart


def _on(surface: Mesh, taxels: Taxels, corners: IntArray) -> Taxels:
    """Return the taxels on the new surface: ``corners`` (k,) at its vertices, others at the closest point."""
    faces, weights, _ = ClosestPoint(surface).query(taxels.positions)
    order = np.argsort(surface.faces.ravel(), kind="stable")
    at = order[np.searchsorted(surface.faces.ravel()[order], np.arange(len(corners)))]
    faces[corners] = at // 3
    weights[corners] = np.eye(3)[at % 3]
    positions = surface.points(faces, weights)
    positions[corners] = taxels.positions[corners]
    return replace(taxels, positions=positions, faces=faces, weights=weights)


def _distinct(points: FloatArray) -> tuple[FloatArray, int]:
    """Return the points with coinciding ones moved on small spirals, and their number."""
    spacing = float(np.median(cKDTree(points).query(points, 2)[0][:, 1])) or float(np.ptp(points, axis=0).max())
    near = _APART * spacing
    _, place, count = np.unique(np.rint(points / (near or 1.0)), axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(place.ravel(), kind="stable")
    turn = np.empty(len(points))
    turn[order] = np.arange(len(points)) - np.repeat(np.cumsum(count) - count, count)
    spiral = near * np.sqrt(turn)[:, None] * np.stack([np.cos(_GOLDEN_ANGLE * turn), np.sin(_GOLDEN_ANGLE * turn)], 1)
    return points + spiral, int((turn > 0).sum())


def _facing_outwards(
    plane: FloatArray, faces: IntArray, positions: FloatArray, normals: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Return plane and faces, mirrored if more area then faces along the taxels' normals."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    if (np.cross(b - a, c - a) * normals[faces].sum(axis=1)).sum() >= 0:
        return plane, faces
    return plane * [-1.0, 1.0], faces[:, ::-1]


def _scale(plane: FloatArray, faces: IntArray, positions: FloatArray) -> float:
    """Return the ratio of the median side of a triangle on the body to that in the plane."""
    on_body, in_plane = (np.linalg.norm(x[faces] - np.roll(x[faces], 1, axis=1), axis=2) for x in (positions, plane))
    return float(np.median(on_body) / np.median(in_plane))


def _between_patches(skin: Skin, learned: LearnedMap) -> tuple[Finding, ...]:
    """Return a finding with the number of triangles of the whole learned plane between patches."""
    taxels = np.flatnonzero(learned.placed)
    if len(skin.patches) < 2 or len(taxels) < 3:
        return ()
    points = _distinct(learned.points[taxels])[0]
    try:
        faces = Delaunay(points).simplices
    except QhullError:
        return ()
    sides = np.linalg.norm(points[faces] - np.roll(points[faces], 1, axis=1), axis=2)
    patch = skin.patch_of[taxels][faces]
    mixed = (patch != patch[:, :1]).any(axis=1) & (sides.max(axis=1) <= longest_side(points))
    count = int(mixed.sum())
    return (
        (Finding("triangles-between-patches", "skin", "left out: their taxels are on different links", count),)
        if count
        else ()
    )
