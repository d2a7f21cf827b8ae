"""A closed mesh as a body that presses: an object from a file, or another link of the robot."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from app.arrays import FloatArray, readonly
from app.errors import MeshError
from app.geometry.clean import clean
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_edges, edge_table, is_closed_manifold

_ON_SIDE = 1e-9
"""Barycentric weight below which a closest point lies on the side or in the corner of its triangle."""


class MeshShape:
    """The solid inside a closed mesh. Built once; equal only to itself.

    The distance is that to the closest triangle. Its sign is that of the angle-weighted normal of the closest feature:
    of the face, the edge or the corner (Baerentzen and Aanaes, Signed distance computation using the angle weighted
    pseudonormal, 2005). That is exact for a closed surface that does not meet itself; where it does, a point is inside
    if the closest sheet has it behind.

    Args:
        mesh: Closed; which way it is turned does not matter, it is turned inside in.
        where: Its name, for errors.

    Raises:
        MeshError: The mesh is open or not the border of a solid, or has no face with an area.

    Cost: 1 ms for 2,000 faces to build; 1 to 3 µs a point to ask.
    """

    def __init__(self, mesh: Mesh, *, where: str = "mesh") -> None:
        solid, _ = clean(mesh, where=where)
        _check_closed(solid, where)
        volume = np.einsum("ij,ij->", solid.vertices[solid.faces[:, 0]], _crosses(solid)) / 6.0
        self.mesh = solid if volume >= 0 else Mesh(solid.vertices, solid.faces[:, ::-1])
        self._closest = ClosestPoint(self.mesh)

    @cached_property
    def reach(self) -> float:
        """Radius [m] about the origin that holds all of it."""
        return float(np.linalg.norm(self.mesh.vertices, axis=1).max())

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m] of ``points`` (k, 3) [m], the mesh's own frame.

        Raises:
            MeshError: A point is not finite.
        """
        faces, weights, distances = self._closest.query(points)
        offset = points - self.mesh.points(faces, weights)
        touched = weights > _ON_SIDE
        feature = touched @ np.array([1, 2, 4])  # a bit for each corner: 7 the face, two bits a side, one a corner
        outward = self._normals[faces, feature - 1]
        return np.where(np.einsum("ij,ij->i", offset, outward) < 0, -distances, distances)

    @cached_property
    def _normals(self) -> FloatArray:
        """(m, 7, 3) of every face's features, by the bits of the corners that meet there, less one."""
        faces, flat = self.mesh.faces, self.mesh.face_normals
        table = edge_table(faces)
        sides = np.zeros((len(table.edges), 3))
        np.add.at(sides, table.edge_of.ravel(), np.repeat(flat, 3, axis=0))
        corners = np.zeros_like(self.mesh.vertices)
        np.add.at(corners, faces.ravel(), (_angles(self.mesh)[:, :, None] * flat[:, None]).reshape(-1, 3))
        a, b, c = (corners[faces[:, k]] for k in range(3))
        ab, bc, ca = (sides[table.edge_of[:, k]] for k in range(3))
        return readonly(np.stack([a, b, ab, c, ca, bc, flat], axis=1))


def _check_closed(mesh: Mesh, where: str) -> None:
    if is_closed_manifold(mesh.faces):
        return
    open_edges = len(boundary_edges(mesh.faces))
    if open_edges:
        value, remedy = f"{open_edges} edges with one face", "Close its holes, or use a box or a cylinder instead"
        raise MeshError("an open mesh has no inside and cannot press", file=where, value=value, remedy=remedy)
    remedy = "Export it again as one solid whose faces all look outward"
    raise MeshError("the mesh is not the border of a solid", file=where, value="edges of other than two faces, "
                    "or faces turned against each other", remedy=remedy)  # fmt: skip


def _crosses(mesh: Mesh) -> FloatArray:
    return np.cross(mesh.vertices[mesh.faces[:, 1]], mesh.vertices[mesh.faces[:, 2]])


def _angles(mesh: Mesh) -> FloatArray:
    """(m, 3) angle [rad] of each face at each corner."""
    corners = mesh.vertices[mesh.faces]
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(ahead, back), axis=2)
    return np.arctan2(across, (ahead * back).sum(axis=2))
