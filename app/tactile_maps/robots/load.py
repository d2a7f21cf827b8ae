"""Loading of a robot from any file; the kind of file determines the reader.

MJCF and URDF have their readers. A mesh becomes a robot of one fixed link, so that any shape can have a skin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco

from tactile_maps.core.errors import Finding, MeshError, RobotError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import FOREIGN_FORMATS, MESH_SUFFIXES, read_mesh_in_metres, to_msh
from tactile_maps.robots.files.safe_files import parse_model_xml, read_bytes
from tactile_maps.robots.formats.mjcf import load_mjcf
from tactile_maps.robots.formats.urdf import load_urdf
from tactile_maps.robots.model.build import build_robot
from tactile_maps.robots.model.robot import Robot

MESH_LINK = "mesh"
CLEARANCE = 0.05  # m between the ground and the lowest point


def load_bare_mesh(path: Path) -> Robot:
    """Load a mesh as a robot with one link called ``mesh`` and no joints, just above the ground.

    Its inertia is stated rather than computed, so that open and inside-out meshes load too. A flat mesh has no convex
    hull and does not collide (a Finding).

    Raises:
        RobotError: The file is missing or a folder.
        MeshError: The mesh cannot be read, is empty, has no area, or contains numbers that are not finite.
    """
    mesh, findings = read_mesh_in_metres(path, where=str(path))
    if mesh.area == 0.0:
        raise MeshError("the mesh has no area", file=path, remedy="Export it again with its surface")
    return robot_of_mesh(mesh, name=path.stem, source=str(path), findings=findings)


def robot_of_mesh(
    mesh: Mesh, *, name: str, source: str, link: str = MESH_LINK, findings: Sequence[Finding] = ()
) -> Robot:
    """Return a robot with one link of the shape of ``mesh`` and no joints, just above the ground.

    Args:
        mesh: Mesh with an area [m]; it may be open, inside-out or flat.
        name: Name of the robot.
        source: Source of the mesh.
        link: Name of its link.
        findings: Findings about the mesh.

    Raises:
        RobotError: The robot cannot be simulated.
    """
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.modelname = name
    shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # does not require a closed surface
    spec.add_mesh(name=MESH_LINK, file="mesh.msh", inertia=shell)
    body = spec.worldbody.add_body(name=link, pos=[0, 0, CLEARANCE - mesh.bounds[0, 2]])
    body.mass = 1.0
    body.inertia = [0.01] * 3
    body.explicitinertial = True
    body.add_geom(name="visual", type=mujoco.mjtGeom.mjGEOM_MESH, meshname=MESH_LINK, group=2, contype=0, conaffinity=0)
    body.add_geom(name="collision", type=mujoco.mjtGeom.mjGEOM_MESH, meshname=MESH_LINK, group=3)
    assets = {"mesh.msh": to_msh(mesh)}
    spec.assets = assets
    return build_robot(spec, name=name, source=source, assets=assets, findings=findings)


XML_SUFFIXES = FileKind.ROBOT.suffixes
_USD = "Export it as URDF (in Isaac Sim: File > Export to URDF), or its meshes as glTF"
_SDF = "Export it as URDF or MJCF (sdformat_mjcf converts it)"
FOREIGN_ROBOTS = {
    ".usd": _USD,
    ".usda": _USD,
    ".usdc": _USD,
    ".usdz": _USD,
    ".sdf": _SDF,
    ".world": _SDF,
    **FOREIGN_FORMATS,
    ".mjb": "Save the model as MJCF (MuJoCo's mj_saveLastXML)",
}
"""Unsupported formats of robots and meshes, with the remedy."""


def load_robot_file(
    source: str | Path, *, package_roots: Sequence[Path] = (), home: Mapping[str, float] | None = None
) -> Robot:
    """Read a robot from MJCF, URDF, xacro, or a bare mesh, which becomes a robot of one link.

    Args:
        source: The file.
        package_roots: Folders with further files: URDF packages, or meshes outside an MJCF file's folder.
        home: Joint values of the home posture by joint name [rad, m], instead of those of its file.

    Raises:
        RobotError: The file is missing, unreadable, unsafe, or does not contain a robot that can be simulated.
        MeshError: A mesh is not usable.
    """
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix in MESH_SUFFIXES:
        return load_bare_mesh(path)
    data = read_bytes(path)
    if suffix not in XML_SUFFIXES:
        raise RobotError(
            "the file is not a robot file",
            file=path,
            value=path.suffix or "no file extension",
            remedy=FOREIGN_ROBOTS.get(suffix) or f"Open one of: {', '.join((*XML_SUFFIXES, *MESH_SUFFIXES))}",
        )
    if suffix in (".urdf", ".xacro") or parse_model_xml(data, file=path).tag == "robot":
        return load_urdf(path, package_roots=package_roots, home=home)
    return load_mjcf(path, package_roots=package_roots, home=home)
