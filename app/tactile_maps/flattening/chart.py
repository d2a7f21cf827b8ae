"""A chart, one flattened patch in its own coordinates; and a pin, which holds a point of the body at a point of a
chart.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.point_location import PointLocator


@dataclass(frozen=True)
class Pin:
    """A point of the body held at a point of the plane.

    Attributes:
        at: Point on the body.
        place: (x, y) in the chart's frame [m], so that pins move with their patch.
    """

    at: SurfacePoint
    place: tuple[float, float]


@dataclass(frozen=True, eq=False)
class Chart(ArrayFields):
    """The parameterization of one patch.

    Attributes:
        faces: (m, 3) into ``plane``; face numbers are those of the patch's surface.
        plane: (k, 2) [m], of true total area, the body's long direction up, lower-left corner of its box at the origin.
        vertex_of: (k,) vertex of the surface for each point.
        seams: (s, 2) cut edges as pairs of the surface's vertices.
        method: Name of the flattening method.
        energies: Mean symmetric Dirichlet energy after each round, at its best scale; 4 is an isometry.
        seconds: Wall time at the end of each round.
        findings: Repairs and limitations.
    """

    faces: IntArray
    plane: FloatArray
    vertex_of: IntArray
    seams: IntArray
    method: str
    energies: tuple[float, ...] = ()
    seconds: tuple[float, ...] = ()
    findings: tuple[Finding, ...] = field(default_factory=tuple)

    @cached_property
    def connectivity(self) -> Connectivity:
        """Adjacency of faces, edges and points of the chart, computed once."""
        return Connectivity(self.faces)

    @cached_property
    def border(self) -> IntArray:
        """(b,) border points, counter-clockwise; the first is not repeated."""
        return self.connectivity.boundary_loops[0]

    @cached_property
    def seam_edges(self) -> IntArray:
        """(t, 2) sides of the border that coincide with another side on the body."""
        sides = np.stack([self.border, np.roll(self.border, -1)], axis=1)
        base = [len(self.vertex_of), 1]
        cut = np.isin(np.sort(self.vertex_of[sides], axis=1) @ base, np.sort(self.seams, axis=1) @ base)
        return readonly(sides[cut], int)

    @cached_property
    def locator(self) -> PointLocator:
        """Point location in the plane. Cached here so that it is kept when charts are rearranged."""
        return PointLocator(self.plane[self.faces])

    def __getstate__(self) -> dict[str, Any]:
        """Return the fields without cached properties, which are not pickled."""
        return {part.name: getattr(self, part.name) for part in fields(self)}


def canonical_pose(plane: FloatArray, positions: FloatArray) -> FloatArray:
    """Rotate ``plane`` (k, 2) so that the body's long direction, away from the link's origin (its joint), points up.

    The lower-left corner of the box moves to the origin. ``positions`` (k, 3) are those of the same points on the body.
    """
    centred = positions - positions.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    axis = axes[0] * (1.0 if axes[0] @ positions.mean(axis=0) >= 0 else -1.0)
    flat = plane - plane.mean(axis=0)
    gradient, *_ = np.linalg.lstsq(flat, centred @ axis, rcond=None)
    length = float(np.linalg.norm(gradient))
    up = gradient / length if length > 1e-9 else np.array([0.0, 1.0])
    turned = flat @ np.array([[up[1], up[0]], [-up[0], up[1]]])
    return turned - turned.min(axis=0)
