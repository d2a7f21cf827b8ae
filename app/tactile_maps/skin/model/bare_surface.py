"""Points on the parts of skinned links that no taxel reads: they bear load like skin.

These are the faces of a patch that belong to no taxel, such as gaps between modules, and the parts of the link that
skin does not cover. ``with_bare_points`` samples the mesh of each skinned link like its skin. Points that no
body can reach are left out:

- Mesh under skin. The closest point of the skin is not on its border and faces the same way. It is above the mesh by
  less than ``_DEEPEST``, or below it by less than ``_MISFIT``: skin fitted from measured taxels may be in the mesh.
- Mesh hidden in the link, such as motors in a shell: no free straight line leads from its outward side to the outside.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.caches import content_cache, weak_cache
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.surface.closest_point import ClosestPoint, closest_point
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.geometry.surface.point_location import owner_and_rank
from tactile_maps.geometry.surface.points import sums_by_label
from tactile_maps.geometry.surface.raycast import seen_from_outside
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import BarePoints, Patch, Skin

_MOST_POINTS = 20_000
"""Points of one link, about; the bare surface of a large link with fine skin is sampled more coarsely than the skin."""
_MISFIT = 0.01
"""Height of mesh above skin [m] up to which the mesh counts as covered."""
_DEEPEST = 0.03
"""Depth of mesh below skin [m] up to which the mesh counts as covered; what is deeper may face a gap under the skin."""
_MOST_LINKS = 64
"""Links whose points are kept: those of scenes that may be opened again, and of edits that may be undone."""
_COARSENESS = 4
_NEAR = 1.4
"""Faces of ``_COARSENESS`` spacings are halved where the border is nearer than ``_NEAR`` times their size."""
_PARTS = 8
"""Points to which the border is sampled, for an edge of median length."""
_LEAST_COSINE = 0.05
"""Cosine between the normals of mesh and skin below which the skin does not cover the mesh."""
_CORNERS = 0.97 * np.eye(3) + 0.01
"""Barycentric weights of a point in each corner of a face."""
_UNREAD_AREA = 1e-6
"""Share of a patch's area that is rounding."""
_ON_EDGE = 1e-6
"""Barycentric weight below which a point is on the opposite edge of its triangle."""


def with_bare_points(robot: Robot, skin: Skin) -> Skin:
    """Return the skin with the bare points of its links; the same skin where there are none.

    A link without a mesh, or with a placeholder for a missing mesh, has none beyond those of its patches.

    Cost: 0.35 s of one core for 1,000 taxels on three links of an arm; once for each link and its skin.
    """
    loaded = _loaded(robot, skin)
    return skin if loaded is None else loaded


@weak_cache
def _loaded(robot: Robot, skin: Skin) -> Skin | None:
    parts = list(map(_unread_faces, skin.patches))
    for name in skin.links:
        link = robot.link(name)
        patches = [patch for patch in skin.patches if patch.link == name]
        if link.mesh is not None and not link.missing and link.mesh.area > 0:
            parts.append(BarePoints(name, *_bare_points(link.mesh, patches)))
    bare = tuple(part for part in parts if len(part.areas))
    return replace(skin, bare_points=bare) if bare else None


def _unread_faces(patch: Patch) -> BarePoints:
    """Return the centres of the faces that belong to no taxel: those without a quadrature point."""
    surface = patch.surface
    read = patch.taxels.quadrature
    unread = surface.face_areas > 0
    if surface.area - read.areas.sum() <= _UNREAD_AREA * surface.area:
        unread[:] = False
    else:
        unread[closest_point(surface).query(read.positions)[0]] = False
    return BarePoints(
        patch.link, surface.face_centres[unread], surface.face_normals[unread], surface.face_areas[unread]
    )


def _content(mesh: Mesh, patches: Sequence[Patch]) -> Iterator[FloatArray | IntArray]:
    for surface in (mesh, *(patch.surface for patch in patches)):
        yield surface.vertices
        yield surface.faces
    for patch in patches:
        yield patch.taxels.quadrature.areas


