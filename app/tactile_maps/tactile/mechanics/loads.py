"""Loads on the skin at one instant, and shapes of the bodies that press, as signed distances.

``Sphere``, ``Box``, ``Cylinder``, ``Plane``, ``MeshShape`` (a closed mesh: an object from a file, or another link of
the robot) and ``LayerShape`` (another link with hollow skin) return the distance of a point from their surface,
negative inside. A ``Load`` is one of them pressing a link with a normal force at a centre of pressure.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray, readonly
from tactile_maps.core.errors import MeshError, SimulationError
from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose


class Shape(Protocol):
    """Solid body in its own frame."""

    @property
    def reach(self) -> float:
        """Bounding radius [m] about the origin of the body's frame; inf for a plane."""

    def distance(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (k,) [m] of ``points`` (k, 3) [m], body frame; negative inside."""


@dataclass(frozen=True)
class Sphere:
    """A sphere about the origin.

    Attributes:
        radius: [m], > 0.
    """

    radius: float

    @property
    def reach(self) -> float:
        return self.radius

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        distance: FloatArray = np.sqrt(np.vecdot(points, points))
        distance -= self.radius
        return distance


@dataclass(frozen=True)
class Box:
    """A box about the origin, its sides along the axes.

    Attributes:
        half: Half of each side [m], > 0.
    """

    half: tuple[float, float, float]

    @property
    def reach(self) -> float:
        return math.hypot(*self.half)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        beyond = np.abs(points) - self.half
        inside = np.minimum(beyond.max(axis=1, initial=-np.inf), 0.0)
        np.maximum(beyond, 0.0, out=beyond)
        return np.asarray(np.sqrt(np.vecdot(beyond, beyond)) + inside)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about the origin, its axis along z.

    Attributes:
        radius: [m], > 0.
        half: Half its height [m], > 0.
    """

    radius: float
    half: float

    @property
    def reach(self) -> float:
        return math.hypot(self.radius, self.half)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        aside = np.hypot(points[:, 0], points[:, 1]) - self.radius
        above = np.abs(points[:, 2]) - self.half
        inside = np.minimum(np.maximum(aside, above), 0.0)
        return np.asarray(np.hypot(np.maximum(aside, 0.0), np.maximum(above, 0.0)) + inside)


@dataclass(frozen=True)
class Plane:
    """A half-space: everything below z = 0 is solid."""

    @property
    def reach(self) -> float:
        return math.inf

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m]."""
        return np.array(points[:, 2])


_ON_SIDE = 1e-9
"""Barycentric weight below which a closest point is on an edge or a corner of its triangle."""


class MeshShape:
    """The solid inside a closed mesh. Built once; equal only to itself.

    The distance is that to the closest triangle. Its sign is that of the angle-weighted normal of the closest feature:
    of the face, the edge or the corner (Baerentzen and Aanaes, Signed distance computation using the angle weighted
    pseudonormal, 2005). That is exact for a closed surface without self-intersections. With them, a point is inside
    if it is behind the closest sheet.

    Args:
        mesh: Closed mesh; its faces may point inward or outward.
        where: Name for errors.

    Raises:
        MeshError: The mesh is open or not the boundary of a solid, or has no face with an area.

    Cost: 1 ms for 2,000 faces to build; 1 to 3 µs a point to ask.
    """

    def __init__(self, mesh: Mesh, *, where: str = "mesh") -> None:
        solid, _ = clean_mesh(mesh, where=where)
        _check_closed(solid, where)
        volume = np.einsum("ij,ij->", solid.vertices[solid.faces[:, 0]], _crosses(solid)) / 6.0
        self.mesh = solid if volume >= 0 else Mesh(solid.vertices, solid.faces[:, ::-1])
        self._surface = _SignedSurface(self.mesh)

    @cached_property
    def reach(self) -> float:
        """Radius [m] about the origin that holds all of it."""
        return _radius(self.mesh)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m] of ``points`` (k, 3) [m], the mesh's own frame.

        Raises:
            MeshError: A point is not finite.
        """
        return self._surface.distance(points)[0]


