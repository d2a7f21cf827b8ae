"""Robots from URDF files, with the repairs they usually need before MuJoCo can simulate them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from tactile_maps.core.errors import Finding, RobotError, errors_in_file
from tactile_maps.robots.files.mesh_files import AssetStore, split_scale
from tactile_maps.robots.files.model_files import PackageResolver, files_that_include
from tactile_maps.robots.files.model_limits import check_amounts
from tactile_maps.robots.files.safe_files import parse_model_xml, read_bytes
from tactile_maps.robots.files.sanitize import settle_missing_meshes
from tactile_maps.robots.formats.xacro import has_xacro, process_xacro
from tactile_maps.robots.model.build import build_robot
from tactile_maps.robots.model.joint_limits import urdf_limits
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.robot import Robot

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


def load_urdf(
    path: Path,
    *,
    package_roots: Sequence[Path] = (),
    name: str | None = None,
    home: Mapping[str, float] | None = None,
) -> Robot:
    """The robot in a URDF file; see ``read_urdf`` and ``robot_from_urdf``.

    Args:
        path: The file.
        package_roots: Folders that hold the packages its ``package://`` addresses name.
        name: A short name for people; the model's own by default.
        home: Joint values of the home posture by joint name [rad, m], chosen by default.

    Raises:
        RobotError: The file cannot be read, names files elsewhere, or holds no robot that simulates.
        MeshError: One of its meshes is not usable.
    """
    notes: list[Finding] = []
    root = read_urdf(path, package_roots=package_roots, findings=notes)
    return robot_from_urdf(root, path, package_roots=package_roots, name=name, home=home, findings=notes)


def read_urdf(path: Path, *, package_roots: Sequence[Path] = (), findings: list[Finding] | None = None) -> Element:
    """The checked XML tree of a URDF or xacro file, its macros expanded: links, joints and materials only.

    Args:
        path: The file.
        package_roots: Folders that hold the packages a xacro includes.
        findings: Where repairs are told.
    """
    notes = [] if findings is None else findings
    root = parse_model_xml(read_bytes(path), file=path, findings=notes)
    if root.tag != "robot":
        raise RobotError("this file is not URDF", file=path, value=f"<{root.tag}>", remedy="Its root must be <robot>")
    if path.suffix.lower() == ".xacro" or has_xacro(root):
        root = process_xacro(root, path, PackageResolver(path, package_roots))
        notes.append(Finding("xacro", str(path), "its macros were expanded, with the defaults of its arguments"))
    root[:] = [child for child in root if child.tag in _KEPT]
    if root.find("link") is None:
        raise RobotError("the file contains no robot: it has no link", file=path, remedy=files_that_include(path))
    check_amounts(root, path)
    notes += [*_drop_repeated(root), *_repair_triples(root), *_drop_shapes_without_size(root), *_repair_inertias(root)]
    return root


def robot_from_urdf(
    root: Element,
    path: Path,
    *,
    package_roots: Sequence[Path] = (),
    name: str | None = None,
    home: Mapping[str, float] | None = None,
    base_height: float = 0.0,
    base_yaw: float = 0.0,
    findings: Sequence[Finding] = (),
) -> Robot:
    """Turn a URDF tree into a robot: meshes are found and converted, and joints given armature and damping.

    Args:
        root: The tree; it is changed.
        path: The file it came from, for relative paths and errors.
        package_roots: Folders that hold packages.
        name: A short name for people.
        home: Joint values at rest by joint name [rad, m]; chosen by default, see ``choose_home``.
        base_height: Height of the root link above the ground [m].
        base_yaw: Turn of the root link about the vertical [rad].
        findings: What was noticed while the tree was read.
    """
    store = AssetStore()
    packages = PackageResolver(path, package_roots)
    _gather_meshes(root, packages, store)
    notes = [*findings, *_check_mimics(root), *packages.files.findings()]
    drives = urdf_limits(root, notes)
    settings = SubElement(root, "mujoco")
    SubElement(settings, "compiler", _COMPILER)
    spec = parse_spec(tostring(root, encoding="unicode"), store.files, source=str(path), findings=notes)
    spec.compiler.degree = False
    _place_base(spec, base_height, base_yaw)
    with errors_in_file(path):
        missing, left_out = settle_missing_meshes(spec, store.missing, packages.files)
    notes += [*store.findings, *missing]
    notes += _add_joint_dynamics(spec)
    return build_robot(
        spec,
        name=name or spec.modelname or path.stem,
        source=str(path),
        assets=store.files,
        findings=notes,
        home=home,
        left_out=left_out,
        drives=drives,
    )


def _place_base(spec: mujoco.MjSpec, height: float, yaw: float) -> None:
    turn = np.array([np.cos(yaw / 2), 0.0, 0.0, np.sin(yaw / 2)])
    for body in spec.worldbody.bodies:
        position = np.empty(3)
        quaternion = np.empty(4)
        mujoco.mju_mulPose(position, quaternion, np.array([0.0, 0.0, height]), turn, body.pos, body.quat)
        body.pos = position
        body.quat = quaternion


def _gather_meshes(root: Element, packages: PackageResolver, store: AssetStore) -> None:
    for mesh in root.iter("mesh"):
        address = mesh.get("filename")
        if not address:
            raise RobotError("a <mesh> names no file", remedy="Give it a filename")
        # MuJoCo keeps one scale for each file, so another scale needs another copy.
        scale, mirror = split_scale(mesh.get("scale", ""))
        if scale:
            mesh.set("scale", scale)
        mesh.set("filename", store.add(packages.resolve(address), variant=scale, mirror=mirror))
    for material in root.iter("material"):
        material[:] = [child for child in material if child.tag == "color"]


_ONCE = {
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
}
"""What may stand in an element once; of several the first counts, as in ROS."""


def _drop_repeated(root: Element) -> list[Finding]:
    places: list[str] = []
    for parent in root.iter():
        for tag in _ONCE.get(parent.tag, ()):
            for extra in parent.findall(tag)[1:]:
                parent.remove(extra)
                places.append(f"{tag} of {parent.tag} {parent.get('name', '')}".rstrip())
    return [Finding("repeated", ", ".join(places[:5]), "stated again: the first counts", len(places))] if places else []


_TRIPLES = ("xyz", "rpy", "scale")


def _repair_triples(root: Element) -> list[Finding]:
    """Commas between three numbers, and what stands behind them, mean nothing to ROS; MuJoCo refuses them."""
    repaired: list[str] = []
    for element in root.iter():
        for name in _TRIPLES:
            words = element.get(name, "0 0 0").replace(",", " ").split()
            if len(words) > 3 or "," in element.get(name, ""):
                repaired.append(f"{name} of {element.tag}: {element.get(name)}")
                element.set(name, " ".join(words[:3]))
    note = "read as its first three numbers"
    return [Finding("numbers", "; ".join(repaired[:5]), note, len(repaired))] if repaired else []


def _drop_shapes_without_size(root: Element) -> list[Finding]:
    """Spheres of radius 0 and the like, by which some programs mark a place."""
    dropped: list[str] = []
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            sizes = [word for name in ("radius", "length", "size") for one in shape.iterfind("geometry/*")
                     for word in one.get(name, "").split()]  # fmt: skip
            if any(_number(word) == 0.0 for word in sizes):
                link.remove(shape)
                dropped.append(f"{shape.tag} of link {link.get('name', '')}")
    note = "left out: a size of it is zero"
    return [Finding("no-size", ", ".join(dropped[:5]), note, len(dropped))] if dropped else []


_LEAST_INERTIA = 1e-6  # kg m²
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _repair_inertias(root: Element) -> list[Finding]:
    """Make inertias that no body can have positive: MuJoCo's own bound reaches only those without products."""
    repaired: list[str] = []
    for link in root.iter("link"):
        stated = link.find("inertial/inertia")
        values = [] if stated is None else [_number(stated.get(name, "0")) for name in _MOMENTS]
        if stated is None or None in values or not any(values[i] for i in (1, 2, 4)):
            continue
        xx, xy, xz, yy, yz, zz = (value or 0.0 for value in values)
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        moments, axes = np.linalg.eigh(matrix)
        if moments.min() > 0:
            continue
        matrix = axes @ np.diag(np.maximum(moments, _LEAST_INERTIA)) @ axes.T
        rows = (0, 0, 0, 1, 1, 2)
        columns = (0, 1, 2, 1, 2, 2)
        stated.attrib.update({n: repr(float(matrix[i, j])) for n, i, j in zip(_MOMENTS, rows, columns, strict=True)})
        repaired.append(link.get("name", ""))
    note = f"no body can have it: principal moments raised to {_LEAST_INERTIA} kg m²"
    return [Finding("inertia", ", ".join(repaired), note, len(repaired))] if repaired else []


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None  # MuJoCo says what is wrong with it
    return value if np.isfinite(value) else None


