"""Robots from URDF files, with the repairs they usually need before MuJoCo can simulate them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from app.errors import Finding, RobotError
from app.robots.asset_store import AssetStore
from app.robots.build import build_robot
from app.robots.compile import parse_spec
from app.robots.packages import Packages
from app.robots.robot import Robot
from app.robots.safe_files import parse_xml, read_bytes

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
    """The robot in a URDF file; see ``urdf_tree`` and ``robot_of_urdf``.

    Args:
        path: The file.
        package_roots: Folders that hold the packages its ``package://`` addresses name.
        name: A short name for people; the model's own by default.

    Raises:
        RobotError: The file cannot be read, names files elsewhere, or holds no robot that simulates.
        MeshError: One of its meshes is not usable.
    """
    return robot_of_urdf(urdf_tree(path), path, package_roots=package_roots, name=name)


def urdf_tree(path: Path) -> Element:
    """The checked XML tree of a URDF file: links, joints and materials only."""
    root = parse_xml(read_bytes(path), file=path)
    if root.tag != "robot":
        raise RobotError("this file is not URDF", file=path, value=f"<{root.tag}>", remedy="Its root must be <robot>")
    if any("xacro" in element.tag for element in root.iter()):
        raise RobotError("this is a xacro file", file=path, remedy="Run xacro on it and open the URDF it writes")
    root[:] = [child for child in root if child.tag in _KEPT]
    return root


def robot_of_urdf(
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
    _gather_meshes(root, Packages(path, package_roots), store)
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


def _gather_meshes(root: Element, packages: Packages, store: AssetStore) -> None:
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
