"""Robots from URDF files, with the repairs they usually need before MuJoCo can simulate them.

``PackageResolver`` turns ``package://`` addresses and relative paths into places a robot may read.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path, PurePosixPath
from urllib.parse import unquote
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from app.core.errors import Finding, RobotError
from app.robots.build import build_robot
from app.robots.mesh_files import AssetStore
from app.robots.model_limits import check_amounts
from app.robots.mujoco_spec import parse_spec
from app.robots.robot import Robot
from app.robots.safe_files import parse_xml, read_bytes, resolve_inside


class PackageResolver:
    """Finds the files that one URDF file names.

    A package is looked for in the given roots, in ``ROS_PACKAGE_PATH``, in the folders above the file (those beside
    them need a package.xml) and in the interpreter's ``share``. A relative path may not leave the file's folder, the
    package around it (the nearest folder above with a package.xml), or a given root.

    Args:
        file: The URDF file.
        roots: Folders that hold packages, or are packages themselves.
    """

    def __init__(self, file: Path, roots: Sequence[Path] = ()) -> None:
        self._file = file
        self._folder = file.resolve().parent
        above = (self._folder, *self._folder.parents)
        around = next((folder for folder in above if (folder / "package.xml").is_file()), self._folder)
        self._allowed = (self._folder, around, *roots)
        ros = [Path(part) for part in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep) if part]
        self._given, self._above = (*roots, *ros), above

    def resolve(self, address: str) -> Path:
        """Where ``address`` points; the file need not exist.

        Raises:
            RobotError: It climbs out of its package or folder, or uses a scheme that is not a file.
        """
        text = unquote(address.strip()).replace("\\", "/")
        scheme, found, rest = text.partition("://")
        if found and scheme in ("package", "model"):
            return self._in_package(rest, address)
        if found and scheme != "file":
            raise RobotError(
                "meshes are read from files only",
                file=self._file,
                value=address,
                remedy="Download it beside the robot and name it by its path",
            )
        path = self._folder / (rest if found else text)
        return resolve_inside(path, self._allowed, file=self._file, named=address)

    def _in_package(self, rest: str, address: str) -> Path:
        parts = PurePosixPath(rest).parts
        if len(parts) < 2 or parts[0] in ("..", "/"):
            raise RobotError(
                "this is not a package address",
                file=self._file,
                value=address,
                remedy="It reads package://name/path/to/file",
            )
        homes = self._homes(parts[0])
        paths = [resolve_inside(home.joinpath(*parts[1:]), [home], file=self._file, named=address) for home in homes]
        return next((path for path in paths if path.is_file()), paths[0])

    def _homes(self, name: str) -> list[Path]:
        """Where the package of that name may lie, the likeliest first; never all of a disk or of a person's files."""
        share = Path(sys.prefix, "share")
        homes = [root if root.name == name else root / name for root in (*self._given, self._folder, share)]
        people = (Path.home(), *Path.home().parents)
        for folder in self._above:
            if folder.name == name and folder not in people and len(folder.parts) > 2:
                homes.append(folder)
            elif (folder / name / "package.xml").is_file():
                homes.append(folder / name)
        return homes


ARMATURE = 0.01  # kg m²
DAMPING = 0.3  # N m s/rad
_KEPT = ("link", "joint", "material")
# discardvisual: MuJoCo drops visual meshes of URDF files otherwise, and only the text can tell it. fusestatic: keeps
# links behind fixed joints, and their names. boundinertia: several iCubs state inertias that are not positive.
_COMPILER = {
    "discardvisual": "false",
    "fusestatic": "false",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "1e-6",
    "boundinertia": "1e-6",
}


def load_urdf(path: Path, *, package_roots: Sequence[Path] = (), name: str | None = None) -> Robot:
    """The robot in a URDF file; see ``read_urdf`` and ``robot_from_urdf``.

    Args:
        path: The file.
        package_roots: Folders that hold the packages its ``package://`` addresses name.
        name: A short name for people; the model's own by default.

    Raises:
        RobotError: The file cannot be read, names files elsewhere, or holds no robot that simulates.
        MeshError: One of its meshes is not usable.
    """
    return robot_from_urdf(read_urdf(path), path, package_roots=package_roots, name=name)


