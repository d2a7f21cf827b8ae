"""Patches on the cover of a link around stated places."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import Finding, add_finding
from tactile_maps.geometry.geodesics import distances_from
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.skin.model.skin import Patch, TaxelIdentity, Taxels, patch_name
from tactile_maps.skin.model.taxel_axes import tangents_on
from tactile_maps.skin.taxel_placement.sampling import (
    distinct_faces,
    face_graph,
    geodesic_voronoi,
    straighten_cells,
    taxels_at_points,
)
from tactile_maps.skin.taxel_placement.usable_surface import usable_components

PATCH_MARGIN = 1.5
"""Width of a patch beyond its taxels, in pitches."""
CELL_RADIUS = 1.0
"""Largest radius of the cell of a taxel, in pitches."""
_LARGEST_HOLE = 8.0  # in pitches²


@dataclass(frozen=True, eq=False)
class StatedProperties(ArrayFields):
    """Stated properties of taxels that their positions on a cover do not replace.

    Attributes:
        identity: Identity of the taxels.
        axes: (n,) number of axes, or None.
        tangents: (n, 3) first tangents in the frame of the link, or None.
    """

    identity: TaxelIdentity
    axes: IntArray | None = None
    tangents: FloatArray | None = None

    def rotated(self, pose: Pose) -> StatedProperties:
        return self if self.tangents is None else replace(self, tangents=pose.directions(self.tangents))

    def select(self, rows: IntArray) -> StatedProperties:
        axes = None if self.axes is None else self.axes[rows]
        tangents = None if self.tangents is None else self.tangents[rows]
        return StatedProperties(self.identity.select(rows), axes, tangents)

    def on(self, taxels: Taxels) -> Taxels:
        """Return ``taxels`` of a cover with these properties; tangents are projected onto the cover."""
        tangents = tangents_on(self.tangents, taxels.normals)
        return replace(taxels, identity=self.identity, axes=self.axes, tangents=tangents)


def patches_at(
    surface: Mesh,
    positions: FloatArray,
    stated: StatedProperties,
    pitch: float,
    link: str,
    touchable: BoolArray | None = None,
) -> tuple[tuple[Patch, ...], list[Finding]]:
    """Return patches of a cover around its places closest to ``positions`` (n, 3), and findings of taxels without one.

    ``touchable`` (vertices,) limits them to a part of the cover.
    """
    patches = tuple[Patch, ...]()
    allowed = np.ones(len(surface.vertices), dtype=bool) if touchable is None else touchable
    open_faces = np.flatnonzero(allowed[surface.faces].all(axis=1))
    if len(open_faces):
        closest = ClosestPoint(Mesh(surface.vertices, surface.faces[open_faces]))
        faces, weights, _ = closest.query(positions)
        points = surface.points(open_faces[faces], weights)
        usable = allowed & _vertices_within(surface, open_faces[faces], PATCH_MARGIN * pitch)
        pieces = usable_components(surface, usable, smallest=0.0, largest_hole=_LARGEST_HOLE * pitch**2)
        patches = _patches(pieces, points, stated, pitch, link)
    missing = len(positions) - sum(len(patch.taxels) for patch in patches)
    notes = list[Finding]()
    add_finding(notes, "taxel-off-patch", link, "left out: no patch could be made around it", missing)
    return patches, notes


def _vertices_within(surface: Mesh, seeds: IntArray, reach: float) -> BoolArray:
    """Return (vertices,) whether each is a corner of a face within ``reach`` [m] of a seed face along the surface."""
    near = np.isfinite(distances_from(face_graph(surface), np.unique(seeds), limit=reach))
    usable = np.zeros(len(surface.vertices), dtype=bool)
    usable[surface.faces[near]] = True
    return usable


def _patches(
    pieces: list[Mesh], points: FloatArray, stated: StatedProperties, pitch: float, link: str
) -> tuple[Patch, ...]:
    """Return a patch for each piece with taxels; each taxel is on the nearest piece."""
    away = np.array([ClosestPoint(piece).query(points)[2] for piece in pieces]).reshape(len(pieces), len(points))
    patches: list[Patch] = []
    for i, piece in enumerate(pieces):
        own = np.flatnonzero((away.argmin(axis=0) == i) & (away[i] <= pitch))
        if len(own):
            taxels = stated.select(own).on(_taxels(piece, points[own], pitch))
            patches.append(Patch(patch_name(link, len(patches)), link, piece, taxels))
    return tuple(patches)


def _taxels(piece: Mesh, points: FloatArray, pitch: float) -> Taxels:
    seeds = distinct_faces(piece.face_centres, points)
    owner = geodesic_voronoi(face_graph(piece), seeds, reach=CELL_RADIUS * pitch)
    return taxels_at_points(piece, points, straighten_cells(piece, points, owner, seeds))
