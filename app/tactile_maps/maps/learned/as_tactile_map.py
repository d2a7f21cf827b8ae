"""A learned map made a tactile map, so that image, contact regions and control work on it as on any other.

What a learned map lacks is a surface. Its taxels have places on the body and places in the plane, and nothing says
what lies between them; so triangles over the taxels are drawn in the plane, and the same triangles between the taxels'
places on the body are the surface behind the map. It is coarse (one corner a taxel), and where learning went wrong it
is crumpled or turned inside out, as it should be: a point of the map is back-projected to where the learned map says
it lies.

Decided, and why:

- One chart for each patch, as on every map, though learning knows no patches. A place on the body belongs to one link
  and moves with it, so a triangle between taxels of two links lies nowhere. Such triangles are not made; a finding
  counts those that the learned plane would have had, which is what it learned of the robot touching itself. Charts are
  arranged side by side like any others, so nothing overlaps even where learning put two patches on the same place.
- The border is the characteristic shape of the patch's taxels (``characteristic_shape``: their triangulation with the
  sides that are too long taken away from outside): one piece, no holes, every taxel a corner, nothing turned over. Gaps
  open to the outside are not bridged. Those inside must be, and a finding counts them.
- The scale makes the median side of a triangle as long as on the body: a patch has an area of its own only if the
  map is right, and a few wild triangles would spoil it, but not the median.
- Touch cannot tell a map from its mirror image: the one is taken whose triangles look outwards on the body, by area.
- Taxels learned to lie on the very same place are moved apart by a thousandth of their spacing; a finding counts them.
- A taxel that never felt anything is no corner. Pressure needs a place, should it wake up: it lies on the triangle
  nearest to it on the body, and a finding names it.
- Areas, normals, neighbours and quadrature of the taxels are the skin's own. The map's skin can be pressed like the
  original and reads the same, bit for bit; its surface points are not the original's, for the triangles are others.
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
"""A triangle with less area for its longest side's square is a line by rounding."""


@dataclass(frozen=True, eq=False)
class CharacteristicShape:
    """Triangles over points.

    Attributes:
        faces: (m, 3) counter-clockwise; together a disk with one simple border.
        bridging: How many have a side that is too long, yet hold the disk together or span a hole inside.
    """

    faces: IntArray
    bridging: int


def characteristic_shape(points: FloatArray) -> CharacteristicShape:
    """The characteristic shape of ``points`` (n, 2): Duckham, Kulik, Worboys and Galton 2008.

    From the convex hull's Delaunay triangles, those at the border whose outer side is longer than ``LONGEST_SIDE``
    spacings are taken off, the longest first, as long as what is left is one piece with a simple border through all of
    its corners. So every point stays a corner, nothing is folded, and gaps open to the outside are not bridged; a gap
    inside, and what ties two far groups together, must be.

    Args:
        points: (n, 2), no two the same.

    Raises:
        MapError: Fewer than three points, or all in one line.

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
        raise MapError("taxels lie in one line on the learned map", value=f"{int(thin[kept].sum())} triangles")
    return CharacteristicShape(faces[kept], int((longest[kept] > limit).sum()))


def longest_side(points: FloatArray) -> float:
    """Triangles over ``points`` (n, 2) with a longer side bridge a gap."""
    return LONGEST_SIDE * float(np.median(cKDTree(points).query(points, 2)[0][:, 1]))


def _peeled(faces: IntArray, sides: FloatArray, limit: float) -> IntArray:
    """Numbers of the faces (m,) that stay.

    Args:
        faces: (m, 3).
        sides: (m, 3) length from corner k to corner k + 1.
        limit: Longer sides go.
    """
    beside = {(int(face[k]), int(face[(k + 1) % 3])): (n, k) for n, face in enumerate(faces) for k in range(3)}
    border = {start for start, end in beside if (end, start) not in beside}
    border |= {end for start, end in beside if (end, start) not in beside}
    queue = [(-sides[n, k], n, k) for (start, end), (n, k) in beside.items() if (end, start) not in beside]
    queue = [item for item in queue if -item[0] > limit]
    heapq.heapify(queue)
    gone: set[int] = set()
    while queue and len(gone) < len(faces) - 1:
        _, number, k = heapq.heappop(queue)
        corner = int(faces[number, (k + 2) % 3])
        if corner in border:
            continue  # taking it off would cut the piece in two, or leave a corner without a face
        gone.add(number)
        border.add(corner)
        for turn in (1, 2):
            start = int(faces[number, (k + turn) % 3])
            end = int(faces[number, (k + turn + 1) % 3])
            other, side = beside[end, start]
            if sides[other, side] > limit:
                heapq.heappush(queue, (-sides[other, side], other, side))
    return np.setdiff1d(np.arange(len(faces)), np.array(sorted(gone), dtype=np.int64))


_APART = 1e-3
_GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))


def learned_tactile_map(skin: Skin, learned: LearnedMap) -> TactileMap:
    """A tactile map with the taxels where ``learned`` puts them; see this file's text for what was decided.

    Args:
        skin: Whose taxels were learned; their numbers are kept.
        learned: A place for each of them.

    Raises:
        MapError: Not as many places as taxels, or a patch with fewer than three placed taxels not in one line.

    Cost: 70 ms for 1000 taxels.
    """
    if len(learned.points) != len(skin):
        raise MapError(
            "the learned map is of another skin",
            value=f"{len(learned.points)} places for {len(skin)} taxels",
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
    """The patch over the learned triangles, and its chart."""
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
    """The taxels, told where they sit on the new surface: ``corners`` (k,) at its vertices, others nearest."""
    faces, weights, _ = ClosestPoint(surface).query(taxels.positions)
    order = np.argsort(surface.faces.ravel(), kind="stable")
    at = order[np.searchsorted(surface.faces.ravel()[order], np.arange(len(corners)))]
    faces[corners] = at // 3
    weights[corners] = np.eye(3)[at % 3]
    positions = surface.points(faces, weights)
    positions[corners] = taxels.positions[corners]
    return replace(taxels, positions=positions, faces=faces, weights=weights)


def _distinct(points: FloatArray) -> tuple[FloatArray, int]:
    """Points moved on small spirals where several lie on the same place, and how many were."""
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
    """Plane and faces as they are or mirrored, whichever has more area look along the taxels' normals."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    if (np.cross(b - a, c - a) * normals[faces].sum(axis=1)).sum() >= 0:
        return plane, faces
    return plane * [-1.0, 1.0], faces[:, ::-1]


def _scale(plane: FloatArray, faces: IntArray, positions: FloatArray) -> float:
    """How many metres of the body the median side of a triangle has for its length in the plane."""
    on_body, in_plane = (np.linalg.norm(x[faces] - np.roll(x[faces], 1, axis=1), axis=2) for x in (positions, plane))
    return float(np.median(on_body) / np.median(in_plane))


def _between_patches(skin: Skin, learned: LearnedMap) -> tuple[Finding, ...]:
    """How many triangles of the whole learned plane would have corners on two patches."""
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
