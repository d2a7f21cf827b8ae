"""Robots from URDF files, with the repairs they usually need before MuJoCo can simulate them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import numpy as np

from tactile_maps.core.errors import Finding, RobotError, add_finding, did_you_mean, errors_in_file, places_finding
from tactile_maps.robots.files.mesh_files import AssetStore, split_scale
from tactile_maps.robots.files.model_files import PackageResolver, files_that_include
from tactile_maps.robots.files.model_limits import check_amounts
from tactile_maps.robots.files.safe_files import parse_model_xml, read_bytes
from tactile_maps.robots.formats.xacro import has_xacro, process_xacro
from tactile_maps.robots.model.build import build_robot
from tactile_maps.robots.model.joint_limits import urdf_limits
from tactile_maps.robots.model.mujoco_spec import parse_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.robots.model.sanitize import settle_missing_meshes

ARMATURE = 0.01  # kg m², or kg for a slide
DAMPING = 0.3  # N m s/rad, or N s/m for a slide
_KEPT = ("link", "joint", "material")
# discardvisual: keeps visual meshes, which is only possible in the text. fusestatic: keeps links behind fixed joints,
# and their names. boundinertia: several iCub models state inertias that are not positive.
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
    home: Mapping[str, float] | None = None,
) -> Robot:
    """Load the robot in a URDF file; see ``read_urdf`` and ``robot_from_urdf``.

    Args:
        path: The file.
        package_roots: Folders with the packages of its ``package://`` addresses.
        home: Joint values of the home posture by joint name [rad, m], chosen by default.

    Raises:
        RobotError: The file cannot be read, names other files, or does not contain a robot that can be simulated.
        MeshError: A mesh is not usable.
    """
    notes: list[Finding] = []
    root = read_urdf(path, package_roots=package_roots, findings=notes)
    return robot_from_urdf(root, path, package_roots=package_roots, home=home, findings=notes)


def read_urdf(path: Path, *, package_roots: Sequence[Path] = (), findings: list[Finding] | None = None) -> Element:
    """Return the checked XML tree of a URDF or xacro file with expanded macros: links, joints and materials only.

    Args:
        path: The file.
        package_roots: Folders with the packages that a xacro includes.
        findings: Receives the repairs.
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
    _check_unique_names(root, path)
    _check_links_of_joints(root, path)
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
    """Return the robot of a URDF tree; converts its meshes and sets armature and damping of its joints.

    Args:
        root: The tree; it is changed.
        path: The file, for relative paths and errors.
        package_roots: Folders with packages.
        name: Short name for the user.
        home: Joint values of the home posture by joint name [rad, m]; chosen by default, see ``choose_home``.
        base_height: Height of the root link above the ground [m].
        base_yaw: Rotation of the root link about the vertical [rad].
        findings: Findings of reading the tree.
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
"""Elements that count once in their parent; of several the first counts, as in ROS."""


def _drop_repeated(root: Element) -> list[Finding]:
    places: list[str] = []
    for parent in root.iter():
        for tag in _ONCE.get(parent.tag, ()):
            for extra in parent.findall(tag)[1:]:
                parent.remove(extra)
                places.append(f"{tag} of {parent.tag} {parent.get('name', '')}".rstrip())
    return places_finding("repeated", places, "stated again: the first counts")


def _check_unique_names(root: Element, path: Path) -> None:
    """Raise RobotError for two links or two joints of one name, which MuJoCo rejects without naming a link."""
    for tag in ("link", "joint"):
        for name, count in Counter(element.get("name", "") for element in root.findall(tag)).items():
            if count > 1 and name:
                remedy = f"Rename all but one, also where other elements name the {tag}, or remove the copies"
                problem = f"{count} {tag}s have the same name"
                raise RobotError(problem, file=path, place=f"{tag} {name}", remedy=remedy)


def _check_links_of_joints(root: Element, path: Path) -> None:
    """Raise RobotError for a joint between links that do not exist, which MuJoCo rejects without a name."""
    links = tuple(link.get("name", "") for link in root.findall("link"))
    for joint in root.findall("joint"):
        for tag in ("parent", "child"):
            element = joint.find(tag)
            link = "" if element is None else element.get("link", "")
            if link not in links:
                problem = f"the {tag} of a joint is not a link of this file"
                place = f"joint {joint.get('name', '')}, {tag}"
                raise RobotError(problem, file=path, place=place, value=link or None, remedy=did_you_mean(link, links))


_TRIPLES = ("xyz", "rpy", "scale")


def _repair_triples(root: Element) -> list[Finding]:
    """Remove commas between three numbers and text after them, which ROS ignores and MuJoCo rejects."""
    repaired: list[str] = []
    for element in root.iter():
        for name in _TRIPLES:
            words = element.get(name, "0 0 0").replace(",", " ").split()
            if len(words) > 3 or "," in element.get(name, ""):
                repaired.append(f"{name} of {element.tag}: {element.get(name)}")
                element.set(name, " ".join(words[:3]))
    return places_finding("numbers", repaired, "read as its first three numbers", separator="; ")


def _drop_shapes_without_size(root: Element) -> list[Finding]:
    """Remove shapes such as spheres of radius 0, which some programs use as markers."""
    dropped: list[str] = []
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            sizes = [
                word
                for name in ("radius", "length", "size")
                for one in shape.iterfind("geometry/*")
                for word in one.get(name, "").split()
            ]
            if any(_number(word) == 0.0 for word in sizes):
                link.remove(shape)
                dropped.append(f"{shape.tag} of link {link.get('name', '')}")
    return places_finding("no-size", dropped, "left out: a size of it is zero")


_LEAST_INERTIA = 1e-6  # kg m²
_MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def _repair_inertias(root: Element) -> list[Finding]:
    """Make impossible inertias positive, because MuJoCo's bound applies only to those without products."""
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
    note = f"impossible inertia: principal moments raised to {_LEAST_INERTIA} kg m²"
    return places_finding("inertia", repaired, note)


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None  # MuJoCo reports the invalid number
    return value if np.isfinite(value) else None


