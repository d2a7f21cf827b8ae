"""Faces that no taxel may use.

A face is kept out if any of it may lie in a zone, so that a taxel anywhere on the other faces is outside for certain.
Kept-out faces carry no quadrature: there is a connector, a screw or a joint, and nothing to feel with.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from app.arrays import BoolArray, FloatArray
from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_edges
from app.skin.placement_spec import Ball, BorderStrip, Box, Painted, Zone


def allowed_faces(surface: Mesh, zones: Sequence[Zone]) -> BoolArray:
    """(m,) faces that lie outside all ``zones``.

    Raises:
        SkinError: None is left, or a painted zone has not one mark for each vertex.
    """
    allowed = np.ones(len(surface.faces), dtype=bool)
    for zone in zones:
        allowed &= ~_touched(surface, zone)
    if not allowed.any():
        raise SkinError("nothing of the surface is left for taxels", place="keep out", remedy="Make the zones smaller")
    return allowed


def _touched(surface: Mesh, zone: Zone) -> BoolArray:
    """(m,) faces that may reach into the zone."""
    corners = surface.vertices[surface.faces]
    if isinstance(zone, Ball):
        return np.asarray(_distances(corners, zone.centre) <= zone.radius)
    if isinstance(zone, Box):
        return np.asarray(((corners.max(axis=1) >= zone.low) & (corners.min(axis=1) <= zone.high)).all(axis=1))
    if isinstance(zone, BorderStrip):
        return np.asarray((_from_border(surface)[surface.faces] < zone.width).any(axis=1))
    if isinstance(zone, Painted):
        if len(zone.vertices) != len(surface.vertices):
            value = f"{len(zone.vertices)} for {len(surface.vertices)} vertices"
            raise SkinError("a painted zone needs one mark for each vertex", place="keep out", value=value)
        return np.asarray(zone.vertices[surface.faces].any(axis=1))
    assert_never(zone)


def _distances(corners: FloatArray, point: FloatArray) -> FloatArray:
    """(m,) exact distance of ``point`` (3,) from each triangle (m, 3, 3) [m]."""
    a, b, c = (corners[:, k] - point for k in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    above = np.all([(np.cross(q - p, -p) * normal).sum(axis=1) >= 0 for p, q in ((a, b), (b, c), (c, a))], axis=0)
    plane = np.abs((a * normal).sum(axis=1)) / np.where(length > 0, length, 1.0)
    sides = np.min([_from_segment(p, q) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    return np.where(above & (length > 0), plane, sides)


def _from_segment(start: FloatArray, end: FloatArray) -> FloatArray:
    """(m,) distance of the origin from each segment."""
    side = end - start
    squared = (side * side).sum(axis=1)
    along = np.clip(-(start * side).sum(axis=1) / np.where(squared > 0, squared, 1.0), 0.0, 1.0)
    return np.linalg.norm(start + along[:, None] * side, axis=1)


def _from_border(surface: Mesh) -> FloatArray:
    """(n,) distance of each vertex from the border along edges [m]; infinite on a closed surface."""
    border = np.unique(boundary_edges(surface.faces))
    count, edges = len(surface.vertices), surface.edges
    if not len(border):
        return np.full(count, np.inf)
    lengths = np.linalg.norm(surface.vertices[edges[:, 0]] - surface.vertices[edges[:, 1]], axis=1)
    graph = coo_matrix((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()
    return np.asarray(dijkstra(graph, directed=False, indices=border, min_only=True))