class LayerShape:
    """Solid layer behind a surface that need not be closed. Built once; equal only to itself.

    A point is inside if the closest point of the surface is not on its border, is less than a depth away, and has the
    point behind it (see ``MeshShape``). It represents links whose mesh is open or missing. Behind the layer and behind
    the border distances are positive, so that they are discontinuous there.

    Args:
        surface: Surface with faces that point outward. Vertices at one place are joined, so that a seam is not a
            border.
        depth: Thickness of the layer [m].

    Cost: that of ``MeshShape``.
    """

    def __init__(self, surface: Mesh, *, depth: float) -> None:
        places, number = np.unique(np.round(surface.vertices, 9), axis=0, return_inverse=True)
        faces = number.reshape(-1)[surface.faces]
        self.mesh = Mesh(places, faces[surface.face_areas > 0])
        self._depth = depth
        self._surface = _SignedSurface(self.mesh)
        table = self.mesh.connectivity
        self._border_edge = (table.face_count == 1)[table.edge_of]
        self._border_vertex = np.zeros(len(places), dtype=bool)
        self._border_vertex[table.boundary_edges] = True

    @cached_property
    def reach(self) -> float:
        """Radius [m] about the origin that holds all of it."""
        return _radius(self.mesh)

    def distance(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m] of ``points`` (k, 3) [m] from the surface, its own frame.

        Raises:
            MeshError: A point is not finite.
        """
        signed, faces, touched = self._surface.distance(points)
        on_edge = (self._border_edge[faces] & ~np.roll(touched, -2, axis=1)).any(axis=1)  # opposite corner k + 2
        on_corner = (self._border_vertex[self.mesh.faces[faces]] & touched).any(axis=1) & (touched.sum(axis=1) == 1)
        return np.where(on_edge | on_corner | (signed < -self._depth), np.abs(signed), signed)


def _radius(mesh: Mesh) -> float:
    """Return the bounding radius [m] about the origin."""
    return float(np.linalg.norm(mesh.vertices, axis=1).max())


class _SignedSurface:
    """Distances from the faces of a surface, negative behind it."""

    def __init__(self, mesh: Mesh) -> None:
        self._mesh = mesh
        self._closest = ClosestPoint(mesh)

    def distance(self, points: FloatArray) -> tuple[FloatArray, IntArray, BoolArray]:
        """Return signed distance (k,) [m], closest face (k,), and whether each of its corners has a weight (k, 3).

        Raises:
            MeshError: A point is not finite.
        """
        faces, weights, distances = self._closest.query(points)
        offset = points - self._mesh.points(faces, weights)
        touched = weights > _ON_SIDE
        feature = touched @ np.array([1, 2, 4])  # a bit for each corner: 7 the face, two bits a side, one a corner
        outward = self._normals[faces, feature - 1]
        signed = np.where(np.einsum("ij,ij->i", offset, outward) < 0, -distances, distances)
        return signed, faces, touched

    @cached_property
    def _normals(self) -> FloatArray:
        """(m, 7, 3) normals of every face's features, by the bits of their corners minus one."""
        faces = self._mesh.faces
        flat = self._mesh.face_normals
        table = self._mesh.connectivity
        sides = np.zeros((len(table.edges), 3))
        np.add.at(sides, table.edge_of.ravel(), np.repeat(flat, 3, axis=0))
        corners = np.zeros_like(self._mesh.vertices)
        np.add.at(corners, faces.ravel(), (_angles(self._mesh)[:, :, None] * flat[:, None]).reshape(-1, 3))
        a, b, c = (corners[faces[:, k]] for k in range(3))
        ab, bc, ca = (sides[table.edge_of[:, k]] for k in range(3))
        return readonly(np.stack([a, b, ab, c, ca, bc, flat], axis=1))


