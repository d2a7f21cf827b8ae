"""Surfaces of a scene's objects: those that are drawn, and for mesh files also those that touch."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from tactile_maps.core.errors import Finding, MeshError, SceneError, TactileMapsError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import read_mesh_in_metres
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.scene.scene import Scene

_ROUND = 48
_PLANE = (2.0, 2.0)
_USUAL_SIZE = 10.0
"""Size [m] above which an object's numbers are probably in millimetres."""
_USUAL_DISTANCE = 100.0
"""Distance from the world's origin [m] above which an object's numbers are probably in millimetres."""


def make_objects(scene: Scene) -> tuple[SceneObject, ...]:
    """Create all objects of a scene, in its order.

    Raises:
        SceneError: A mesh file is missing or cannot be used.

    Cost: below 1 ms for a primitive.
    """
    return tuple(_make_object(spec, f"objects.{number}.file") for number, spec in enumerate(scene.objects))


def _make_object(spec: ObjectSpec, place: str) -> SceneObject:
    if spec.kind != "mesh":
        mesh = primitive_mesh(spec)
        return SceneObject(spec, mesh, _in_millimetres(spec, mesh))
    try:
        mesh, findings = read_mesh_in_metres(Path(spec.file), where=spec.name)
    except TactileMapsError as error:
        value = error.value or error.place or spec.file
        raise error.at(kind=SceneError, place=place, value=value) from error
    scale = spec.size[0] if spec.size else 1.0
    mesh = Mesh(scale * mesh.vertices, mesh.faces)
    if not mesh.connectivity.is_closed_manifold:
        action = "The mesh is not closed: inside and outside are estimated, so pressures may be wrong; close the mesh"
        findings = (*findings, Finding("open-mesh", spec.name, action))
    return SceneObject(spec, mesh, (*findings, *_in_millimetres(spec, mesh)))


def _in_millimetres(spec: ObjectSpec, mesh: Mesh) -> tuple[Finding, ...]:
    """Return the finding about an object whose size or place is probably in millimetres; planes may be large."""
    size = 0.0 if spec.kind == "plane" else float(np.ptp(mesh.vertices, axis=0).max())
    distance = max(math.hypot(*place) for place in (spec.at, *(row[1:] for row in spec.path)))
    if size <= _USUAL_SIZE and distance <= _USUAL_DISTANCE:
        return ()
    fact = f"it is {size:.3g} m in size" if size > _USUAL_SIZE else f"it is {distance:.3g} m from the origin"
    return (Finding("object-units", spec.name, f"{fact}; lengths in a scene are in metres, not in millimetres"),)


def primitive_mesh(spec: ObjectSpec) -> Mesh:
    """Return the closed surface of an object without mesh file, in its own frame; a plane is a rectangle."""
    import trimesh  # 0.1 s, not needed for cached scenes

    match spec.kind:
        case "sphere" | "probe":
            made = trimesh.creation.icosphere(3, radius=spec.size[0])
        case "cylinder":
            made = trimesh.creation.cylinder(spec.size[0], spec.size[1], sections=_ROUND)
        case "box" | "plate":
            made = trimesh.creation.box(spec.size)
        case "plane":
            x, y = np.array(spec.size or _PLANE) / 2
            return Mesh(np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))
        case "mesh":
            raise MeshError("an object of kind mesh has no primitive surface", place=spec.name)
    return Mesh(np.asarray(made.vertices), np.asarray(made.faces))