def _check_mimics(root: Element) -> list[Finding]:
    """Report ``<mimic>`` joints, which MuJoCo couples to their leaders, and remove those without a moving leader."""
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
                left.append(f"{name} of {leader or '(unnamed)'}")
    note = "left out: it mimics a joint that is fixed or does not exist, or is fixed itself"
    coupled_finding = places_finding("mimic-joints", coupled, "coupled to their leaders")
    return coupled_finding + places_finding("mimic-left-out", left, note)


def _add_joint_dynamics(spec: mujoco.MjSpec) -> list[Finding]:
    """Set armature, which URDF cannot state, and missing damping; without them light links are numerically stiff."""
    findings = list[Finding]()
    bare = [joint for joint in spec.joints if joint.armature == 0]
    loose = [joint for joint in spec.joints if joint.damping[0] == 0]
    for joint in bare:
        joint.armature = ARMATURE
    for joint in loose:
        joint.damping[0] = DAMPING
    armature = f"set to an armature of {_with_units(ARMATURE, bare, 'kg m²', 'kg')}"
    damping = f"set to a damping of {_with_units(DAMPING, loose, 'N m s/rad', 'N s/m')}"
    add_finding(findings, "armature", "joints", armature, len(bare))
    add_finding(findings, "damping", "joints", damping, len(loose))
    return findings


def _with_units(value: float, joints: Sequence[mujoco.MjsJoint], turning: str, sliding: str) -> str:
    """Return the value with the units of the kinds of ``joints``, as text."""
    slides = {joint.type == mujoco.mjtJoint.mjJNT_SLIDE for joint in joints}
    if len(slides) > 1:
        return f"{value} {turning}, and {value} {sliding} for slides"
    return f"{value} {sliding if True in slides else turning}"