def _check_closed(mesh: Mesh, where: str) -> None:
    if mesh.connectivity.is_closed_manifold:
        return
    open_edges = len(mesh.connectivity.boundary_edges)
    if open_edges:
        value = f"{open_edges} edges with one face"
        remedy = "Close its holes, or use a box or a cylinder instead"
        raise MeshError("an open mesh has no inside and cannot press", file=where, value=value, remedy=remedy)
    remedy = "Export it again as one solid whose faces all look outward"
    raise MeshError(
        "the mesh is not the boundary of a solid",
        file=where,
        value="edges of other than two faces, or faces turned against each other",
        remedy=remedy,
    )


def _crosses(mesh: Mesh) -> FloatArray:
    return np.cross(mesh.vertices[mesh.faces[:, 1]], mesh.vertices[mesh.faces[:, 2]])


def _angles(mesh: Mesh) -> FloatArray:
    """Return the angle (m, 3) [rad] of each face at each corner."""
    corners = mesh.vertices[mesh.faces]
    ahead = np.roll(corners, -1, axis=1) - corners
    back = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(ahead, back), axis=2)
    return np.arctan2(across, (ahead * back).sum(axis=2))


_UPRIGHT = readonly(np.eye(3))
NO_SHEAR = readonly(np.zeros(3))


@dataclass(frozen=True, eq=False)
class Load(ArrayFields):
    """A body that presses the skin of one link.

    Attributes:
        link: Name of the link.
        point: (3,) centre of pressure of the normal force, link frame [m].
        normal: (3,) outward unit normal of the skin there, link frame; the force acts against it.
        force: Normal force [N], >= 0.
        shape: Shape of the body that presses.
        pose: ``T_link_shape``, as deep in the skin as in the physics.
        by: Displayed name of the body: an object's or a link's name; empty for a finger.
        shear: (3,) force of the body on the skin along it, perpendicular to the normal, link frame [N].
        torque: Torque of the body on the skin about the normal at the point [N m].
        friction: Coulomb coefficient; 0 for a contact without friction, whose shear and torque are zero.

    Raises:
        SimulationError: The force is negative or not finite.
    """

    link: str
    point: FloatArray
    normal: FloatArray
    force: float
    shape: Shape
    pose: Pose
    by: str = ""
    shear: FloatArray = field(default_factory=lambda: NO_SHEAR)
    torque: float = 0.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if not (math.isfinite(self.force) and self.force >= 0):
            raise SimulationError(
                "the force of a load is out of range", place=f"on {self.link}", value=f"{self.force} N"
            )

    def distances(self, points: FloatArray) -> FloatArray:
        """Return the signed distances (k,) [m] of ``points`` (k, 3) [m], link frame; negative inside the body."""
        return self.shape.distance((points - self.pose.translation) @ self.pose.rotation)


def sphere_load(
    link: str,
    point: FloatArray,
    normal: FloatArray,
    force: float,
    radius: float,
    *,
    depth: float = 0.0,
    shear: FloatArray = NO_SHEAR,
    friction: float = 0.0,
) -> Load:
    """Return the load of a ball that touches the skin at ``point`` from outside, ``depth`` [m] below the surface.

    Args:
        link: Name of the link.
        point: (3,) on the skin, link frame [m].
        normal: (3,) outward unit normal, link frame.
        force: Normal force [N], >= 0.
        radius: Radius of the ball [m], > 0.
        depth: Depth of its lowest point below ``point`` [m]; the ball is placed at most its diameter deep, because a
            deeper one would be away from the skin that bears its force.
        shear: (3,) force along the skin, link frame [N].
        friction: Coulomb coefficient.

    Raises:
        SimulationError: Force or radius is out of range.
    """
    if not (math.isfinite(radius) and radius > 0):
        raise SimulationError("the radius of a ball must be positive", place=f"on {link}", value=f"radius {radius} m")
    centre = np.asarray(point) + (radius - min(depth, 2 * radius)) * np.asarray(normal)
    centre.flags.writeable = False  # a new array: no copy is needed
    pose = Pose(_UPRIGHT, centre)
    return Load(link, point, normal, force, Sphere(radius), pose, shear=shear, friction=friction)
