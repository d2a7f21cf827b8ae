"""Links without a joint between them as one body, and the part of its surface that can be touched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.fitting.cover import placeholder_notes
from tactile_maps.skin.model.touchable_surface import touchable_surfaces
from tactile_maps.skin.taxel_placement.usable_surface import vertices_clear_of

_ABOVE_HIDDEN = 1e-4
"""A place is above a hidden face if the touchable surface is farther away than the mesh by more than this [m]."""


@dataclass(frozen=True, eq=False)
class BodyPart:
    """A link with geometry in the rigid body that carries taxels.

    Attributes:
        link: Name of the link.
        mesh: Cleaned mesh [m], in the frame of the link.
        pose: Pose of its frame in the frame of the link to which the taxels belong.
        findings: Repairs of the mesh.
        touchable: The part of the mesh that can be touched: the mesh itself where nothing is hidden by other parts,
            None where everything is.
    """

    link: str
    mesh: Mesh
    pose: Pose
    findings: tuple[Finding, ...]
    touchable: Mesh | None

    @cached_property
    def closest(self) -> ClosestPoint | None:
        """Index for distances to the surface that can be touched."""
        return None if self.touchable is None else ClosestPoint(self.touchable)


def rigid_parts(robot: Robot, link: str) -> tuple[list[BodyPart], list[BodyPart]]:
    """Return the links with geometry of their own that no joint separates from ``link``, itself first, and the
    placeholders of meshes that are missing on such links.
    """
    configuration = Configuration(robot)
    parts = list[BodyPart]()
    placeholders = list[BodyPart]()
    here = configuration.pose(link).inverse
    for name in configuration.rigid_links(link):
        other = robot.link(name)
        pose = Pose.identity() if name == link else here @ configuration.pose(name)
        placeholders += [BodyPart(name, box, pose, (), box) for box in other.left_out]
        if other.mesh is not None and len(other.mesh.faces):
            if other.missing:
                placeholders.append(BodyPart(name, other.mesh, pose, (), other.mesh))
            else:
                cleaned, findings = clean_mesh(other.mesh, where=name)
                parts.append(BodyPart(name, cleaned, pose, findings, cleaned))
    meshes = [Mesh(part.pose.points(part.mesh.vertices), part.mesh.faces) for part in parts]
    surfaces = touchable_surfaces(meshes)
    for number, (part, mesh, surface) in enumerate(zip(parts, meshes, surfaces, strict=True)):
        if surface is not mesh:
            own = surface and Mesh(part.pose.inverse.points(surface.vertices), surface.faces)
            parts[number] = replace(part, touchable=own)
    return parts, placeholders


def no_geometry(robot: Robot, link: str) -> SkinError:
    return SkinError("the link has no geometry for a skin", file=robot.source, value=link)


def link_mesh(robot: Robot, link: str) -> tuple[Mesh, tuple[Finding, ...]]:
    mesh = robot.link(link).mesh
    if mesh is None or not len(mesh.faces):
        raise no_geometry(robot, link)
    cleaned, findings = clean_mesh(mesh, where=link)
    return cleaned, (*placeholder_notes(robot, (link,)), *findings)


def touchable_mesh(robot: Robot, link: str) -> Mesh:
    """Return the surface of a link, and of links fixed to it, that can be touched, in the frame of the link.

    Raises:
        RobotError: The robot does not have the link.
        SkinError: Neither the link nor any link fixed to it has geometry, or nothing of it can be touched.
    """
    parts, _ = rigid_parts(robot, link)
    surfaces = [(part.pose, part.touchable) for part in parts if part.touchable is not None]
    if not surfaces:
        raise no_geometry(robot, link)
    return join_meshes([Mesh(pose.points(mesh.vertices), mesh.faces) for pose, mesh in surfaces])


def touchable_vertices(surface: Mesh, part: BodyPart, parts: Sequence[BodyPart]) -> BoolArray:
    """Return (n,) for each vertex of the cover ``surface`` of a part whether it is above what can be touched of it."""
    if part.touchable is part.mesh:
        return np.ones(len(surface.vertices), dtype=bool)
    others = [(part.pose.inverse @ other.pose, other.mesh) for other in parts if other is not part]
    return ~above_hidden(part, surface.vertices) & vertices_clear_of(surface, others, distance=0.0)


def above_hidden(part: BodyPart, places: FloatArray) -> BoolArray:
    """Return (n,) for each place (n, 3) [m], in the part's frame, whether the closest face of the part is hidden."""
    if part.touchable is part.mesh:
        return np.zeros(len(places), dtype=bool)
    if part.closest is None:
        return np.ones(len(places), dtype=bool)
    return np.asarray(part.closest.query(places)[2] - ClosestPoint(part.mesh).query(places)[2] > _ABOVE_HIDDEN)


def distances_to_parts(parts: Sequence[BodyPart], places: FloatArray) -> FloatArray:
    """Return (parts, n) the distances [m] of places (n, 3) in the frame of the link to each of the parts; infinite to a
    part that cannot be touched.
    """
    distances = np.full((len(parts), len(places)), np.inf)
    for number, part in enumerate(parts):
        if part.closest is not None:
            distances[number] = part.closest.query(part.pose.inverse.points(places))[2]
    return distances