def read_urdf(path: Path) -> Element:
    """The checked XML tree of a URDF file: links, joints and materials only."""
    root = parse_xml(read_bytes(path), file=path)
    if root.tag != "robot":
        raise RobotError("this file is not URDF", file=path, value=f"<{root.tag}>", remedy="Its root must be <robot>")
    if any("xacro" in element.tag for element in root.iter()):
        raise RobotError("this is a xacro file", file=path, remedy="Run xacro on it and open the URDF it writes")
    root[:] = [child for child in root if child.tag in _KEPT]
    check_amounts(root, path)
    return root


def robot_from_urdf(
    root: Element,
    path: Path,
    *,
    package_roots: Sequence[Path] = (),
    name: str | None = None,
    home: dict[str, float] | None = None,
    base_height: float = 0.0,
    base_yaw: float = 0.0,
) -> Robot:
    """Turn a URDF tree into a robot: meshes are found and converted, and joints given armature and damping.

    Args:
        root: The tree; it is changed.
        path: The file it came from, for relative paths and errors.
        package_roots: Folders that hold packages.
        name: A short name for people.
        home: Joint values at rest by joint name [rad, m]; zero, or the middle of the limits, by default.
        base_height: Height of the root link above the ground [m].
        base_yaw: Turn of the root link about the vertical [rad].
    """
    store = AssetStore()
    _gather_meshes(root, PackageResolver(path, package_roots), store)
    findings = _check_mimics(root, path)
    settings = SubElement(root, "mujoco")
    SubElement(settings, "compiler", _COMPILER)
    spec = parse_spec(tostring(root, encoding="unicode"), store.files, source=str(path))
    spec.compiler.degree = False
    _place_base(spec, base_height, base_yaw)
    findings += [*store.findings, *_add_joint_dynamics(spec)]
    return build_robot(
        spec,
        name=name or spec.modelname or path.stem,
        source=str(path),
        assets=store.files,
        findings=findings,
        home=home,
    )


def _place_base(spec: mujoco.MjSpec, height: float, yaw: float) -> None:
    turn = np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
    for body in spec.worldbody.bodies:
        position, quaternion = np.empty(3), np.empty(4)
        mujoco.mju_mulPose(position, quaternion, np.array([0.0, 0.0, height]), turn, body.pos, body.quat)
        body.pos, body.quat = position, quaternion


def _gather_meshes(root: Element, packages: PackageResolver, store: AssetStore) -> None:
    for mesh in root.iter("mesh"):
        address = mesh.get("filename")
        if not address:
            raise RobotError("a <mesh> names no file", remedy="Give it a filename")
        # MuJoCo keeps one scale for each file, so another scale needs another copy.
        mesh.set("filename", store.add(packages.resolve(address), variant=mesh.get("scale", "")))
    for material in root.iter("material"):
        material[:] = [child for child in material if child.tag == "color"]


def _check_mimics(root: Element, path: Path) -> list[Finding]:
    """MuJoCo couples ``<mimic>`` joints to their leaders, but leaves out those whose leader it does not find."""
    movable = {joint.get("name") for joint in root.iter("joint") if joint.get("type") != "fixed"}
    followers = [(joint.get("name", ""), mimic) for joint in root.iter("joint") for mimic in joint.findall("mimic")]
    for name, mimic in followers:
        leader = mimic.get("joint", "")
        if leader not in movable or name not in movable:
            problem = "a joint mimics one that does not move or exist"
            raise RobotError(problem, file=path, place=f"joint {name}", value=leader)
    names = ", ".join(name for name, _ in followers)
    return [Finding("mimic-joints", names, "coupled to their leaders", len(followers))] if followers else []


def _add_joint_dynamics(spec: mujoco.MjSpec) -> list[Finding]:
    """URDF cannot state armature and often states no damping; without them light links are numerically stiff."""
    bare, loose = 0, 0
    for joint in spec.joints:
        if joint.armature == 0:
            joint.armature, bare = ARMATURE, bare + 1
        if joint.damping[0] == 0:
            joint.damping[0], loose = DAMPING, loose + 1
    findings = [Finding("armature", "joints", f"given an armature of {ARMATURE} kg m²", bare)] if bare else []
    return findings + (
        [Finding("damping", "joints", f"given a damping of {DAMPING} N m s/rad", loose)] if loose else []
    )
