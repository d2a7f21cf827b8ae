"""Any robot file to a Robot: the one door, which chooses the reader by what the file is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from app.errors import RobotError
from app.robots.bare_mesh import load_bare_mesh
from app.robots.mesh_file import MESH_SUFFIXES
from app.robots.mjcf import load_mjcf
from app.robots.robot import Robot
from app.robots.safe_files import parse_xml, read_bytes
from app.robots.urdf import load_urdf

XML_SUFFIXES = (".xml", ".mjcf", ".urdf")


def load_robot(source: str | Path, *, package_roots: Sequence[Path] = ()) -> Robot:
    """Read a robot from MJCF, URDF, or a bare mesh, which becomes a robot of one link.

    Args:
        source: The file.
        package_roots: Folders with further files: URDF packages, or meshes outside an MJCF file's folder.

    Raises:
        RobotError: The file is missing, unreadable, hostile, or no robot that simulates.
        MeshError: A mesh is not usable.
    """
    path = Path(source)
    suffix = path.suffix.lower()
    if suffix in MESH_SUFFIXES:
        return load_bare_mesh(path)
    data = read_bytes(path)
    if suffix not in XML_SUFFIXES:
        raise RobotError(
            "this is no robot file",
            file=path,
            value=path.suffix or "no suffix",
            remedy=f"Open one of: {', '.join((*XML_SUFFIXES, *MESH_SUFFIXES))}",
        )
    if suffix == ".urdf" or parse_xml(data, file=path).tag == "robot":
        return load_urdf(path, package_roots=package_roots)
    return load_mjcf(path, package_roots=package_roots)
