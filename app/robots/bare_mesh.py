"""A mesh alone as a robot of one fixed link, so that any shape may wear a skin."""

from __future__ import annotations

from pathlib import Path

import mujoco

from app.errors import MeshError
from app.robots.build import build_robot
from app.robots.mesh_file import in_metres, read_mesh, to_msh
from app.robots.robot import Robot

LINK = "mesh"
CLEARANCE = 0.05  # m between the ground and the lowest point


def load_bare_mesh(path: Path, *, name: str | None = None) -> Robot:
    """A robot with one link called ``mesh`` and no joints, standing just above the ground.

    Its inertia is stated rather than computed, so that open and inside-out meshes load too. Nothing collides with a
    flat mesh, which has no convex hull (a Finding).

    Raises:
        RobotError: The file is missing or a folder.
        MeshError: It cannot be read, is empty, has no size, or holds numbers that are not finite.
    """
    mesh = read_mesh(path)
    if mesh.area == 0.0:
        raise MeshError("the mesh has no area", file=path, remedy="Export it again with its surface")
    mesh, findings = in_metres(mesh, where=str(path))
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.modelname = name or path.stem
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # asks no closed surface of it
    spec.add_mesh(name=LINK, file="mesh.msh", inertia=shell)
    body = spec.worldbody.add_body(name=LINK, pos=[0, 0, CLEARANCE - mesh.bounds[0, 2]])
    body.mass, body.inertia, body.explicitinertial = 1.0, [0.01] * 3, True
    body.add_geom(name="visual", type=mujoco.mjtGeom.mjGEOM_MESH, meshname=LINK, group=2, contype=0, conaffinity=0)
    body.add_geom(name="collision", type=mujoco.mjtGeom.mjGEOM_MESH, meshname=LINK, group=3)
    assets = {"mesh.msh": to_msh(mesh)}
    spec.assets = assets
    return build_robot(spec, name=spec.modelname, source=str(path), assets=assets, findings=findings)