def _check_mimics(root: Element) -> list[Finding]:
    """MuJoCo couples ``<mimic>`` joints to their leaders; one whose leader does not move moves by itself."""
    movable = {joint.get("name") for joint in root.iter("joint") if joint.get("type") != "fixed"}
    coupled = list[str]()
    left = list[str]()
    for joint in root.iter("joint"):
        name = joint.get("name", "")
        for mimic in joint.findall("mimic"):
            leader = mimic.get("joint", "")
            if leader in movable and name in movable and leader != name:
                coupled.append(name)
            else:
                joint.remove(mimic)
                left.append(f"{name} of {leader or 'nobody'}")
    findings = (
        [Finding("mimic-joints", ", ".join(coupled), "coupled to their leaders", len(coupled))] if coupled else []
    )
    note = "left out: it mimics a joint that is fixed or does not exist, or is fixed itself"
    return findings + ([Finding("mimic-left-out", ", ".join(left), note, len(left))] if left else [])


def _add_joint_dynamics(spec: mujoco.MjSpec) -> list[Finding]:
    """URDF cannot state armature and often states no damping; without them light links are numerically stiff."""
    bare = 0
    loose = 0
    for joint in spec.joints:
        if joint.armature == 0:
            joint.armature = ARMATURE
            bare = bare + 1
        if joint.damping[0] == 0:
            joint.damping[0] = DAMPING
            loose = loose + 1
    findings = [Finding("armature", "joints", f"given an armature of {ARMATURE} kg m²", bare)] if bare else []
    return findings + (
        [Finding("damping", "joints", f"given a damping of {DAMPING} N m s/rad", loose)] if loose else []
    )