@content_cache(_content, most=_MOST_LINKS)
def _bare_points(mesh: Mesh, patches: Sequence[Patch]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return points (k, 3), outward normals (k, 3) and areas (k,) of the bare part of a link with these patches."""
    areas = np.concatenate([patch.taxels.quadrature.areas for patch in patches])
    none = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    if not len(areas):
        return none
    spacing = max(float(np.sqrt(np.median(areas))), float(np.sqrt(mesh.area / _MOST_POINTS)))
    cover = _Cover([patch.surface for patch in patches])
    centres, normals, face_areas = _bare_faces(mesh, cover, spacing)
    if not len(centres):
        return none
    group, largest = _grouped(centres, normals, face_areas, spacing)
    seen = seen_from_outside(join_meshes([mesh, *cover.surfaces]), centres[largest], normals[largest])
    total = np.bincount(group, face_areas).astype(np.float64)
    middles, outward = (
        sums_by_label(group, face_areas[:, None] * rows) / total[:, None] for rows in (centres, normals)
    )
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return middles[seen], outward[seen], total[seen]


def _bare_faces(mesh: Mesh, cover: _Cover, spacing: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the centres, normals and bare areas of the faces of ``mesh``, divided to ``spacing`` [m].

    A face that the border crosses counts in part. Faces are divided before it is known whether they are covered only
    near the border.
    """
    longest = _COARSENESS * spacing
    rest = mesh
    kept = list[tuple[FloatArray, FloatArray, FloatArray]]()
    while True:
        rest = subdivide(rest, longest=longest).mesh
        share, middles, from_border = cover.bare_part(rest)
        near = (from_border < _NEAR * longest) & (longest > spacing)
        bare = (share > 0) & ~near & (rest.face_areas > 0)
        whole = bare & (share == 1)
        fine = subdivide(Mesh(rest.vertices, rest.faces[whole]), longest=spacing).mesh
        kept.append((fine.face_centres, fine.face_normals, fine.face_areas))
        cut = bare & ~whole
        kept.append((middles[cut], rest.face_normals[cut], rest.face_areas[cut] * share[cut]))
        if not near.any():
            centres, normals, areas = (np.concatenate(column) for column in zip(*kept, strict=True))
            return centres, normals, areas
        rest = Mesh(rest.vertices, rest.faces[near])
        longest = max(0.5 * longest, spacing)


class _Cover:
    """The skin of one link as one surface. Patches that share vertices are joined, so that a seam is not a border."""

    def __init__(self, surfaces: list[Mesh]) -> None:
        self.surfaces = surfaces
        whole = join_meshes(surfaces)
        vertices, number = np.unique(np.round(whole.vertices, 9), axis=0, return_inverse=True)
        self._mesh = Mesh(vertices, number.reshape(-1)[whole.faces])
        self._closest = ClosestPoint(self._mesh)
        table = self._mesh.connectivity
        self._border_edge = (table.face_count == 1)[table.edge_of]
        self._border_vertex = np.zeros(len(vertices), dtype=bool)
        self._border_vertex[table.boundary_edges] = True
        self._border = _along(vertices, table.boundary_edges)

    def bare_part(self, mesh: Mesh) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return for each face of the link the share (m,) that is bare, the middle (m, 3) of that part [m], and the
        distance (m,) along the skin from the place under the face to the border [m].
        """
        middles = mesh.face_centres
        covered, distance, cosine = self._under(middles, mesh.face_normals)
        share = np.where(covered, 0.0, 1.0)
        width = np.sqrt(2 * mesh.face_areas) * cosine  # as seen along the skin's normal
        near = np.flatnonzero((cosine > _LEAST_COSINE) & (distance < 0.5 * width))
        # A face that ends at the border, as on a sharp edge of the link, is not crossed by it.
        corners = mesh.corners[near]
        inside = self._under((_CORNERS @ corners).reshape(-1, 3), np.repeat(mesh.face_normals[near], 3, axis=0))[0]
        inside = inside.reshape(-1, 3)
        for count in (1, 2):
            crossed = inside.sum(axis=1) == count
            # the corner on its own
            faces = near[crossed]
            tips = corners[crossed][inside[crossed] == (count == 1)]
            part = np.clip(0.5 + np.where(covered[faces], -1, 1) * distance[faces] / width[faces], 0.0, 1.0)
            # The border cuts off a triangle similar to the face, about the corner on its own.
            cut = part if count == 2 else 1 - part
            tip = tips + np.sqrt(cut)[:, None] * (middles[faces] - tips)
            rest = middles[faces] + (cut / np.maximum(1 - cut, 1e-9))[:, None] * (middles[faces] - tip)
            share[faces] = part
            middles[faces] = tip if count == 2 else rest
        return share, middles, distance

    def _under(self, points: FloatArray, normals: FloatArray) -> tuple[BoolArray, FloatArray, FloatArray]:
        """Return whether skin covers each point of the link (k,), the distance along the skin from there to the border
        (k,) [m], and the cosine of the point's normal and the skin's (k,).
        """
        faces, weights, _ = self._closest.query(points)
        outward = self._mesh.face_normals[faces]
        height = np.vecdot(points - self._mesh.points(faces, weights), outward)
        cosine = np.vecdot(normals, outward)
        covered = (cosine > _LEAST_COSINE) & (height > -_DEEPEST) & (height < _MISFIT)
        covered &= ~self._on_border(faces, weights)
        if self._border is None:
            return covered, np.full(len(points), np.inf), cosine
        return covered, self._border.query(points - height[:, None] * outward)[0], cosine

    def _on_border(self, faces: IntArray, weights: FloatArray) -> BoolArray:
        """Return (k,) whether each point of the skin is on an edge or a vertex of its border."""
        off = weights < _ON_EDGE
        edges = self._border_edge[faces] & np.roll(off, -2, axis=1)  # edge k is opposite corner k + 2
        corners = self._border_vertex[self._mesh.faces[faces]] & (weights > 1 - _ON_EDGE)
        return np.asarray(edges.any(axis=1) | corners.any(axis=1))


def _along(vertices: FloatArray, edges: IntArray) -> cKDTree | None:
    """Return a search tree of points along ``edges`` (b, 2); None without edges."""
    if not len(edges):
        return None
    start = vertices[edges[:, 0]]
    step = vertices[edges[:, 1]] - vertices[edges[:, 0]]
    length = np.linalg.norm(step, axis=1)
    parts = np.clip(np.ceil(_PARTS * length / np.median(length)), 1, _PARTS**2).astype(np.int64)
    owner, rank = owner_and_rank(parts)
    return cKDTree(start[owner] + ((rank + 0.5) / parts[owner])[:, None] * step[owner])


def _grouped(centres: FloatArray, normals: FloatArray, areas: FloatArray, spacing: float) -> tuple[IntArray, IntArray]:
    """Return the group of each face (m,), one for those in a cube of ``spacing`` [m] that face alike, and the largest
    face of each group.
    """
    cube = np.floor((centres - centres.min(axis=0)) / spacing).astype(np.int64)
    side = np.abs(normals).argmax(axis=1)
    side = 2 * side + (np.take_along_axis(normals, side[:, None], axis=1)[:, 0] > 0)
    wide, high = cube.max(axis=0)[1:] + 1
    key = 6 * ((cube[:, 0] * wide + cube[:, 1]) * high + cube[:, 2]) + side
    group: IntArray = np.unique(key, return_inverse=True)[1]
    order = np.lexsort((-areas, group))
    return group, order[np.searchsorted(group[order], np.arange(group.max() + 1))]
